"""A copy of the project, built once, in which files may be edited."""

from __future__ import annotations

import os
import re
import shutil
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml
from tests.shared import ROOT, copy_project, execute, made_once

from study.declared.references import merged

SMALL = ("--configfile", "config/ci.yaml")
# Smaller still than the small reproduction: some parts are left with nothing, or nearly so.
TINY = {
    "inference": {"draws": 60},
    "campaign": {"stop": {"events": 4, "fewest_events": 2, "most_dropped": 1000}},
    "interval_coverage": {
        "experiments": 20,
        "events": 4,
        "cases": {
            "smooth, normal": {"speeds_m_per_s": [0.75, 1.25], "simulated": 30000},
            "smooth, oblique": {"simulated": 3000},
            "rough, oblique": {"simulated": 3000},
            "slow, oblique": {"simulated": 3000},
        },
    },
    "fig23_monte_carlo": {
        "plan": {"replicates": 4, "events": 64},
        "slope_inference": {"plan": {"events": 64}},
    },
}


@dataclass
class Project:
    """A project folder and ways to run and to edit it."""

    root: Path

    def call(self, name, *arguments, **environment):
        """Run a module with arguments and return how that went."""
        inherited = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
        command = (sys.executable, "-m", name, *arguments)
        done = execute(*command, cwd=self.root, env=inherited | environment, check=False)
        done.text = done.stdout + done.stderr
        return done

    def snakemake(self, *arguments, check=True, **environment):
        done = self.call("snakemake", "--cores", "1", *arguments, **environment)
        if check and done.returncode:
            raise AssertionError(done.text)
        return done

    def planned(self, *arguments, **environment):
        """Return the names of the rules that a run would execute: not mere targets, as fig17."""
        text = self.snakemake("--dry-run", *arguments, **environment).text
        return set(re.findall(r"^(\w+)  \S", text, flags=re.MULTILINE))

    def done(self, *arguments):
        """Run, and return the names of the rules that were executed."""
        self.snakemake(*arguments)
        *_, account = sorted((self.root / ".snakemake/log").glob("*.log"))
        text = account.read_text(encoding="utf-8")
        logged = r"^(?:local)?rule (\w+):\n(?:    .*\n)*?    log: "
        return set(re.findall(logged, text, flags=re.MULTILINE))

    def files(self, *, under="."):
        """Return all files below a folder, relative to the project."""
        folder = self.root / under
        return {p.relative_to(self.root).as_posix() for p in folder.rglob("*") if p.is_file()}

    @contextmanager
    def edited(self, path, edit):
        """Apply a function to the text of a file while the context lasts."""
        file = self.root / path
        before = file.read_text(encoding="utf-8")
        after = edit(before)
        assert after != before, f"the edit changed nothing in {path}"
        file.write_text(after, encoding="utf-8")
        try:
            yield
        finally:
            file.write_text(before, encoding="utf-8")


def swap(old, new):
    def edit(text):
        assert text.count(old) == 1, f"{old!r} must occur once"
        return text.replace(old, new)

    return edit


def copied(target):
    copy_project(target)
    return Project(target)


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """A project built small into build/ci, once for all workers; nobody edits it.

    Where the environment variable MICROIMPACT_BUILT is set, what stands in build/ci of this
    checkout is taken over; only what is out of date is built again, and the run stamp.
    """

    def build(place):
        project = copied(place)
        arguments = [*SMALL, "--cores", "2"]
        if "MICROIMPACT_BUILT" in os.environ:
            for folder in ("build/ci", ".snakemake/metadata"):
                shutil.copytree(ROOT / folder, project.root / folder)
            arguments += ["--forcerun", "declared_inputs"]
        else:
            file = project.root / "config/ci.yaml"
            file.write_text(yaml.safe_dump(merged(yaml.safe_load(file.read_text()), TINY)))
        project.snakemake(*arguments)

    return made_once(tmp_path_factory, "built", build)


@pytest.fixture(scope="session")
def project(built, tmp_path_factory):
    """The project, built small into build/ci, for the tests of one worker to edit."""
    root = tmp_path_factory.mktemp("project") / "copy"
    shutil.copytree(built, root)
    return Project(root)
