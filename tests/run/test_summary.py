"""The summary of what was built, and the stamp of a run."""

from __future__ import annotations

import json
from datetime import UTC, datetime

from microimpact.run import stamp as runstamp
from microimpact.run import summary


def test_summary_names_what_was_built(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    results = tmp_path / "results"
    for name in ("figures/fig14.svg", "data/fig14.csv", "tables/inputs.csv"):
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).write_text("x" * 1500)
    runstamp.write_stamp(results / "run.json", {"seed": 3}, tmp_path, runstamp.run_date())
    assert summary.main([str(results)]) == 0
    text = capsys.readouterr().out
    assert "fig14" in text
    assert "data/fig14.csv" in text
    assert "3 kB" in text
    assert "run.json" in text


def test_summary_of_nothing_is_an_error(tmp_path, capsys):
    assert summary.main([str(tmp_path)]) == 1
    assert "nothing was built" in capsys.readouterr().out


def test_sizes_are_readable():
    assert [summary.size(n) for n in (0, 999, 1500, 999_600, 2_500_000)] == [
        "0 B",
        "999 B",
        "2 kB",
        "1 MB",
        "2 MB",
    ]


def test_stamp(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert runstamp.run_date() == datetime(1970, 1, 2, tzinfo=UTC)
    seed = {"value": 7, "evidence": "chosen", "source": "x"}
    started = datetime(1969, 12, 31, 23, tzinfo=UTC)
    runstamp.write_stamp(tmp_path / "run.json", {"seed": seed}, tmp_path, started)
    stamp = json.loads((tmp_path / "run.json").read_text())
    assert stamp["seed"] == 7
    assert stamp["started"] == "1969-12-31T23:00:00+00:00"
    assert stamp["ended"] == "1970-01-02T00:00:00+00:00"
    assert stamp["git"] == {"commit": None, "dirty": None}
