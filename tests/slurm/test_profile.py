"""The cluster's profile names rules and resources that there are."""

from __future__ import annotations

import re

import yaml
from tests.shared import ROOT

PROFILE = yaml.safe_load((ROOT / "profiles/slurm/config.yaml").read_text(encoding="utf-8"))


def test_rules_of_the_profile_exist_and_ask_for_more_than_the_default():
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "workflow/rules").glob("*.smk")]
    defaults = PROFILE["default-resources"]
    for rule, resources in PROFILE["set-resources"].items():
        assert any(re.search(rf"\b{rule}\b( with)?:", text) for text in texts), rule
        assert all(resources[name] > defaults[name] for name in resources)


def test_the_guide_explains_every_line_of_the_profile():
    guide = (ROOT / "docs/cluster.md").read_text(encoding="utf-8")
    names = {*PROFILE, *PROFILE["default-resources"], "slurm_account", "slurm_partition"}
    names |= {name for resources in PROFILE["set-resources"].values() for name in resources}
    assert not [name for name in names if f"`{name}" not in guide]
