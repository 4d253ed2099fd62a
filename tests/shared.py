"""What several tests share: made once by the worker that needs it first, or declared here."""

from __future__ import annotations

import fcntl
import os
import shutil
import signal
import subprocess
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from microimpact.lab.dispenser import Dispenser
from microimpact.model import passes

if TYPE_CHECKING:
    import pandas as pd

    from study.run.config import Settings

ROOT = Path(__file__).parents[1]
# What a copy needs to be run.
PARTS = ("Snakefile", "config", "profiles", "src", "workflow")

# A needle that lets spheres fall straight down from rest, and one like the declared.
STILL = Dispenser(
    exit_speed_m_per_s=0.0,
    lateral_speed_m_per_s=0.0,
    lateral_position_mm=0.0,
    taps_per_s=2.0,
    particles_per_tap=3.0,
    release_delay_ms=20.0,
)
USUAL = Dispenser(
    exit_speed_m_per_s=0.15,
    lateral_speed_m_per_s=0.01,
    lateral_position_mm=0.15,
    taps_per_s=2.0,
    particles_per_tap=3.0,
    release_delay_ms=20.0,
)


@cache
def shipped() -> dict[str, Any]:
    """Return the configuration as shipped; nobody changes it."""
    from study.run.config import read_configuration

    return read_configuration(ROOT / "config")


@cache
def settings_as_shipped() -> Settings:
    """Return what the configuration as shipped makes of all studies."""
    from study.run.config import validate

    return validate(shipped(), shipped())


def made_once(folders: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a path that a function fills, once for all workers; nobody changes what is there."""
    base = folders.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    place, finished = base / name, base / f"{name}.finished"
    with (base / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not finished.exists():
            make(place)
            finished.touch()
    return place


def require(*programs: str, package: str) -> None:
    """Skip a test without programs; where MICROIMPACT_REQUIRE_TOOLS is set, as in CI, fail it."""
    if missing := [name for name in programs if shutil.which(name) is None]:
        end = pytest.fail if os.environ.get("MICROIMPACT_REQUIRE_TOOLS") else pytest.skip
        end(f"needs {' and '.join(missing)}; on Debian: apt install {package}")


def execute(*command, check=True, timeout=1200, **options) -> subprocess.CompletedProcess[str]:
    """Run a program; it and all that it started end after a time limit, in s.

    No other module starts programs, but those that kill them: `make lint` sees to it.
    """
    with subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
        **options,
    ) as process:
        try:
            stdout, stderr = process.communicate(timeout=timeout)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    assert not (check and process.returncode), stdout + stderr
    return subprocess.CompletedProcess(command, process.returncode, stdout, stderr)


def copy_project(target: Path, *parts: str) -> None:
    """Copy what a run needs, and more; compiled code comes along: its dates are kept."""
    target.mkdir(parents=True, exist_ok=True)
    for part in (*PARTS, *parts):
        copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy2
        copy(ROOT / part, target / part)


def facet_rebound(velocity, spin_speed, normal, e, friction):
    """Velocity and r omega (n, 3), m/s, after rebounds of rigid spheres from facets."""
    after, turned = np.empty_like(velocity), np.empty_like(velocity)
    passes.rebounds(velocity, spin_speed, normal, e, friction, after, turned)
    return after, turned


def tables_made_once(
    folders: pytest.TempPathFactory, name: str, make: Callable[[], dict[str, pd.DataFrame]]
) -> dict[str, pd.DataFrame]:
    """Return tables that are made once for all workers, as they are read from files."""
    from study.tables import parse_table

    def write(place: Path) -> None:
        place.mkdir()
        for table, rows in make().items():
            rows.to_csv(place / f"{table}.csv", index=False)

    place = made_once(folders, name, write)
    return {path.stem: parse_table(path.read_text()) for path in sorted(place.glob("*.csv"))}
