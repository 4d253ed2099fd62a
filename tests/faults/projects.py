"""Copies of the project that are run, killed, damaged and compared."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.shared import copy_project

OUT = "build/ci"

# What starts and ends quickly: numbers come from equations, from random draws, and from the
# declared tables alone; one figure is drawn.
TARGETS = ("fig17", "track_imaging", "declared_inputs")


@dataclass
class Project:
    """A copy of the project; where its small results go; what its environment has of its own."""

    root: Path
    out: str = OUT
    python: tuple[str, ...] = (sys.executable,)
    environment: dict[str, str] = field(default_factory=dict)

    def start(self, *arguments, cores=1):
        """Start Snakemake as the head of a process group of its own."""
        (self.root / "place.yaml").write_text(f"pathvars: {{results: {self.out!r}}}\n", "utf-8")
        inherited = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "MICRO"))}
        command = (*self.python, "-m", "snakemake", "--cores", str(cores), *arguments)
        return subprocess.Popen(
            [*command, "--configfile", "config/ci.yaml", "place.yaml"],
            cwd=self.root,
            env=inherited | self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
        )

    def run(self, *arguments, check=True, timeout=120, cores=1):
        """Run Snakemake to its end and return its words; whatever it started ends with it."""
        process = self.start(*arguments, cores=cores)
        try:
            text, _ = process.communicate(timeout=timeout)
        finally:
            kill(process)
        assert bool(process.returncode) != check, text
        return text

    def results(self):
        """Return the bytes of each result that a reader would see, by its name."""
        top = self.root / self.out
        return {
            path.relative_to(top).as_posix(): path.read_bytes()
            for folder in ("data", "tables", "figures")
            for path in sorted((top / folder).rglob("*"))
            if path.is_file() and not path.name.startswith(".")
        }


def kill(process):
    """Kill a run and all its jobs at once, if they still run."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()


def copied(target, **how):
    """Copy the project and return the copy."""
    copy_project(target)
    return Project(target, **how)
