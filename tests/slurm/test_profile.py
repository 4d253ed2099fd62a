"""The cluster's profile names rules and resources that there are."""

from __future__ import annotations

import re

import yaml
from tests.shared import ROOT

PROFILE = yaml.safe_load((ROOT / "profiles/slurm/config.yaml").read_text(encoding="utf-8"))


def test_every_rule_with_resources_of_its_own_exists():
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "workflow/rules").glob("*.smk")]
    named = r"^\s*(?:use rule \w+ as|rule) (\w+)(?: with)?:"
    rules = set(re.findall(named, "\n".join(texts), flags=re.MULTILINE))
    assert "monte_carlo" in rules
    assert set(PROFILE["set-resources"]) <= rules


def test_every_job_asks_for_memory_and_time():
    defaults = PROFILE["default-resources"]
    assert defaults["mem_mb"] > 0
    assert defaults["runtime"] > 0
    for resources in PROFILE["set-resources"].values():
        assert set(resources) <= {"mem_mb", "runtime"}
        assert all(resources[name] > defaults[name] for name in resources)


def test_the_plugin_is_locked():
    locked = (ROOT / "requirements/slurm.txt").read_text(encoding="utf-8")
    assert re.search(r"^snakemake-executor-plugin-slurm==\d", locked, flags=re.MULTILINE)


def test_the_guide_explains_every_line_of_the_profile():
    guide = (ROOT / "docs/cluster.md").read_text(encoding="utf-8")
    names = {*PROFILE, *PROFILE["default-resources"], "slurm_account", "slurm_partition"}
    names |= {name for resources in PROFILE["set-resources"].values() for name in resources}
    assert not [name for name in names if f"`{name}" not in guide]
