"""Impacts and settings for the tests of the imaging system."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from microimpact.lab.events import Impacts
from microimpact.lab.ptis.experiment import ImagedEvents, modelled
from microimpact.lab.ptis.system import ImagingSystem, Setup, Systematics, event_generator

DIAMETER = 62e-6

INSTRUMENT = ImagingSystem(
    frame_px=(640, 480),
    pixel_um=10.0,
    fields_per_s=60.0,
    sheet_thickness_mm=1.0,
    slots=10,
    duty=0.5,
    largest_chop_kHz=5.0,
    dash_pitch_mm=0.4,
    jitter=0.002,
    blur_px=1.0,
    background_counts=20.0,
    least_peak_counts=120.0,
    largest_peak_counts=250.0,
    read_noise_counts=4.0,
    electrons_per_count=100.0,
    rate_error=0.005,
    scale_error=0.005,
    angle_error_deg=0.25,
    least_dashes=4,
)
STEADY = replace(INSTRUMENT, jitter=0.0)
NOISELESS = replace(STEADY, read_noise_counts=0.0, electrons_per_count=1e12)


def setup_for(speed: float, angle: float, instrument: ImagingSystem = INSTRUMENT) -> Setup:
    return Setup(instrument=instrument, angle=angle, speed=speed, diameter=DIAMETER)


def impacts(
    speed: float,
    angle: float,
    n: int = 1,
    *,
    restitution: float = 0.7,
    kept: float = 0.75,
    side: float = 0.0,
    seed: int = 1,
    **changes: Any,
) -> Impacts:
    """Vertical falls that keep a share of both velocity components, and gain one sideways."""
    rng = np.random.default_rng(seed)
    alpha = np.radians(angle)
    before = np.tile(speed * np.array([np.cos(alpha), 0.0, -np.sin(alpha)]), (n, 1))
    after = before * [kept, 1.0, -restitution] + [0.0, side, 0.0]
    fields = {
        "time": np.zeros(n),
        "diameter": np.full(n, DIAMETER),
        "position": 1e-4 * rng.standard_normal((n, 2)),
        "velocity": before,
        "spin": np.zeros((n, 3)),
        "rebound_velocity": after,
        "rebound_spin": np.zeros((n, 3)),
        "captured": np.zeros(n, dtype=bool),
        "contacts": np.ones(n, dtype=np.int64),
    }
    return Impacts(**(fields | changes))


def generator(*key: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(11, spawn_key=key))


def modelled_events(
    events: Impacts, setup: Setup, errors: Systematics | None = None
) -> ImagedEvents:
    """Events as the model has them, without systematic errors if none are given."""
    draws = [event_generator(generator(1), i) for i in range(len(events))]
    return modelled(events, setup, errors or Systematics(), draws)
