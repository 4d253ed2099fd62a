"""The commands of the documentation run, page by page, in a small copy of the project.

The guide is followed in both states that users have: before any run, and after one, whose tables
its commands then take. No command of another page looks for results.

A block is run by a shell as it stands. Only four programs are not those of the reader: `make`
plans what it would do, and so does `snakemake` without a target, or without an input of the
reader's own: what is made of those as shipped, the small build of all makes. It does so, too, with
the input of the README, since the guide makes the same figure of another, and, after a run, with
all inputs but the one whose results the guide compares; `pytest` finds files.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import sys

import pytest
import yaml
from tests.docs.blocks import ROOT, blocks
from tests.shared import execute, require
from tests.workflow.conftest import TINY, built, copied  # noqa: F401  a fixture

from study.declared.references import merged
from study.report.site.record import RECORD

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

# Some commands build the same thing again with other inputs.
FEWER = {
    "calibration": {
        "two_stage": {"rate_exponents": [0.0, 1.0], "works_of_adhesion_J_per_m2": [0.7, 3.5]}
    },
    "inference": {"first": 8, "rounds": 2},
}

BLOCKS = blocks("written", "appended", "command", "output")
PROGRAMS = {
    "python": 'exec "$PYTHON" "$@"',
    "microimpact": 'exec "$PYTHON" -m microimpact.cli "$@"',
    "snakemake": 'case "$*" in *my-run.yaml) set -- --dry-run "$@";; *thick.yaml|fig17);; '
    '?*" --configfile "*) [ ! -e results/tables/claims.csv ] || set -- --dry-run "$@";; '
    '*) set -- --dry-run "$@";; esac\n'
    'exec "$PYTHON" -m snakemake --cores 1 "$@"',
    "make": 'exec "$MAKE" --dry-run -C "$ROOT" "$@"',
    "pytest": 'cd "$ROOT"; exec ls "$@"',
}


@pytest.fixture(scope="module")
def shell(request, tmp_path_factory):
    """Run a block in the copy; files of earlier blocks are there."""
    root = copied(tmp_path_factory.mktemp("documented")).root
    shutil.copytree(ROOT / "docs/examples", root / "docs/examples")
    if request.param == "after a run":
        shutil.copytree(request.getfixturevalue("built") / "build/ci", root / "results")
        record = json.loads((root / "results" / RECORD).read_text())
        (root / "results" / RECORD).write_text(json.dumps(record | {"changes": []}))
    (root / "tests").symlink_to(ROOT / "tests")
    small = yaml.safe_load((root / "config/ci.yaml").read_text())
    small.pop("pathvars")
    small = merged(merged(small, TINY), FEWER)
    for path in (root / "config/laboratory.yaml", *(root / "config/analyses").iterdir()):
        content = yaml.safe_load(path.read_text())
        changes = {key: small[key] for key in small if key in content}
        path.write_text(yaml.safe_dump(merged(content, changes), sort_keys=False))
    programs = tmp_path_factory.mktemp("bin")
    for name, text in PROGRAMS.items():
        (programs / name).write_text(f"#!/bin/sh\n{text}\n")
        (programs / name).chmod(0o755)
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | {
        "PATH": f"{programs}:{os.environ['PATH']}",
        "PYTHONPATH": str(root / "src"),
        "PYTHON": sys.executable,
        "MAKE": shutil.which("make") or "make",
        "ROOT": str(ROOT),
        "COLUMNS": "200",
    }

    def run(text):
        command = ["bash", "-euo", "pipefail", "-c", text]
        done = execute(*command, cwd=root, env=environment, check=False)
        return done.returncode, done.stdout + done.stderr

    run.root = root
    return run


@pytest.mark.parametrize(
    ("shell", "page"),
    [
        *(("before a run", page) for page in sorted({block.page for block in BLOCKS})),
        ("after a run", "docs/guide.md"),
    ],
    indirect=["shell"],
)
def test_commands_of_a_page(shell, page):
    own = [block for block in BLOCKS if block.page == page]
    if any("cc" in block.text.split() for block in own):
        require("cc", package="gcc")
    told = ""
    for block, following in zip(own, [*own[1:], None], strict=True):
        path = shell.root / block.path
        if block.task == "written":
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text)
        elif block.task == "appended":
            path.write_text(path.read_text() + block.text)
        elif block.task == "output":
            missing = [line for line in block.text.splitlines() if not printed(line, told)]
            assert not missing, f"{block}: not printed: {missing}\n{told}"
        else:
            code, told = shell(block.text)
            # Where a page shows what is printed, that is the point, be it a complaint.
            shown = following is not None and following.task == "output"
            assert shown or code == 0, f"{block}\n{told}"


def printed(line, told):
    """Tell whether a line was printed; three dots stand for anything."""
    return re.search(".*".join(map(re.escape, line.strip().split("..."))), told) is not None


def test_all_programs_that_a_page_calls_are_known():
    lines = [line for b in BLOCKS if b.task == "command" for line in b.text.splitlines()]
    assert {line.split()[0] for line in lines} <= {*PROGRAMS, "cc"}
