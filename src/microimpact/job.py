"""A job of the workflow with a log: what both of its scripts share."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any


def logged(main: Callable[[Any], str], job: Any) -> int:
    """Run a job and log the line it returns; a failure leaves its full account in the log.

    Parameters
    ----------
    main
        The work; takes the job and returns what is to be logged.
    job
        The object that a script of the workflow is given, with ``log`` and ``rule``.

    Returns
    -------
    int
        Exit code: 0, or 1 after a failure, which is also told in one line.
    """
    log = Path(job.log[0])
    log.parent.mkdir(parents=True, exist_ok=True)
    try:
        log.write_text(main(job), encoding="utf-8")
    except Exception as error:  # noqa: BLE001  whatever a job raises belongs in its log
        log.write_text(traceback.format_exc(), encoding="utf-8")
        sys.stderr.write(f"{job.rule}: {error}\n")
        return 1
    return 0
