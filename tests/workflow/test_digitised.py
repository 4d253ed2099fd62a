"""Dropped files of digitised points, all made up: what they have rebuilt, and what they stop."""

from __future__ import annotations

from contextlib import ExitStack, contextmanager

import pytest
from tests.workflow.conftest import SMALL

OUT = "build/ci"
TARGETS = ("fig14", "fig15", "fig16", "fig17", *SMALL)
CONCERNED = {"fig17_coulomb_friction_figures"}
TOP = "# source: made up\n# digitised_by: nobody\nseries,x,y,y_low,y_high\n"

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@contextmanager
def dropped(project, name, rows):
    """Let a file of points lie in its folder while the context lasts."""
    file = project.root / "config/digitised" / name
    file.write_text(TOP + rows)
    try:
        yield file
    finally:
        file.unlink()


def test_a_file_redraws_its_figure_alone_and_so_does_its_removal(project):
    outputs = [project.root / OUT / name for name in ("figures/fig17.svg", "figures/fig17.png")]
    before = [path.read_bytes() for path in outputs]
    with dropped(project, "fig17.csv", "friction: 0.15,30,0.12,,\n") as file:
        assert project.done(*TARGETS) == CONCERNED
        assert all(a != b.read_bytes() for a, b in zip(before, outputs, strict=True))
        log = (project.root / OUT / "logs/fig17_coulomb_friction_figures.log").read_text()
        assert log == "fig17: drawn from fig17, points of config/digitised/fig17.csv\n"
        # another date is no other content
        file.touch()
        assert project.planned(*TARGETS) == set()
    assert project.done(*TARGETS) == CONCERNED
    assert before == [path.read_bytes() for path in outputs]


def test_a_malformed_file_stops_the_run_before_anything_is_written(project):
    root = ("--config", "pathvars={results: build/refused}")
    with ExitStack() as files:
        for name, rows in (
            ("fig17.csv", 'friction: a,30,"0,1",,\n'),
            ("fig014.csv", "a,1,1,,\n"),
            ("fig01.csv", "side: a,1,1,,\n"),
        ):
            files.enter_context(dropped(project, name, rows))
        done = project.snakemake("fig14", *root, check=False)
    assert done.returncode
    for line in (
        "config/digitised/fig17.csv, line 4, y: '0,1' must be a valid number",
        "config/digitised/fig014.csv: must be named for a plot of the article (did you mean",
        "config/digitised/fig01.csv: must be named for a plot of the article",
    ):
        assert [line in told for told in done.text.splitlines()].count(True) == 1
    assert "Traceback" not in done.text
    assert not (project.root / "build/refused").exists()
