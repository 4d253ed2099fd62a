"""Reading: a table that was cut, damaged or edited after it was written is noticed."""

from __future__ import annotations

import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from tests.shared import execute
from workflow.scripts.job import logged

from microimpact.core.files import AlteredError, of_other_inputs, require_unaltered, write_checksums
from microimpact.core.tables import (
    TableError,
    read_figure_data,
    read_table,
    series_frame,
    write_table,
)


@pytest.fixture
def results(tmp_path):
    """A results root with one recorded table of figure data of 5 rows."""
    angles = np.linspace(5.0, 85.0, 5)
    frame = series_frame(
        panel="main",
        series="f = 0.15, rolling",
        evidence="computed",
        x=angles,
        y=np.cos(np.deg2rad(angles)),
        x_unit="deg",
        y_unit="1",
    )
    path = tmp_path / "data/fig17.csv"
    write_table(frame, path)
    write_checksums(tmp_path, [path])
    return tmp_path


@pytest.fixture
def table(results):
    return results / "data/fig17.csv"


def test_a_table_cut_anywhere_is_refused_by_its_reader_or_by_its_checksum(results, table):
    whole = table.read_bytes()
    ends = {n + 1 for n, byte in enumerate(whole) if byte == ord("\n")}
    for size in range(len(whole)):
        table.write_bytes(whole[:size])
        with pytest.raises(AlteredError, match=r"fig17\.csv: not as it was written: cut short"):
            require_unaltered(results, [table])
        if size not in ends:  # there the table itself cannot tell
            with pytest.raises(TableError, match=r"fig17\.csv"):
                read_figure_data(table, "deg", "1")
    table.write_bytes(whole)
    require_unaltered(results, [table])
    assert len(read_figure_data(table, "deg", "1")) == 5


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda text: text.replace(",computed,", ",", 1),
            "line 2: 6 fields where the header has 7",
        ),
        (lambda text: text.replace("main,", "main,main,", 1), "line 2: 8 fields where the header"),
        (lambda text: text.replace(",series,", ",", 1), "line 2: 7 fields where the header has 6"),
        (lambda text: text.replace("x_deg", "x_rad"), "column 'x_deg' is missing, column 'x_rad'"),
        (lambda text: text.replace(",5.0,", ",,", 1), "row 1: x_deg must be a number, got nothing"),
        (
            lambda text: text.replace(",5.0,", ",5.o,", 1),
            "row 1: x_deg must be a number, got '5.o'",
        ),
        (lambda text: text.replace(",85.0,", ",nan,"), "row 5: x_deg must be a number, got 'nan'"),
        (lambda text: text.replace('"', "", 1), "line 2: 8 fields where the header has 7"),
        (lambda text: "", "cut short"),
    ],
)
def test_a_damaged_table_is_named_with_the_place(table, edit, message):
    before = table.read_text()
    after = edit(before)
    assert after != before
    table.write_text(after)
    with pytest.raises(TableError, match=r"fig17\.csv") as error:
        read_figure_data(table, "deg", "1")
    assert message in str(error.value)


def test_bytes_that_are_no_text_are_refused(table):
    table.write_bytes(table.read_bytes().replace(b"main", b"m\xff\x00n", 1))
    with pytest.raises(TableError, match=r"fig17\.csv: no CSV table in UTF-8: "):
        read_table(table)


def job_on(results, **changes):
    files = {
        "rule": "fig17",
        "input": [str(results / "data/fig17.csv"), __file__],
        "output": [str(results / "figures/fig17.txt")],
        "params": {"rests_on": "these inputs"},
        "log": [str(results / "logs/fig17.log")],
    }
    return SimpleNamespace(**files | changes)


def drawn(job):
    (output,) = job.output
    shutil.copyfile(job.input[0], output)
    return "drawn\n"


def test_a_job_refuses_a_changed_input_and_leaves_nothing(results, table, capsys):
    job = job_on(results)
    (results / "figures").mkdir()
    assert logged(drawn, job) == 0
    assert (results / "logs/fig17.log").read_text() == "drawn\n"

    whole = table.read_bytes()
    table.write_bytes(whole[: whole[:-1].rindex(b"\n") + 1])  # a row less
    (results / "figures/fig17.txt").unlink()
    assert logged(drawn, job) == 1
    told = capsys.readouterr().err
    assert told == (
        f"fig17: {table}: not as it was written: cut short, damaged or edited; "
        "delete it and run again\n"
    )
    assert told.removeprefix("fig17: ") in (results / "logs/fig17.log").read_text()
    assert not (results / "figures/fig17.txt").exists()

    table.write_bytes(whole)
    assert logged(drawn, job) == 0


def test_a_job_that_fails_leaves_no_record_of_what_it_was_to_write(results):
    job = job_on(results)
    (results / "figures").mkdir()
    assert logged(drawn, job) == 0
    record = results / "checksums/figures/fig17.txt.sha256"
    assert record.exists()

    def failed(job):
        drawn(job)
        raise ValueError("too steep")

    assert logged(failed, job) == 1
    assert not record.exists()


def test_results_of_other_inputs_are_told(results):
    job = job_on(results)
    (results / "figures").mkdir()
    assert logged(drawn, job) == 0
    name = "figures/fig17.txt"
    assert of_other_inputs(results, {name: "these inputs"}) == []
    assert of_other_inputs(results, {name: "others", "data/fig14.csv": "others"}) == [name]
    # Recorded without a word for its inputs: nothing is known.
    assert of_other_inputs(results, {"data/fig17.csv": "others"}) == []


def test_coreutils_read_the_records(results, table):
    command = "cat $(find checksums -type f) | sha256sum --check"

    write_checksums(results, [table], "inputs in a comment")

    def told():
        return execute("sh", "-c", command, cwd=results, check=False).stdout

    assert told() == "data/fig17.csv: OK\n"
    table.write_text("x")
    assert told() == "data/fig17.csv: FAILED\n"


def test_a_log_outside_of_the_folder_of_logs_is_refused(results, capsys):
    job = job_on(results, log=[str(results / "fig17.log")])
    assert logged(drawn, job) == 1
    assert "must stand in the folder logs" in capsys.readouterr().err


@pytest.mark.parametrize("log", ["logs/fig17.log", "logs/monte_carlo/3.log"])
def test_a_log_may_stand_deeper(results, log):
    (results / "figures").mkdir()
    assert logged(drawn, job_on(results, log=[str(results / log)])) == 0
    assert (results / "checksums/figures/fig17.txt.sha256").exists()
