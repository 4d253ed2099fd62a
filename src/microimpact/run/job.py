"""A job of the workflow with its log and its cost: what all of its scripts share."""

from __future__ import annotations

import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from microimpact.core.files import (
    remove_checksums,
    require_unaltered,
    write_checksums,
    write_file,
)
from microimpact.run.prefork import hand_over

LOGS = "logs"


def run(main: Callable[[Any], str], job: Any) -> NoReturn:
    """Run a job, in a process that has loaded what it needs if one waits, and exit.

    Parameters
    ----------
    main, job
        As of `logged`. What takes long to import ``main`` imports itself.
    """
    try:
        code = hand_over()
        sys.exit(logged(main, job) if code is None else code)
    except ChildProcessError as error:
        sys.exit(f"{job.rule}: {error}")
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


def logged(main: Callable[[Any], str], job: Any) -> int:
    """Run a job and log the line it returns; a failure leaves its full account in the log.

    Results that the job reads must be as they were written, and what it writes is recorded, so
    that a table that lost its last lines is not taken for a whole one.

    Parameters
    ----------
    main
        The work; takes the job and returns what is to be logged.
    job
        The object that a script of the workflow is given, with ``input``, ``output``, ``log`` and
        ``rule``; its log stands in the folder ``logs`` of the results root, and its cost goes to
        ``log.benchmark``.

    Returns
    -------
    int
        Exit code: 0, or 1 after a failure, which is also told in one line.
    """
    log, began = Path(job.log[0]), time.perf_counter()
    try:
        root = results_root(log)
        require_unaltered(root, job.input)
        remove_checksums(root, job.output)
        account = main(job)
        write_checksums(root, job.output)
        write_file(job.log.benchmark, _cost(time.perf_counter() - began))
        write_file(log, account)
    except Exception as error:  # noqa: BLE001  whatever a job raises belongs in its log
        sys.stderr.write(f"{job.rule}: {error}\n")
        _log_failure(log)
        return 1
    return 0


def _cost(wall: float) -> str:
    """Return time and processor time, s, and largest memory, MB, as Snakemake would tell them."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    processor = used.ru_utime + used.ru_stime
    return f"s\tmax_rss\tcpu_time\n{wall:.4f}\t{used.ru_maxrss / 1024:.2f}\t{processor:.4f}\n"


def results_root(log: Path) -> Path:
    """Return the results root that a log stands in, at any depth of its folder ``logs``.

    Raises
    ------
    ValueError
        If the log stands in no such folder.
    """
    for folder in log.parents:
        if folder.name == LOGS:
            return folder.parent
    raise ValueError(f"{log}: a log must stand in the folder {LOGS} of the results")


def _log_failure(log: Path) -> None:
    try:
        write_file(log, traceback.format_exc())
    except OSError as error:  # the disk that fails the job may fail its log
        sys.stderr.write(f"{error}\n")
