"""Snakemake on the terminal in brief: one line per finished or planned step, and a bar.

A logger plugin as Snakemake finds them, by the name of this package: ``--logger brief``, set in
``profiles/default``. Snakemake's own full account is in ``.snakemake/log``, and with ``--verbose``
it is printed. Snakemake's quiet modes would leave it out of the file, too, and hide errors.
"""

from __future__ import annotations

import logging
import re
import time
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

# What stands around the words of an error that a Snakefile raises.
_PLACE = re.compile(
    r'^WorkflowError in (rule|file) .*:\n|\n  File ".*", line \d+, in .*$', re.MULTILINE
)
_NO_TARGET = re.compile(r"^MissingRuleException:\nNo rule to produce (\S+)")
_TRACED = re.compile(r"^ +\^+$|^Traceback ", re.MULTILINE)
_NO_FILE = re.compile(r"^FileNotFoundError: .*: '(.*)'$")
# What a failed step has said already, in its own words and by its log.
_REPEATED = (
    "RuleException:\nCalledProcessError",
    "Exiting because",
    "WorkflowError:\nAt least one",
)
_IDLE = "Nothing to be done"
# End of the names of steps that draw: one line for all of them.
_DRAWING = "_figures"
# Letters of a reason that are shown.
_REASON = 80


def _message(error: str) -> str:
    """Return an error without its place in a Snakefile; of a wrong target, the nearest name.

    Of a traceback, as of options that Snakemake itself refuses, its last line.
    """
    if _TRACED.search(error):
        error = error.strip().splitlines()[-1]
        if missing := _NO_FILE.search(error):
            return f"{missing[1]}: no such file (targets stand before --configfile)"
    wrong = _NO_TARGET.search(error)
    if not wrong:
        return _PLACE.sub("", error).strip()
    from microimpact.core.nearest import nearest
    from study import analyses
    from study.figures.declaration import all_figures

    name, known = wrong[1], [*all_figures(), *analyses.homes()]
    near = nearest(name, known) if "/" not in name else "; `snakemake --list` has the names"
    if name in known:
        return f"{name}: left out by figures.leave_out"
    return f"{name}: no figure, rule or file of the study{near}"


class LogHandler(LogHandlerBase):
    """Prints progress, finished and failed steps, warnings, errors and the summary of the run."""

    writes_to_stream = True
    writes_to_file = False
    # Those of Snakemake itself, for what is printed as usual.
    has_filter = False
    has_formatter = False
    needs_rulegraph = False

    def __post_init__(self) -> None:
        """Prepare the bar, which only a terminal shows."""
        self._console = Console(stderr=not self.common_settings.stdout, highlight=False)
        self._bar = Progress(
            TextColumn("steps"),
            MofNCompleteColumn(),
            BarColumn(bar_width=None),
            TimeElapsedColumn(),
            console=self._console,
            transient=True,
            disable=not self._console.is_terminal,
        )
        self._task = self._bar.add_task("steps", total=None)
        self._steps: dict[int, tuple[str, float, list[str]]] = {}
        self._done, self._total, self._drawings = 0, 0, 0
        self._results: Path | None = None
        self._full = self.common_settings.verbose

    def emit(self, record: logging.LogRecord) -> None:
        """Print the line of a record, if it has one."""
        try:
            self._emit(record)
        except Exception:  # noqa: BLE001  as all handlers of the standard library
            self.handleError(record)

    def _emit(self, record: logging.LogRecord) -> None:
        event = getattr(record, "event", None)
        if not self._full and record.getMessage().startswith(_REPEATED):
            return
        if event == LogEvent.ERROR and not self.common_settings.verbose:
            self._print(_message(record.getMessage()))
        elif self._full:
            self._print(self.format(record))
        elif event:
            self._event(event, record)
        elif record.levelno >= logging.WARNING or hasattr(record, "summary"):
            self._print(record.getMessage())
        elif record.getMessage().startswith(_IDLE):
            self._print("Everything is up to date.")
            self._print_standing()
        else:
            # Where results go, and how many steps there are, of these drawings.
            self._results = getattr(record, "results", self._results)
            self._total, self._drawings = getattr(record, "steps", (self._total, self._drawings))

    def _event(self, event: LogEvent, record: logging.LogRecord) -> None:
        fields = record.__dict__
        if event == LogEvent.JOB_INFO:
            parts = fields.get("wildcards") or {}
            name = " ".join([fields["rule_name"], *map(str, parts.values())])
            logs = list(fields.get("log") or [])
            self._steps[fields["jobid"]] = name, time.monotonic(), logs
            if self.common_settings.dryrun and logs:  # a target alone does nothing
                # Digests before and after say nothing.
                reason = " ".join(fields["reason"].split()).partition(": Union of")[0]
                shown = f"{reason[:_REASON]}..." if len(reason) > _REASON else reason
                self._print(f"{name}  {shown}")
        elif event == LogEvent.RUN_INFO and not self.common_settings.dryrun:
            self._bar.start()
        elif event == LogEvent.JOB_FINISHED:
            self._finished(*self._steps.get(fields["job_id"], ("", 0.0, [])))
        elif event == LogEvent.JOB_ERROR:
            name, _, logs = self._steps.get(fields["jobid"], (fields["rule_name"], 0.0, []))
            self._print(f"{name} failed; see {', '.join(logs)}")

    def _finished(self, name: str, began: float, logs: list[str]) -> None:
        if not logs:
            return
        self._done += 1
        self._bar.update(self._task, completed=self._done, total=self._total)
        if name.endswith(_DRAWING):
            self._drawings -= 1
            if self._drawings > 0:
                return
            name = "figures"
        self._print(f"{name}  {time.monotonic() - began:.1f} s  {self._done} of {self._total}")

    def _print_standing(self) -> None:
        """Name the results that stand."""
        from study.run.summary import summary

        if self._results and self._results.is_dir():
            self._print(summary(self._results))

    def _print(self, text: str) -> None:
        self._console.print(text, markup=False, soft_wrap=True)

    def close(self) -> None:
        """Leave the terminal as it was."""
        self._bar.stop()
        super().close()
