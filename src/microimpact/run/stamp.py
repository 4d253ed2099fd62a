"""The stamp of a run: what was run, with which versions, from which commit, and when."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from microimpact.core.files import write_file
from microimpact.declared.provenance import plain

PACKAGES = (
    "microimpact",
    "numpy",
    "scipy",
    "pandas",
    "matplotlib",
    "numba",
    "pydantic",
    "snakemake",
)


def write_stamp(
    path: Path | str, config: Mapping[str, Any], project: Path | str, started: datetime
) -> None:
    """Write the stamp of a run that ends now, as JSON.

    Parameters
    ----------
    path
        The file to write.
    config
        The merged configuration of the run.
    project
        Root of the project, whose commit is recorded.
    started
        When the run began, see `run_date`.
    """
    stamp = {
        "started": started.isoformat(),
        "ended": run_date().isoformat(),
        "git": git_state(Path(project)),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "packages": package_versions(),
        "seed": plain(config.get("seed")),
        "config": config,
    }
    write_file(path, json.dumps(stamp, indent=2, ensure_ascii=False, default=str) + "\n")


def run_date() -> datetime:
    """Return the date of SOURCE_DATE_EPOCH, or the present one, in UTC to the second."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch:
        return datetime.fromtimestamp(int(epoch), UTC)
    return datetime.now(UTC).replace(microsecond=0)


def package_versions() -> dict[str, str | None]:
    """Return the versions of the packages that decide numbers and pictures."""
    found: dict[str, str | None] = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


def git_state(project: Path) -> dict[str, str | bool | None]:
    """Return commit and dirty flag of a project; both None if it is no git checkout."""
    top = _git(project, "rev-parse", "--show-toplevel")
    # A project copied into some other repository has no commit of its own.
    if top is None or Path(top).resolve() != project.resolve():
        return {"commit": None, "dirty": None}
    status = _git(project, "status", "--porcelain")
    return {
        "commit": _git(project, "rev-parse", "--verify", "HEAD"),
        "dirty": None if status is None else bool(status),
    }


def _git(project: Path, *arguments: str) -> str | None:
    try:
        done = subprocess.run(
            ["git", "-C", str(project), *arguments],
            capture_output=True,
            text=True,
            check=True,
            timeout=30,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
