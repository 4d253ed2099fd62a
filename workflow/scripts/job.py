"""A job of the workflow, with its log and the checksums of its results."""

from __future__ import annotations

import gc
import sys
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

LOGS = "logs"

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

    Results that the job reads must be as they were written, and what it writes is recorded, so
    that a table that lost its last lines is not taken for a whole one.

    Parameters
    ----------
    main
        The work; takes the job and returns what is to be logged.
    job
        The object that a script of the workflow is given, with ``input``, ``output``, ``log`` and
        ``rule``; its log stands in the folder ``logs`` of the results root.

    Returns
    -------
    int
        Exit code: 0, or 1 after a failure, which is also told in one line.
    """
    log = Path(job.log[0])
    root = log.parents[[folder.name for folder in log.parents].index(LOGS) + 1]
    try:
        require_unaltered(root, job.input)
        remove_checksums(root, job.output)
        account = main(job)
        write_checksums(root, job.output, job.params.get("rests_on", ""))
        write_file(log, account)
    except Exception as error:
        sys.stderr.write(f"{job.rule}: {error}\n")
        try:
            write_file(log, traceback.format_exc())
        except OSError as failure:  # the disk that fails the job may fail its log
            sys.stderr.write(f"{failure}\n")
        return 1
    return 0
