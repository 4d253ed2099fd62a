"""Every code block of the README runs."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys

import pytest
import yaml
from tests.workflow.conftest import ROOT, SMALL

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", README, flags=re.DOTALL | re.MULTILINE)


def lines(kind, first_word):
    found = [line for name, text in BLOCKS if name == kind for line in text.splitlines()]
    return [line for line in found if line.split()[:1] == [first_word]]


def test_every_block_is_of_a_kind_that_is_tested_here():
    assert {kind for kind, _ in BLOCKS} == {"sh", "python", "yaml"}
    words = {line.split()[0] for kind, text in BLOCKS if kind == "sh" for line in text.splitlines()}
    assert words == {"make", "snakemake", "microimpact"}


@pytest.mark.parametrize("text", [text for kind, text in BLOCKS if kind == "python"])
def test_python(text):
    subprocess.run([sys.executable, "-c", text], check=True, timeout=120, capture_output=True)


@pytest.mark.parametrize("line", lines("sh", "microimpact"))
def test_command_line(line):
    command = [sys.executable, "-m", "microimpact.cli", *shlex.split(line)[1:]]
    subprocess.run(command, check=True, timeout=120, capture_output=True)


@pytest.mark.parametrize("line", lines("sh", "make"))
def test_make(line):
    found = subprocess.run(
        ["make", "--dry-run", *line.split()[1:]],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    assert "bin/" in found.stdout


@pytest.mark.workflow
def test_overlay_and_snakemake(project):
    (overlay,) = [text for kind, text in BLOCKS if kind == "yaml"]
    target = yaml.safe_load(overlay)["pathvars"]["results"]
    (project.root / "my-run.yaml").write_text(overlay, encoding="utf-8")
    for line in lines("sh", "snakemake"):
        words = shlex.split(line)[1:]
        if "--configfile" not in words:
            words += SMALL
        project.snakemake(*words, "my-run.yaml")
        assert (project.root / target / "figures/fig20.svg").is_file()
