"""Python programs without their start: a process that has imported what they need forks for each.

Importing is half the time of a dry run. The package itself is not imported beforehand, so that a
copy of the project runs its own. Programs that are killed, or whose start is what is tested, are
started as usual.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import NoReturn

IMPORTED = (
    *("snakemake.cli", "snakemake.report", "grimp", "jinja2", "matplotlib.figure", "numba"),
    *("pandas", "pydantic.dataclasses", "rich.table", "scipy.constants", "scipy.special"),
)
# Started for each call, so it does next to nothing.
CLIENT = """
import json, os, socket, sys
server = socket.socket(socket.AF_UNIX)
server.connect(sys.argv[1])
call = json.dumps([os.getcwd(), dict(os.environ), sys.argv[2:]]).encode()
socket.send_fds(server, [len(call).to_bytes(8, "big")], [0, 1, 2])
server.sendall(call)
(code,) = server.recv(1)
sys.exit(code)
"""


@contextmanager
def forking() -> Iterator[tuple[str, ...]]:
    """Yield what stands for ``python`` in ``python -m NAME ...`` as long as the server runs."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    # Threads would not survive a fork.
    environment |= {"OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        address = Path(folder) / "address"
        command = [sys.executable, __file__, str(address)]
        server = subprocess.Popen(command, env=environment, stdin=subprocess.PIPE)
        try:
            while not address.exists():
                assert server.poll() is None, "the server that forks has not started"
                time.sleep(0.02)
            yield (sys.executable, "-I", "-S", "-c", CLIENT, str(address))
        finally:
            server.stdin.close()
            server.wait()


def serve(address: str) -> None:
    """Fork for each client until the standard input ends."""
    for name in IMPORTED:
        import_module(name)
    assert "microimpact" not in sys.modules
    gc.freeze()
    # Nobody waits for those that attend to a client.
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
            client, _ = listener.accept()
            with client:
                if os.fork() == 0:
                    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                    listener.close()
                    attend(client)


def attend(client: socket.socket) -> NoReturn:
    """Run a client's program in a process of its own and return its exit code."""
    size, streams, _, _ = socket.recv_fds(client, 8, 3)
    call = client.recv(int.from_bytes(size, "big"), socket.MSG_WAITALL)
    if program := os.fork():
        _, status = os.waitpid(program, 0)
        client.send(bytes([os.waitstatus_to_exitcode(status) % 256]))
        os._exit(0)
    client.close()
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    folder, environment, (option, name, *arguments) = json.loads(call)
    assert option == "-m"
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[1:] = arguments
    own = environment.get("PYTHONPATH", "").split(os.pathsep)
    sys.path[:1] = [folder, *filter(None, own)]
    code = 0
    try:
        runpy.run_module(name, run_name="__main__", alter_sys=True)
    except SystemExit as end:
        code = end.code or 0
    # As at the end of Python, but for all that was imported: clearing that away takes time.
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    serve(sys.argv[1])
