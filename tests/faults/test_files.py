"""Files: a writer leaves the whole file or the old one; a damaged table is named by its reader."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from tests.shared import execute

from microimpact.core.files import write_file
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
def table(tmp_path):
    """A table of figure data of 5 rows."""
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
    return path


def test_a_table_cut_within_a_row_is_refused(table):
    whole = table.read_bytes()
    ends = {n + 1 for n, byte in enumerate(whole) if byte == ord("\n")}
    for size in set(range(len(whole))) - ends:  # there the table itself cannot tell
        table.write_bytes(whole[:size])
        with pytest.raises(TableError, match=r"fig17\.csv"):
            read_figure_data(table)
    table.write_bytes(whole)
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
