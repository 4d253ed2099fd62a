"""Files: a writer leaves the whole file or the old one; a damaged table is named by its reader."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from tests.shared import execute
from workflow.scripts.job import logged

from microimpact.core.files import AlteredError, require_unaltered, write_checksums, write_file
from study.tables import TableError, read_figure_data, series_frame, write_table

WRITER = """
import itertools, sys
from microimpact.core.files import write_file
contents = [bytes([letter]) * 300_000 for letter in b"ab"]
for content in itertools.cycle(contents):
    write_file(sys.argv[1], content)
"""


def test_a_writer_killed_at_random_moments_leaves_a_whole_file(tmp_path):
    path = tmp_path / "table.csv"
    write_file(path, b"a" * 300_000)
    for wait in np.random.default_rng(20011).uniform(0.0, 0.02, 8):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)])
        begun = path.stat().st_mtime_ns
        while path.stat().st_mtime_ns == begun:  # until it writes
            assert writer.poll() is None
            time.sleep(0.001)
        time.sleep(wait)
        writer.send_signal(signal.SIGKILL)
        writer.wait(timeout=60)
        assert path.read_bytes() in (b"a" * 300_000, b"b" * 300_000)
    # The kills met the writer at work; what they left is hidden.
    left = [p.name for p in tmp_path.iterdir() if p != path]
    assert left
    assert all(name.startswith(".table.csv.") for name in left)


def test_a_file_that_finds_no_room_is_named_and_leaves_the_old_one(tmp_path):
    path = tmp_path / "fig17.csv"
    write_file(path, "old\n")
    program = (
        "import resource; from microimpact.core.files import write_file; "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)); "  # of each file, in bytes
        f"write_file({str(path)!r}, 'new' * 1000)"
    )
    last = execute(sys.executable, "-c", program, check=False).stderr.splitlines()[-1]
    assert last == f"OSError: [Errno 27] cannot be written: File too large: '{path}'"
    assert path.read_text() == "old\n"
    assert list(tmp_path.iterdir()) == [path]


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
                read_figure_data(table)
    table.write_bytes(whole)
    require_unaltered(results, [table])
    assert len(read_figure_data(table)) == 5


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda text: text.replace(",computed,", ",", 1),
            "line 2: 6 fields where the header has 7",
        ),
        (
            lambda text: text.replace("x_deg", "deg"),
            "the header is panel, series, evidence, deg",
        ),
        (lambda text: text.replace(",85.0,", ",nan,"), "row 5: x_deg must be a number, got 'nan'"),
    ],
)
def test_a_damaged_table_is_named_with_the_place(table, edit, message):
    before = table.read_text()
    after = edit(before)
    assert after != before
    table.write_text(after)
    with pytest.raises(TableError, match=r"fig17\.csv") as error:
        read_figure_data(table)
    assert message in str(error.value)


def test_a_job_refuses_a_damaged_input_and_leaves_nothing(results, table, capsys):
    output = results / "figures/fig17.txt"
    job = SimpleNamespace(
        rule="fig17",
        input=[str(table), __file__],
        output=[str(output)],
        params={"rests_on": "these inputs"},
        log=[str(results / "logs/fig17.log")],
    )

    def drawn(job):
        write_file(output, "drawn")
        return "drawn\n"

    assert logged(drawn, job) == 0
    output.unlink()
    table.write_text(table.read_text().rpartition("main")[0])  # a row less
    assert logged(drawn, job) == 1
    line = f"{table}: not as it was written: cut short, damaged or edited; delete it and run again"
    assert capsys.readouterr().err == f"fig17: {line}\n"
    assert line in (results / "logs/fig17.log").read_text()
    assert not output.exists()
