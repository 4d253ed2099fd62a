"""The table of times: sums, what comes first, and the chain that decides."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from microimpact.report.commands import timings_command
from microimpact.report.site.record import Rule
from microimpact.report.timings import critical_path, read_timings

HEADER = "s\tcpu_time\tmax_rss\n{}\t{}\t{}\n"
TIMES = {"fit-1-of-2": 9, "fit-2-of-2": 7, "fit": 1, "prior": 4, "drawn": 2, "aside": 10}
RULES = [
    Rule(name="prior", outputs=("tables/prior.csv",)),
    Rule(name="fit", inputs=("tables/prior.csv",), outputs=("data/fit.csv",)),
    Rule(name="drawn", inputs=("data/fit.csv",), outputs=("figures/drawn.svg",)),
    Rule(name="aside", outputs=("tables/aside.csv",)),
]


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "benchmarks"
    folder.mkdir()
    for job, seconds in TIMES.items():
        (folder / f"{job}.tsv").write_text(HEADER.format(seconds, seconds / 2, 100))
    return tmp_path


def test_the_longest_comes_first(results):
    timings = read_timings(results)
    assert [timing.job for timing in timings][:3] == ["aside", "fit-1-of-2", "fit-2-of-2"]
    assert timings[0].processor == 5.0
    assert timings[1].rule == timings[2].rule == "fit"


def test_the_critical_path_holds_one_part_of_each_rule(results):
    path = critical_path(read_timings(results), RULES)
    assert [timing.job for timing in path] == ["prior", "fit-1-of-2", "fit", "drawn"]


def test_a_long_job_by_itself_is_a_path_too(results):
    (results / "benchmarks/aside.tsv").write_text(HEADER.format(17, 17, 100))
    path = critical_path(read_timings(results), RULES)
    assert [timing.job for timing in path] == ["aside"]


def test_the_command_adds_up(results):
    text = CliRunner().invoke(timings_command, [str(results)], catch_exceptions=False).output
    lines = text.splitlines()
    assert lines[1].split() == ["aside", "10.0", "5.0", "100"]
    assert ["drawn", "2.0", "1.0", "100"] in [line.split() for line in lines]
    assert lines[-1].split() == ["all", "6", "jobs", "33.0", "16.5"]


def test_bad_files_are_named(results, tmp_path):
    (results / "benchmarks/fit.tsv").write_text("s\n")
    with pytest.raises(ValueError, match=r"fit\.tsv: not a file of measured times"):
        read_timings(results)
    with pytest.raises(ValueError, match="no measured times"):
        read_timings(tmp_path / "elsewhere")
