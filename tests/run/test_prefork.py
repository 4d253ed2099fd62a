"""Scripts run by forks of a process that waits: as if they had been started by themselves."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from microimpact.run import prefork

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")

SCRIPT = """
import sys
from microimpact.run.prefork import hand_over
code = hand_over()
if code is not None:
    sys.exit(code)
{work}
"""


@pytest.fixture
def waiting():
    """The process that waits, known to all that are started."""
    prefork.start.cache_clear()
    process = prefork.start()
    try:
        yield process
    finally:
        process.stdin.close()
        process.wait()
        del os.environ[prefork.ADDRESS]
        prefork.start.cache_clear()


@pytest.fixture
def script(tmp_path):
    """Return the command that runs some lines, in a fork where a process waits."""

    def command(work, *arguments):
        path = tmp_path / "script.py"
        path.write_text(SCRIPT.format(work=work), encoding="utf-8")
        return [sys.executable, str(path), *arguments]

    return command


def run(command, **options):
    options |= {"capture_output": True, "text": True, "timeout": 60}
    return subprocess.run(command, check=False, **options)


def alive(process):
    """Whether a process runs: not one that has ended and is only not yet forgotten."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in {"Z", "X"}


def eventually(condition):
    end = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


TELL = """
import json, os
from pathlib import Path
told = [sys.argv[1:], str(Path.cwd()), os.environ["TOLD"], sys.stdin.read(), __name__]
print(json.dumps([*told, os.getppid(), sys.path[0]]))
print("aside", file=sys.stderr)
sys.exit(int(sys.argv[1]))
"""


def test_a_script_has_its_own_folder_environment_streams_and_end(waiting, script, tmp_path):
    folder = tmp_path / "größe 1"
    folder.mkdir()
    done = run(
        script(TELL, "7", "ü"), cwd=folder, env=os.environ | {"TOLD": "yes"}, input="in\nput"
    )
    *told, parent, path = json.loads(done.stdout)
    assert told == [["7", "ü"], str(folder), "yes", "in\nput", "__main__"]
    assert parent not in {os.getpid(), 1}
    assert path == str(tmp_path)
    assert done.stderr == "aside\n"
    assert done.returncode == 7


def test_a_script_runs_by_itself_where_none_waits(script, monkeypatch):
    for address in ("", b"\0nobody".hex()):
        monkeypatch.setenv(prefork.ADDRESS, address)
        assert prefork.hand_over() is None
        assert run(script("print('here')")).stdout == "here\n"


@pytest.mark.parametrize(
    ("work", "code", "told"),
    [
        ("sys.exit()", 0, ""),
        ("sys.exit('no')", 1, ""),
        ("raise ValueError('wrong')", 1, "ValueError: wrong"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", 128 + signal.SIGKILL, ""),
    ],
)
def test_ends_are_told(waiting, script, work, code, told):
    done = run(script(work))
    assert done.returncode == code
    assert told in done.stderr


def test_what_a_script_loads_the_next_finds_loaded(waiting, script):
    work = "print('colorsys' in sys.modules); import colorsys; colorsys.mark = 1"
    assert run(script(work)).stdout == "False\n"
    assert run(script(work)).stdout == "True\n"
    # Loaded anew and not taken over: what a script does to a module stays its own.
    assert run(script("import colorsys; print(hasattr(colorsys, 'mark'))")).stdout == "False\n"


def test_files_in_the_folder_of_the_run_are_no_modules(script, tmp_path, monkeypatch, request):
    (tmp_path / "colorsys.py").write_text("raise SystemExit('wrong')\n")
    monkeypatch.chdir(tmp_path)
    request.getfixturevalue("waiting")
    work = "sys.path.pop(0); import colorsys; print(colorsys.rgb_to_hsv(1, 0, 0))"
    assert [run(script(work)).stdout for _ in range(2)] == ["(0.0, 1.0, 1)\n"] * 2


def test_a_module_that_cannot_be_loaded_again_is_left_to_the_scripts(waiting, script, tmp_path):
    (tmp_path / "once.py").write_text("from pathlib import Path\nPath(__file__).unlink()\n")
    assert run(script("import once; print('loaded')")).stdout == "loaded\n"
    assert run(script("print('still here')")).stdout == "still here\n"


SLEEP = "import os, time; print(os.getpid(), flush=True); time.sleep(300)"


def test_a_script_ends_with_the_one_who_asked(waiting, script):
    asking = subprocess.Popen(script(SLEEP), stdout=subprocess.PIPE, text=True)
    process = int(asking.stdout.readline())
    assert process not in {asking.pid, waiting.pid}
    assert alive(process)
    asking.kill()
    asking.wait()
    asking.stdout.close()
    eventually(lambda: not alive(process))
    assert run(script("print('still here')")).stdout == "still here\n"


@pytest.mark.parametrize("end", ["input", "kill"])
def test_all_scripts_end_with_the_process_that_waits(waiting, script, end):
    asking = subprocess.Popen(
        script(SLEEP), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    process = int(asking.stdout.readline())
    if end == "kill":
        waiting.kill()
    else:
        waiting.stdin.close()
    _, told = asking.communicate(timeout=60)
    assert asking.returncode == 1
    assert "ChildProcessError: the process that runs the scripts has ended" in told
    eventually(lambda: not alive(process))
    assert run(script("print('here')")).stdout == "here\n"


def test_several_scripts_run_at_once(waiting, script, tmp_path):
    work = """
import time
from pathlib import Path
mine, other = (Path(name) for name in sys.argv[1:])
mine.touch()
while not other.exists():
    time.sleep(0.01)
"""
    a, b = str(tmp_path / "a"), str(tmp_path / "b")
    both = [subprocess.Popen(script(work, *names)) for names in ((a, b), (b, a))]
    assert [each.wait(timeout=60) for each in both] == [0, 0]


def test_another_user_is_not_served(monkeypatch):
    here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with here, there:
        assert prefork._own(here)
        monkeypatch.setattr(os, "getuid", lambda: os.geteuid() + 1)
        assert not prefork._own(here)


def test_other_systems_do_without(monkeypatch):
    prefork.start.cache_clear()
    monkeypatch.setattr(sys, "platform", "darwin")
    assert prefork.start() is None
    prefork.start.cache_clear()
    monkeypatch.undo()

    def refused(*_):
        raise OSError(38, "not implemented")

    monkeypatch.setattr(os, "pidfd_open", refused)
    assert prefork.start() is None
    prefork.start.cache_clear()
    assert prefork.ADDRESS not in os.environ
