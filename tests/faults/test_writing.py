"""Writing: killed, on a full disk, into a folder that is read-only; and what is left behind."""

from __future__ import annotations

import ast
import signal
import subprocess
import sys
import time

import numpy as np
from tests.faults.places import read_only
from tests.shared import ROOT, execute

from microimpact.core.files import altered_files, write_checksums, write_file
from microimpact.report.check.results import figure_files, table_files

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
    waits = np.random.default_rng(20011).uniform(0.0, 0.02, 8)
    for wait in waits:
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)])
        begun = path.stat().st_mtime_ns
        while path.stat().st_mtime_ns == begun:  # until it writes
            assert writer.poll() is None
            time.sleep(0.001)
        time.sleep(wait)
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        assert path.read_bytes() in (b"a" * 300_000, b"b" * 300_000)
    # The kills met the writer at work; what they left is hidden.
    left = [p.name for p in tmp_path.iterdir() if p != path]
    assert left
    assert all(name.startswith(".table.csv.") for name in left)


def test_what_a_killed_writer_left_is_no_result(tmp_path):
    for name in ("data/.fig14.csv.x1", "data/.fig14.csv", "figures/.fig14.svg", "data/fig17.csv"):
        write_file(tmp_path / name, "a\n")
    write_checksums(tmp_path, [tmp_path / "data/fig17.csv"])
    write_file(tmp_path / "checksums/data/.fig17.csv.sha256.x1", "a")
    assert list(table_files(tmp_path)) == ["data/fig17.csv"]
    assert not figure_files(tmp_path)
    assert not altered_files(tmp_path)


def test_a_file_that_finds_no_room_is_named_and_leaves_the_old_one(tmp_path):
    path = tmp_path / "fig17.csv"
    write_file(path, "old\n")
    program = (
        "import resource; from microimpact.core.files import write_file; "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)); "  # of each file, in bytes
        f"write_file({str(path)!r}, 'new' * 1000)"
    )
    done = execute(sys.executable, "-c", program, check=False)
    last = done.stderr.splitlines()[-1]
    assert last == f"OSError: [Errno 27] cannot be written: File too large: '{path}'"
    assert path.read_text() == "old\n"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_read_only_is_named_by_the_file(tmp_path):
    path = tmp_path / "fig17.csv"
    write_file(path, "old\n")
    program = f"from microimpact.core.files import write_file; write_file({str(path)!r}, 'new')"
    with read_only(tmp_path) as prefix:
        done = execute(*prefix, sys.executable, "-c", program, check=False)
    last = done.stderr.splitlines()[-1]
    assert "cannot be written: " in last
    assert last.endswith(f": '{path}'")
    assert path.read_text() == "old\n"


WRITERS = {
    *("write_text", "write_bytes", "fdopen", "mkstemp", "NamedTemporaryFile", "TemporaryFile"),
    *("savefig", "imsave", "savetxt", "savez", "tofile", "dump", "to_parquet", "to_pickle"),
    *("copyfile", "copy2", "copytree", "move", "rename"),
}


def writing_calls(path):
    """Return the names of all calls in a module that may open a file for writing."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            texts = [a.value for a in node.args if isinstance(a, ast.Constant)]
            # Columns of a table are renamed, too; a file's new name is no keyword.
            renamed = name == "rename" and {k.arg for k in node.keywords} == {"columns"}
            if (name in WRITERS and not renamed) or (
                name == "open" and {"w", "wb", "a", "x", "w+"} & set(texts)
            ):
                yield name


def test_nothing_in_the_package_writes_a_file_in_another_way():
    """Opening for writing, or letting a library do so, would leave half a file when killed."""
    package = ROOT / "src/microimpact"
    found = {
        (path.relative_to(ROOT).as_posix(), call)
        for folder in (package, ROOT / "workflow")
        for path in sorted(folder.rglob("*.py"))
        for call in writing_calls(path)
    }
    assert found == {
        ("src/microimpact/core/files.py", "mkstemp"),
        ("src/microimpact/core/files.py", "fdopen"),
        # Into memory.
        ("src/microimpact/figures/style.py", "savefig"),
        ("src/microimpact/measured/picture.py", "savefig"),
        ("src/microimpact/model/law/export.py", "savez"),
    }
