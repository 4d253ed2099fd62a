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
import shlex
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
    *("snakemake.cli", "snakemake.report", "click", "emcee", "grimp", "jinja2", "numba", "pandas"),
    *("matplotlib.figure", "matplotlib.backends.backend_pdf", "pydantic.dataclasses"),
    *("scipy.constants", "scipy.special"),
)
# Started for each call, so it does next to nothing.
CLIENT = """#!/bin/sh
'''exec' {python} -IS "$0" "$@"
'''
import json, os, socket, sys
server = socket.socket(socket.AF_UNIX)
server.connect(os.path.join(os.path.dirname(sys.argv[0]), "address"))
call = json.dumps([sys.argv[0], os.getcwd(), dict(os.environ), sys.argv[1:]]).encode()
socket.send_fds(server, [len(call).to_bytes(8, "big")], [0, 1, 2])
server.sendall(call)
(code,) = server.recv(1)
sys.exit(code)
"""


@contextmanager
def forking() -> Iterator[tuple[str, ...]]:
    """Yield what stands for ``python`` in ``python -m NAME ...`` as long as the server runs.

    Jobs of a Snakemake that is started so are forked, too.
    """
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    # Threads would not survive a fork.
    environment |= {"OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        address, program = Path(folder) / "address", Path(folder) / "python"
        program.write_text(CLIENT.format(python=shlex.quote(sys.executable)), encoding="utf-8")
        program.chmod(0o755)
        command = [sys.executable, __file__, str(address)]
        server = subprocess.Popen(command, env=environment, stdin=subprocess.PIPE)
        try:
            while not address.exists():
                assert server.poll() is None, "the server that forks has not started"
                time.sleep(0.02)
            yield (str(program),)
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
    sys.executable, folder, environment, arguments = json.loads(call)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    module = arguments.pop(0) if arguments[0] == "-m" else None
    sys.argv[:] = arguments
    own = environment.get("PYTHONPATH", "").split(os.pathsep)
    sys.path[:1] = [folder if module else str(Path(arguments[0]).parent), *filter(None, own)]
    code = 0
    try:
        if module:
            runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)
        else:
            runpy.run_path(arguments[0], run_name="__main__")
    except SystemExit as end:
        code = end.code or 0
    # As at the end of Python, but for all that was imported: clearing that away takes time.
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    serve(sys.argv[1])
