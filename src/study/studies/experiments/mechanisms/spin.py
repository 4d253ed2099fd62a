"""Effect of initial spin on the impulse ratio: spread alone, and a mean sense."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
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
from study.studies.samples import Dropped, Sample, Sampling, mean_columns, setting_for
from study.tables import Tables

# Spin sought, as a share of the speed, and range of angles in which a limit of rolling is sought.
LARGEST_SPIN = 3.0
LIMIT_RANGE = (35.0, 89.0)
SHIFTING_SPINS = (-1.0, 0.5)


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
    # Speeds at which the limit of rolling is sought, without spin and with this one.
    limit_speeds_m_per_s: tuple[Positive, ...]
    back_spin: Finite
    limit_shift_deg: Positive  # Shift for which the spin is sought
    bias: Positive  # Impulse ratio at 90 deg for which spin and tilt are sought
    bias_speed_m_per_s: Positive  # At which


def spin_tables(params: Spin, sampling: Sampling, inputs: Tables) -> dict[str, pd.DataFrame]:
    """Return the tables of the spin mechanism, by name."""
    rows: defaultdict[str, list[dict[str, Any]]] = defaultdict(list)
    for case in params.cases:
        sample = Sample.of(replace(params.dropped, case=case), sampling, inputs)
        grid = _grid(params, sample)
        rows["spin_mechanism"] += grid
        zero = [row["impulse_ratio"] for row in grid if row["spin_mean"] == 0.0]
        least = {"least_without_mean": float(np.nanmin(zero))}
        rows["spin_needed"] += [row | least for row in needed_rows(params, sample)]
        rows["rolling_limits"] += limit_rows(params, case, sample.contact)
        rows["spin_or_tilt"].append(bias_row(params, sample))
    return {name: pd.DataFrame(part) for name, part in rows.items()}


def _grid(params: Spin, sample: Sample) -> list[dict[str, Any]]:
    """Means over all spins and angles, with the trend over the angles of each spin."""
    spins = [(0.0, sd) for sd in params.spreads]
    spins += [(m, params.spread_about_mean) for m in params.means]
    rows = []
    for spin_mean, sd in spins:
        turning = sample.but(spin=InitialSpin(mean=spin_mean, sd=sd))
        samples = [turning.seen(angle) for angle in params.angles_deg]
        mu = np.array([one.means["impulse_ratio"].value for one in samples])
        known = np.isfinite(mu)
        trend = float(np.corrcoef(np.array(params.angles_deg)[known], mu[known])[0, 1])
        rows += [
            {"case": sample.dropped.case, "spin_mean": spin_mean, "spin_sd": sd, "angle_deg": angle}
            | mean_columns(one)
            | {"correlation_of_impulse_ratio_with_angle": trend, "evidence": "virtual experiment"}
            for angle, one in zip(params.angles_deg, samples, strict=True)
        ]
    return rows


def needed_rows(params: Spin, sample: Sample) -> Iterator[dict[str, Any]]:
    """Mean spin that brings the mean impulse ratio to zero; empty with too few rebounds."""

    def turning(spin: float) -> Sample:
        return sample.but(spin=InitialSpin(mean=spin, sd=params.spread_about_mean))

    for angle in params.angles_deg:
        # Spin does not decide on capture: too few rebounds without it are too few with it.
        enough = np.isfinite(turning(0.0).mean("impulse_ratio", angle))
        sought = turning, "impulse_ratio", angle, 0.0, 0.0, LARGEST_SPIN
        spin = setting_for(*sought) if enough else np.nan
        yield {
            "case": sample.dropped.case,
            "angle_deg": angle,
            "mean_spin_needed": spin,
            "spin_sd": params.spread_about_mean,
            "rotational_over_translational_energy": INERTIA * spin**2,
            "speed_along_surface": float(np.cos(np.radians(angle))),
            "evidence": "virtual experiment",
        }


def limit_rows(params: Spin, case: str, contact: Contact) -> Iterator[dict[str, Any]]:
    """Shallowest angle at which the mean sphere leaves rolling, per speed, and its shifts."""
    base = rolling_limit(contact, params.limit_speeds_m_per_s[0], 0.0)
    aim = base + params.limit_shift_deg
    for speed in params.limit_speeds_m_per_s:

        def excess(spin: float, speed: float = speed) -> float:
            return float(rolling_limit(contact, speed, spin) - aim)

        still = rolling_limit(contact, speed, 0.0)
        e = simulate(contact, speed, still).coefficient_of_restitution
        yield {
            "case": case,
            "speed_m_per_s": speed,
            "limit_deg": still,
            "limit_with_back_spin_deg": rolling_limit(contact, speed, params.back_spin),
            "back_spin": params.back_spin,
            "restitution_at_limit": float(e),
            "evidence": "computed",
            "shift_deg": still - base,
            "back_spin_for_shift": root(excess, *SHIFTING_SPINS, absolute=1e-4),
            "shift_sought_deg": params.limit_shift_deg,
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
    uncertainty = sample.sampling.angle_error_deg

    def by_spin(spin: float) -> float:
        impact = simulate(sphere, speed, 90.0, -spin * speed / sphere.radius)
        return float(impact.impulse_ratio) - params.bias

    def by_tilt(tilt: float) -> float:
        return -tilted_ratio(sphere, speed, tilt) - params.bias

    e = float(simulate(sphere, speed).coefficient_of_restitution)
    spin, tilt = (root(f, 0.0, end, absolute=1e-9) for f, end in ((by_spin, 0.5), (by_tilt, 5)))
    return {
        "case": sample.dropped.case,
        "impulse_ratio": params.bias,
        "spin_over_speed": spin,
        "spin_rad_per_s": spin * speed / float(sphere.radius),
        "spin_over_speed_closed_form": 3.5 * (1.0 + e) * params.bias,
        "tilt_deg": tilt,
        "tilt_deg_closed_form": float(np.degrees(params.bias / (1.0 - 2.0 / 7.0 / (1.0 + e)))),
        "tilt_uncertainty_deg": uncertainty,
        "tilt_over_its_uncertainty": tilt / uncertainty,
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
