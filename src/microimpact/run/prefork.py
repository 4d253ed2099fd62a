"""Scripts run by copies of a process that has loaded, before, what they need.

Loading NumPy, pandas, Matplotlib and Numba takes longer than many a job has to work. So one process
waits beside a run; a script that begins asks it to fork, and the fork runs the script in the folder
and environment of the asking process and on its streams. What modules a script had to load, the
waiting process loads thereafter, so that the next fork finds them.

Where no process waits (another machine, another system, one script alone) a script runs by itself
and gives the same. Needs Linux: the address is one of its abstract sockets, which leaves no file.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import runpy
import selectors
import signal
import socket
import struct
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NoReturn

ADDRESS = "MICROIMPACT_PREFORK"
_STREAMS = (0, 1, 2)
# Messages have bounds, and their ends are seen.
_KIND = socket.SOCK_SEQPACKET if sys.platform == "linux" else socket.SOCK_STREAM
_LONGEST = 1 << 20  # bytes of a message
_FORKED = b"forked"
_PR_SET_PDEATHSIG = 1  # of <sys/prctl.h>


@cache
def start() -> subprocess.Popen[bytes] | None:
    """Start the process that waits, and let all processes begun from now on know of it.

    Returns
    -------
    Popen or None
        When its standard input is closed, be it by the end of the present process, it ends with
        all it runs. None where the system cannot do it.
    """
    if not _able():
        return None
    with socket.socket(socket.AF_UNIX, _KIND) as listener:
        listener.bind("")
        listener.listen()
        # -P: what lies in the folder of the run is no library.
        command = [sys.executable, "-P", "-m", __name__, str(listener.fileno())]
        waiting = subprocess.Popen(command, stdin=subprocess.PIPE, pass_fds=[listener.fileno()])
        os.environ[ADDRESS] = listener.getsockname().hex()
    return waiting


def _able() -> bool:
    if sys.platform != "linux":
        return False
    try:
        os.close(os.pidfd_open(os.getpid()))  # Linux 5.3, and not all that pass for it
        os.listdir("/proc/self/fd")  # noqa: PTH208
    except OSError:
        return False
    return True


def hand_over() -> int | None:
    """Let a fork of the process that waits run the present script.

    Returns
    -------
    int or None
        Exit code of the script, once it has ended; None if no process waits, so that the script
        has to run here.

    Raises
    ------
    ChildProcessError
        If the process that waits ends before the script.
    """
    address = os.environ.get(ADDRESS)
    if not address:
        return None
    message = json.dumps([sys.argv, str(Path.cwd()), dict(os.environ)]).encode()
    with socket.socket(socket.AF_UNIX, _KIND) as connection:
        try:
            connection.connect(bytes.fromhex(address))
            if not _own(connection):
                return None
            socket.send_fds(connection, [message], _STREAMS)
            if connection.recv(_LONGEST) != _FORKED:
                return None
        except OSError:
            return None
        answer = connection.recv(_LONGEST)
    if not answer:
        raise ChildProcessError("the process that runs the scripts has ended")
    return int(answer)


def _own(connection: socket.socket) -> bool:
    """Return whether the other end is a process of the same user: an address is no secret."""
    size = struct.calcsize("3i")
    _, user, _ = struct.unpack("3i", connection.getsockopt(_LEVEL, _PEER, size))
    return bool(user == os.getuid())


_LEVEL, _PEER = socket.SOL_SOCKET, getattr(socket, "SO_PEERCRED", 0)


@dataclass(frozen=True, slots=True)
class _Fork:
    """A script that runs: its process, who asked for it, and the file for the modules it loads."""

    process: int
    asking: socket.socket
    loaded: int


def serve(listener: socket.socket) -> None:
    """Fork for every script that asks, until the standard input ends."""
    # A key pressed at the terminal reaches the scripts and the workflow; these decide.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with selectors.DefaultSelector() as events:
        events.register(sys.stdin, selectors.EVENT_READ)
        events.register(listener, selectors.EVENT_READ)
        while True:
            for key, _ in events.select():
                if key.fileobj is sys.stdin:
                    return _end(events)
                if key.fileobj is listener:
                    _accept(listener, events)
                elif key.fileobj is key.data.asking:
                    _abandon(key.data, events)
                else:
                    _finish(key, events)


def _accept(listener: socket.socket, events: selectors.BaseSelector) -> None:
    connection, _ = listener.accept()
    message, streams = b"", list[int]()
    if _own(connection):
        with suppress(OSError):
            message, streams, _, _ = socket.recv_fds(connection, _LONGEST, len(_STREAMS))
    if not message:
        connection.close()
        return
    loaded = os.memfd_create("loaded")
    gc.freeze()  # what all forks share should not be touched by their collectors
    process = os.fork()
    if process == 0:
        _run(message, streams, loaded)
    for stream in streams:
        os.close(stream)
    fork = _Fork(process, connection, loaded)
    events.register(os.pidfd_open(process), selectors.EVENT_READ, fork)
    events.register(connection, selectors.EVENT_READ, fork)
    with suppress(OSError):  # gone: its end is the next event
        connection.send(_FORKED)


def _abandon(fork: _Fork, events: selectors.BaseSelector) -> None:
    """End a fork that nobody waits for any more: the script that asked was killed."""
    with suppress(KeyError, ValueError):  # ended in the meantime
        events.unregister(fork.asking)
        os.kill(fork.process, signal.SIGKILL)


def _finish(key: selectors.SelectorKey, events: selectors.BaseSelector) -> None:
    """Tell the exit code of a fork that has ended, and load what it had to load."""
    fork: _Fork = key.data
    _, status = os.waitpid(fork.process, 0)
    code = os.waitstatus_to_exitcode(status)
    with suppress(KeyError):
        events.unregister(fork.asking)
    with fork.asking, suppress(OSError):  # gone, too
        fork.asking.send(b"%d" % (code if code >= 0 else 128 - code))  # as shells tell a signal
    events.unregister(key.fileobj)
    os.close(key.fd)
    with os.fdopen(fork.loaded) as file:
        file.seek(0)
        names = file.read().split()
    for name in names:
        # Made by others under names of their own, or broken: then the scripts will say so.
        with suppress(Exception):
            import_module(name)


def _end(events: selectors.BaseSelector) -> None:
    for key in list(events.get_map().values()):
        if isinstance(key.data, _Fork):
            with suppress(ProcessLookupError):
                os.kill(key.data.process, signal.SIGKILL)


def _run(message: bytes, streams: list[int], loaded: int) -> NoReturn:
    """Run a script in the present process, a fork, as Python would."""
    code = 1
    try:
        before = set(sys.modules)
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)  # end with the parent
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for own, stream in zip(_STREAMS, streams, strict=True):
            os.dup2(stream, own)
        # An end of a connection that a fork kept open would not be seen by the other.
        for number in map(int, os.listdir("/proc/self/fd")):  # noqa: PTH208
            if number not in {*_STREAMS, loaded}:
                with suppress(OSError):
                    os.close(number)
        arguments, folder, environment = json.loads(message)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        del os.environ[ADDRESS]
        sys.argv = arguments
        sys.path.insert(0, os.path.dirname(arguments[0]))  # noqa: PTH120
        code = _exit_code(arguments[0])
        names = [name for name in sys.modules if name not in before and name != "__main__"]
        with os.fdopen(loaded, "w") as file:
            file.write("\n".join(names))
    finally:
        with suppress(OSError):  # a closed pipe
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _exit_code(script: str) -> int:
    try:
        runpy.run_path(script, run_name="__main__")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:  # noqa: BLE001  told as Python tells it
        sys.excepthook(*sys.exc_info())
        return 1
    return 0


if __name__ == "__main__":
    serve(socket.socket(fileno=int(sys.argv[1])))
