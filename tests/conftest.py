"""What all tests share: contacts, an independent time integration, quick starts."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import settings
from scipy.integrate import solve_ivp
from tests.shared import settings_as_shipped, tables_made_once

from microimpact.core.materials import Material
from microimpact.model.contact import Contact

settings.register_profile("physics", deadline=None, max_examples=60, derandomize=True)
settings.load_profile("physics")


@pytest.fixture(scope="session")
def steel() -> Material:
    return Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.28, density=8000.0)


@pytest.fixture(scope="session")
def silicon() -> Material:
    return Material(name="silicon", youngs_modulus=169e9, poissons_ratio=0.25, density=2330.0)


@pytest.fixture(scope="session")
def contact(steel: Material, silicon: Material) -> Contact:
    """Steel on silicon, adhesive and damped; it captures below about 0.02 m/s."""
    return Contact(
        particle=steel,
        surface=silicon,
        diameter=62e-6,
        work_of_adhesion=0.5,
        hertz_damping=0.01,
        adhesion_damping=3.0,
    )


@pytest.fixture(scope="session")
def scaled(contact: Contact) -> Callable[..., Contact]:
    """Contacts by their damping groups C_H and C_A; speeds are in units of `velocity_scale`."""
    scale = contact.velocity_scale

    def build(c_h: Any = 0.0, c_a: Any = 0.0, **changes: Any) -> Contact:
        return contact.replace(
            hertz_damping=np.asarray(c_h) / scale,
            adhesion_damping=np.asarray(c_a) / scale,
            **changes,
        )

    return build


@dataclass(frozen=True)
class March:
    """A normal impact marched through time; scaled units (velocity scale, equilibrium)."""

    captured: bool
    e: float
    contact_time: float
    compression: float
    compressive_impulse: float
    peak_net_impulse: float


def march(w: float, c_h: float, c_a: float, *, damped_attachment: bool = False) -> March:
    """Integrate the time form x'' = -x^(3/2) (1 + C_H x') + x^(1/2) (1 - C_A x' [x' < 0])."""

    def leg(c_a: float, start: list[float], stop: Any) -> Any:
        def rates(_: float, y: np.ndarray) -> list[float]:
            x, u = max(y[0], 0.0), y[1]
            force = x**1.5 * (1.0 + c_h * u) - np.sqrt(x) * (1.0 - c_a * u)
            return [u, -force, max(force, 0.0)]

        stop.terminal = True
        return solve_ivp(
            rates, (0.0, 1e3), start, "DOP853", rtol=1e-12, atol=1e-14, events=stop, max_step=0.05
        )

    def turned(_: float, y: np.ndarray) -> float:
        return float(y[1])

    def parted(_: float, y: np.ndarray) -> float:
        fallen = y[1] ** 2 / 2 + 0.4 * max(y[0], 0.0) ** 2.5 - 2 / 3 * max(y[0], 0.0) ** 1.5
        return min(float(y[0]), float(fallen) + 1e-9)

    first = leg(c_a if damped_attachment else 0.0, [0.0, w, 0.0], turned)
    second = leg(c_a, [first.y[0, -1], -1e-300, first.y[2, -1]], parted)
    x, u, impulse = second.y[:, -1]
    captured = x > 1e-6
    return March(
        captured=captured,
        e=0.0 if captured else -u / w,
        contact_time=np.inf if captured else first.t[-1] + second.t[-1],
        compression=first.y[0, -1],
        compressive_impulse=impulse,
        peak_net_impulse=w - second.y[1].min(),
    )


@pytest.fixture(scope="session")
def time_form() -> Callable[..., March]:
    return march


# Smaller than as shipped, for speed; large enough for what is asserted.
SMALLER = {
    "inference": {"points": 31},
    "rolling_dissipation": {"points": 9},
}


@pytest.fixture(scope="session", name="settings")
def _settings():
    return settings_as_shipped()


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """The function that gives the tables of an earlier study; studies that need some take these."""

    from study import run_study

    @cache
    def tables(name):
        def make():
            return run_study(name, **SMALLER.get(name, {}))

        return tables_made_once(tmp_path_factory, name, make)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("study.run.study._made", tables)
        yield tables


def pytest_collection_modifyitems(items):
    """Put the longest files first: workers, given files, then end at about the same time.

    What is imported by now stays; a collector that looks through it again and again takes time.
    """
    gc.freeze()
    gc.set_threshold(1_000_000)

    def order(item):
        return [item.get_closest_marker(mark) is None for mark in ("workflow", "slow")]

    items.sort(key=order)
