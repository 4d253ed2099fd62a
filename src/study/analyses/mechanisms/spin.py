"""Effect of initial spin on the impulse ratio: spread alone, and a mean sense."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import BoolArray, Real
from microimpact.core.solve import root, threshold
from microimpact.lab.dispenser import InitialSpin
from microimpact.lab.events import Measured
from microimpact.lab.ptis.experiment import turned
from microimpact.lab.reduction import quantities
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate
from microimpact.model.rigid_body.algebra import INERTIA
from study.declared.parameters import AngleDegrees, CaseName, Finite, NonNegative, Positive
from study.samples import Dropped, Sample, Sampling, mean_columns, setting_for
from study.tables import Tables

# Spin sought, as a share of the speed, and range of angles in which a limit of rolling is sought.
LARGEST_SPIN = 3.0
LIMIT_RANGE = (35.0, 89.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spin:
    """Spins tried at one speed."""

    dropped: Dropped  # Spheres and surface; its own spin is not used
    cases: tuple[CaseName, ...]  # Calibrated contacts
    angles_deg: tuple[AngleDegrees, ...]  # Of incidence, from the steepest
    spreads: tuple[NonNegative, ...]  # Standard deviations of spins without a mean, r omega/v
    # Spins with a mean, and their spread.
    means: tuple[Finite, ...]
    spread_about_mean: NonNegative
    bias: Positive  # Impulse ratio at 90 deg for which spin and tilt are sought
    bias_speed_m_per_s: Positive  # At which


def spin_tables(params: Spin, sampling: Sampling, inputs: Tables) -> dict[str, pd.DataFrame]:
    """Return the tables of the spin mechanism, by name."""
    samples = [
        Sample.of(replace(params.dropped, case=case), sampling, inputs) for case in params.cases
    ]
    return {
        "spin_mechanism": pd.DataFrame(row for each in samples for row in grid_rows(params, each)),
        "spin_needed": pd.DataFrame(row for each in samples for row in needed_rows(params, each)),
        "spin_or_tilt": pd.DataFrame(bias_row(params, each) for each in samples),
    }


def grid_rows(params: Spin, sample: Sample) -> Iterator[dict[str, Any]]:
    """Yield means over all spins and angles."""
    spins = [(0.0, sd) for sd in params.spreads]
    spins += [(m, params.spread_about_mean) for m in params.means]
    for (spin_mean, sd), angle in product(spins, params.angles_deg):
        turning = sample.with_changes(spin=InitialSpin(mean=spin_mean, sd=sd))
        yield (
            {"case": sample.dropped.case, "spin_mean": spin_mean, "spin_sd": sd, "angle_deg": angle}
            | mean_columns(turning.seen(angle))
            | {"evidence": "virtual experiment"}
        )


def needed_rows(params: Spin, sample: Sample) -> Iterator[dict[str, Any]]:
    """Mean spin that brings the mean impulse ratio to zero; empty with too few rebounds."""

    def turning(spin: float) -> Sample:
        return sample.with_changes(spin=InitialSpin(mean=spin, sd=params.spread_about_mean))

    for angle in params.angles_deg:
        # Spin does not decide on capture: too few rebounds without it are too few with it.
        enough = np.isfinite(turning(0.0).mean("impulse_ratio", angle))
        sought = turning, "impulse_ratio", angle, 0.0, 0.0, LARGEST_SPIN
        spin = setting_for(*sought) if enough else np.nan
        yield {
            "case": sample.dropped.case,
            "angle_deg": angle,
            "mean_spin_needed": spin,
            "rotational_over_translational_energy": INERTIA * spin**2,
            "evidence": "virtual experiment",
        }


def rolling_limit(contact: Contact, speed: float, spin: float) -> float:
    """Return the angle (degrees) below which a sphere still slides as it leaves, within limits.

    Speed is in m/s, spin is r omega/v.
    """

    def rolls(angle: Real) -> BoolArray:
        impact = simulate(contact, speed, angle, spin * speed / contact.radius)
        # One that stays rolls, too, at angles below those at which others slide.
        return impact.rolling & ~impact.captured

    shallow, steep = LIMIT_RANGE
    if rolls(shallow):
        return shallow
    if not rolls(steep):
        return steep
    return threshold(rolls, shallow, steep, absolute=1e-6)


def bias_row(params: Spin, sample: Sample) -> dict[str, Any]:
    """Spin, or tilt of the target, that shows as a given impulse ratio at normal incidence."""
    sphere, speed = sample.contact, params.bias_speed_m_per_s

    def by_spin(spin: float) -> float:
        impact = simulate(sphere, speed, 90.0, -spin * speed / sphere.radius)
        return float(impact.impulse_ratio) - params.bias

    def by_tilt(tilt: float) -> float:
        return -tilted_ratio(sphere, speed, tilt) - params.bias

    spin, tilt = (root(f, 0.0, end, absolute=1e-9) for f, end in ((by_spin, 0.5), (by_tilt, 5)))
    return {
        "case": sample.dropped.case,
        "spin_over_speed": spin,
        "tilt_deg": tilt,
        "evidence": "computed",
    }


def tilted_ratio(contact: Contact, speed: float, tilt: float) -> float:
    """Return the impulse ratio measured at normal incidence on a target tilted by degrees.

    The components are those along and across the nominal surface. The target throws the sphere to
    the side to which it slopes: the ratio counted along that side is negative.
    """
    impact, turn = simulate(contact, speed, 90.0 - tilt), np.radians(tilt)
    before = [speed * np.sin(turn), -speed * np.cos(turn)]
    after = [float(impact.tangential_velocity), float(impact.normal_velocity)]
    true = Measured(event=np.zeros(1, dtype=np.int64), velocities=np.array([[before, after]]))
    return float(quantities(turned(true, tilt))["impulse_ratio"][0])
