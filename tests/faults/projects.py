"""Copies of the project that are run, killed, damaged and compared."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PARTS = ("Snakefile", "config", "profiles", "src", "workflow")
OUT = "build/ci"

# A part of the study that starts and ends quickly: its numbers come from equations, from random
# draws, and from the declared tables alone.
STUDIES = ("restitution_trends", "coulomb_friction", "track_imaging", "pair_search")
STUDIES += ("declared_inputs",)
RULE_FILES = ("common", "inputs", "models", "laboratory", "figures")
TARGETS = ("fig17", "ptis_accuracy", "declared_inputs")


@dataclass
class Project:
    """A copy of the project; where its small results go; what its environment has of its own.

    What stands for ``python`` may be the quick start of the fixture `forked`, but where the run is
    killed or another environment is what is tested.
    """

    root: Path
    out: str = OUT
    python: tuple[str, ...] = (sys.executable,)
    environment: dict[str, str] = field(default_factory=dict)

    def command(self, *arguments, cores=1, also=()):
        overlay = self.root / "place.yaml"
        overlay.write_text(f"pathvars: {{results: {self.out!r}}}\n", encoding="utf-8")
        configuration = ("--configfile", "config/ci.yaml", overlay.name, *also)
        return [
            *(*self.python, "-m", "snakemake", "--cores", str(cores), *arguments),
            *configuration,
        ]

    def start(self, *arguments, prefix=(), **how):
        """Start Snakemake as the head of a process group of its own."""
        inherited = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "MICRO"))}
        return subprocess.Popen(
            [*prefix, *self.command(*arguments, **how)],
            cwd=self.root,
            env=inherited | self.environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
        )

    def run(self, *arguments, check=True, timeout=120, **how):
        """Run Snakemake to its end and return what it said."""
        return finished(self.start(*arguments, **how), check=check, timeout=timeout)

    def results(self, *folders):
        """Return the bytes of each result that a reader would see, by its name."""
        top = self.root / self.out
        return {
            path.relative_to(top).as_posix(): path.read_bytes()
            for folder in folders or ("data", "tables", "figures")
            for path in sorted((top / folder).rglob("*"))
            if path.is_file() and not path.name.startswith(".")
        }


def finished(process, *, check=True, timeout=120):
    """Wait for a run; return what it said. Whatever it started ends with the wait."""
    try:
        text, _ = process.communicate(timeout=timeout)
    finally:
        kill(process)
    assert bool(process.returncode) != check, text
    return text


def kill(process):
    """Kill a run and all its jobs at once, if they still run."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()


def copied(target, *, whole=False, **how):
    """Copy the project, or the part of it with `STUDIES`, and return the copy.

    Compiled code comes along: dates are kept, so it stays valid.
    """
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, target / part)
        else:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / part, target / part)
    if not whole:
        _leave_a_part(target)
    return Project(target, **how)


def _leave_a_part(root):
    """Take out of a copy all studies but `STUDIES`, with their rules, numbers and figures."""
    homes = (root / "src/microimpact/studies").glob("*/[!_]*")
    others = {path.stem: path for path in homes if path.stem not in STUDIES}
    for path in others.values():
        shutil.rmtree(path) if path.is_dir() else path.unlink()

    def is_kept(key, entry):
        return key not in others and not (isinstance(entry, dict) and entry.get("study") in others)

    for name in ("config.yaml", "ci.yaml", "figures.yaml"):
        path = root / "config" / name
        entries = yaml.safe_load(path.read_text(encoding="utf-8"))
        kept = {key: entry for key, entry in entries.items() if is_kept(key, entry)}
        path.write_text(yaml.safe_dump(kept, sort_keys=False), encoding="utf-8")

    snakefile = root / "Snakefile"
    lines = snakefile.read_text(encoding="utf-8").splitlines(keepends=True)
    included = {f'include: "workflow/rules/{name}.smk"\n' for name in RULE_FILES}
    kept = [line for line in lines if not line.startswith("include: ") or line in included]
    assert len(lines) - len(kept) > len(included)
    snakefile.write_text("".join(kept), encoding="utf-8")
