"""The summary of what was built, and the stamp of a run."""

from __future__ import annotations

import json
from datetime import UTC, datetime

import pytest
from tests.shared import execute

from study.run import stamp as runstamp
from study.run.summary import summary
from study.tables import not_computed, write_table


def test_a_whole_run_in_a_few_lines(tmp_path):
    names = ["tables/claims.csv", "tables/equations.csv", "report/index.html"]
    names += [f"figures/fig{n:02d}.{kind}" for n in range(1, 26) for kind in ("svg", "png")]
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("verdict\nreproduced\nnot reproduced\nreproduced\n")
    # After a run that made all, and after one that found nothing to do.
    for made in (names, ()):
        assert summary(tmp_path, made).splitlines() == [
            f"In {tmp_path}: 25 in figures/, 2 in tables/.",
            "Claims of the article: 2 reproduced, 1 not reproduced.",
            "Its equations: 2 reproduced, 1 not reproduced.",
            f"Open {tmp_path}/report/index.html",
        ]


FIGURE = ["figures/fig20.svg", "figures/fig20.png"]


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (["data/fig20.csv", *FIGURE], "data/fig20.csv, figures/fig20.svg"),
        ([*FIGURE, *(f"data/{n}.csv" for n in range(6))], "figures/fig20.svg, 6 in data/"),
    ],
)
def test_few_files_are_named(tmp_path, made, told):
    assert summary(tmp_path, made) == f"In {tmp_path}: {told}."


def test_what_could_not_be_computed_is_told_once(tmp_path):
    made = ["tables/a.csv", "data/b.csv"]
    for name in made:
        write_table(not_computed("calibration.latex: no solution"), tmp_path / name)
    (tmp_path / "tables/c.csv").write_text("case,problem\nfast,\nslow,no event\n")
    lines = summary(tmp_path, [*made, "tables/c.csv"]).splitlines()
    assert lines[1:] == ["Not computed: calibration.latex: no solution.", "Not computed: no event."]


def test_stamp(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert runstamp.run_date() == datetime(1970, 1, 2, tzinfo=UTC)
    seed = {"value": 7, "evidence": "chosen", "source": "x"}
    started = datetime(1969, 12, 31, 23, tzinfo=UTC)
    path, config = tmp_path / "run.json", {"seed": seed}
    runstamp.write_stamp(path, config, tmp_path, started)
    # A run that is killed leaves this.
    assert json.loads(path.read_text())["ended"] is None
    ended = runstamp.run_date()
    runstamp.write_stamp(path, config, tmp_path, started, ended=ended)
    stamp = json.loads((tmp_path / "run.json").read_text())
    assert stamp["seed"] == 7
    assert stamp["started"] == "1969-12-31T23:00:00+00:00"
    assert stamp["ended"] == "1970-01-02T00:00:00+00:00"
    assert stamp["git"] == {"commit": None, "dirty": None}


def test_only_what_decides_results_makes_a_commit_dirty(tmp_path):
    def git(*arguments):
        identity = ("-c", "user.name=a", "-c", "user.email=a@b")
        return execute("git", "-C", str(tmp_path), *identity, *arguments).stdout.strip()

    (tmp_path / "src").mkdir()
    (tmp_path / "src/code.py").write_text("x = 1\n")
    git("init", "-q")
    git("add", ".")
    git("commit", "-q", "-m", "a")
    (tmp_path / "my-run.yaml").write_text("seed: 1\n")
    commit = git("rev-parse", "HEAD")
    assert runstamp.git_state(tmp_path) == {"commit": commit, "dirty": False}
    for file in ("src/code.py", "src/new.py"):
        (tmp_path / file).write_text("x = 2\n")
        assert runstamp.git_state(tmp_path) == {"commit": commit, "dirty": True}
        git("stash", "-q")


def test_an_overlay_that_changes_inputs_needs_a_folder_of_its_own():
    base = {"friction": {"f": 0.1, "surface": "silicon"}}
    for change in ({"f": 0.2}, {"surface": "glass"}):
        changed = base | {"friction": base["friction"] | change}
        with pytest.raises(
            ValueError, match=r"pathvars\.results: the overlay changes friction\."
        ) as e:
            runstamp.require_own_root(changed, base)
        assert "pathvars: {results: build/my-run}" in str(e.value)
        runstamp.require_own_root(changed | {"pathvars": {"results": "build/x"}}, base)
        with pytest.raises(ValueError, match="not 'results'"):
            runstamp.require_own_root(changed | {"pathvars": {"results": "./results/"}}, base)
    runstamp.require_own_root(base, base)


@pytest.mark.parametrize("name", ["", "src", "file", "new/{x}", "~/new"])
def test_results_go_where_nothing_else_is(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "src").mkdir()
    (tmp_path / "src/code.py").write_text("x")
    (tmp_path / "file").write_text("x")
    with pytest.raises(ValueError, match=r"pathvars\.results: .* must be a new or empty folder"):
        runstamp.require_results_folder(name)
    (tmp_path / "src/run.json").write_text("{}")
    (tmp_path / "killed").mkdir()
    (tmp_path / "killed/.run.json.abc").write_text("{")
    for usable in ("src", "new/folder", "killed", tmp_path / "other"):
        runstamp.require_results_folder(usable)
