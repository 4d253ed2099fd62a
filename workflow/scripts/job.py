"""A job of the workflow, with its log."""

from __future__ import annotations

import gc
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

import digests

from microimpact.core.files import write_file

PROJECT = Path(__file__).parents[2]

# A job is over before the memory that only the collector would find is missed.
gc.disable()


def run(main: Callable[[Any], str], job: Any) -> NoReturn:
    """Run a job and exit; ``main`` and ``job`` are those of `logged`."""
    try:
        code = logged(main, job)
    except KeyboardInterrupt:
        code = 130
    # Else the collector would look through all modules at the end, a quarter of a second.
    gc.freeze()
    sys.exit(code)


def logged(main: Callable[[Any], str], job: Any) -> int:
    """Run a job and log the line it returns; a failure leaves its full account in the log.

    Its code must be that which its results are recorded with, before and after: it may have been
    edited since the run began.

    Parameters
    ----------
    main
        The work; takes the job and returns what is to be logged.
    job
        The object that a script of the workflow is given, with ``log`` and ``rule``; the digests of
        its files are ``params.code``.

    Returns
    -------
    int
        Exit code: 0, or 1 after a failure, which is also told in one line.
    """
    log = Path(job.log[0])
    try:
        require_recorded_code(job.params.code)
        account = main(job)
        require_recorded_code(job.params.code)
        write_file(log, account)
    except Exception as error:
        sys.stderr.write(f"{job.rule}: {error}\n")
        try:
            write_file(log, traceback.format_exc())
        except OSError as failure:  # the disk that fails the job may fail its log
            sys.stderr.write(f"{failure}\n")
        return 1
    return 0


def require_recorded_code(recorded: Mapping[str, str]) -> None:
    """Raise RuntimeError, naming the files, if code is not as the run found it at its start."""
    if edited := digests.changed(PROJECT, recorded):
        raise RuntimeError(f"edited while the run went on: {', '.join(edited)}; run again")
