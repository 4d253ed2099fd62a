"""Does a pile on the target tell the capture velocity? Repeated bounces on it (2.3.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.lab.bounces import Resting, resting
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.surface import rough
from microimpact.model.calibration import two_stage
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.statistics.distributions import Distribution, generator, mean
from study.contacts import Posterior, calibrated_contact, pair_of, printed_values_for
from study.declared.parameters import (
    Ascending,
    CaseName,
    Count,
    Fraction,
    Must,
    NonNegative,
    Positive,
)
from study.tables import Tables, series_frame

NEEDS = {"calibration": ("calibration",), "inference": ("evidence_summary",)}
PRINTED_VALUES = ("pile_up_speed_sst_silicon",)

# Of the spheres dropped, those at rest on the target, and those captured there by one impact.
SHARES = "share_on_target", "share_captured_at_first_impact"

_frame = partial(series_frame, "all", x_unit="m_per_s", y_unit="1")

# More than any sphere makes before it rests.
MOST_IMPACTS = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Spheres dropped on a flat target, for three capture velocities."""

    seed: Annotated[int, Field(ge=0)]
    # Calibrated contact, whose capture velocity holds for the diameter of its calibration.
    case: CaseName
    friction: Fraction
    diameter_um: Distribution
    spin: InitialSpin
    dispenser: Dispenser
    spheres: Count
    # That restitution.
    high_speed_m_per_s: Positive
    restitution: Fraction
    # Of contacts with less adhesion, calibrated to the same restitution at high speed; one has the
    # median of a posterior over all laws.
    other_work_of_adhesion_J_per_m2: Positive  # noqa: N815 (the unit)
    other_capture_velocity_m_per_s: Positive
    posterior: Posterior
    # Of targets, and spread of their slopes per axis.
    radii_mm: tuple[Positive, ...]
    slopes_deg: tuple[NonNegative, ...]
    # Of the figure.
    drawn_radius_mm: Annotated[Positive, Must("one of", "radii_mm")]
    drawn_slope_deg: Annotated[NonNegative, Must("one of", "slopes_deg")]
    speeds_m_per_s: Annotated[tuple[Positive, ...], Ascending]
    shares: tuple[Fraction, ...]  # Shares of spheres on the target at which it begins to pile up


def run(params: Params, inputs: Tables) -> Tables:
    """Drop spheres at every speed on every target.

    ``pile_up``: share of spheres that rest on the target, per contact, target and speed.
    ``pile_up_onsets``: speeds below which it piles up. ``pile_up_onset``: data of the figure.
    """
    table = pd.DataFrame(_rows(params, contacts(params, inputs)))
    size = mean(params.diameter_um)
    printed = printed_values_for(inputs, *pair_of(inputs, params.case), diameter_um=size)
    ends = printed[["low", "high"]].to_numpy().ravel()
    return {
        "pile_up": table,
        "pile_up_onsets": pd.DataFrame(onsets(params, table)),
        "pile_up_onset": figure_data(params, table, ends),
    }


def contacts(params: Params, inputs: Tables) -> dict[str, Contact]:
    """Return contacts with the printed capture velocity, the median of the posterior, a lower one.

    Each has it at the diameter of the calibration.
    """
    strong = calibrated_contact(inputs, params.case).replace(friction=params.friction)
    summary, posterior = inputs["evidence_summary"], params.posterior
    for column, name in {**asdict(posterior), "quantity": "v_c_m_per_s"}.items():
        summary = summary[summary[column] == name]
    others = {
        "posterior": float(summary["median"].iloc[0]),
        "lower": params.other_capture_velocity_m_per_s,
    }
    bare = strong.replace(work_of_adhesion=params.other_work_of_adhesion_J_per_m2)
    target = params.high_speed_m_per_s, params.restitution
    return {"printed": strong} | {
        name: two_stage(bare, *target, limit).contact for name, limit in others.items()
    }


def _rows(params: Params, known: Mapping[str, Contact]) -> Iterator[dict[str, Any]]:
    for name, contact in known.items():
        for slope, speed in product(params.slopes_deg, params.speeds_m_per_s):
            resting_spheres = rest(params, contact, slope, speed)
            for radius in params.radii_mm:
                stays = resting_spheres.on_target(radius * 1e-3)
                shares = stays, stays & (resting_spheres.impacts == 1)
                yield {
                    "contact": name,
                    "capture_velocity_m_per_s": round(float(capture_velocity(contact)), 6),
                    "target_radius_mm": radius,
                    "slope_deg": slope,
                    "speed_m_per_s": speed,
                    **{k: np.sum(v) / params.spheres for k, v in zip(SHARES, shares, strict=True)},
                    "evidence": "virtual experiment",
                }


def rest(params: Params, contact: Contact, slope_deg: float, speed: float) -> Resting:
    """Drop spheres at one nominal speed and follow those that meet the largest target.

    All cases share the random numbers.
    """
    rng, farthest = generator(params.seed, 0), max(params.radii_mm) * 1e-3
    drop = Drop(
        target=Target(contact=contact, surface=rough(float(np.tan(np.radians(slope_deg))))),
        diameter_um=params.diameter_um,
        speed=speed,
        dispenser=params.dispenser,
        spin=params.spin,
    ).tabulated()
    impacts = drop.impacts(params.spheres, rng, within=farthest)
    later = drop.target.later(impacts.diameter, rng)
    return resting(impacts, later, MOST_IMPACTS, farthest)


def onsets(params: Params, table: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Yield the speeds below which given shares rest, for every capture velocity."""
    keys = ["target_radius_mm", "slope_deg", "contact", "capture_velocity_m_per_s"]
    for key, rows in table.groupby(keys, sort=False):
        speed, total, at_once = rows[["speed_m_per_s", *SHARES]].to_numpy().T
        for share in params.shares:
            yield {
                **dict(zip(keys, key, strict=True)),
                "share": share,
                "onset_m_per_s": onset(speed, total, share),
                "first_impact_onset_m_per_s": onset(speed, at_once, share),
                "evidence": "virtual experiment",
            }


def onset(speed: FloatArray, share: FloatArray, wanted: float) -> float:
    """Return the highest of ascending speeds (m/s) at which a share rests; nan without one."""
    above = np.flatnonzero(share >= wanted)
    if above.size == 0 or above[-1] == speed.size - 1:
        return float("nan")
    k = int(above[-1])
    step = (share[k] - wanted) / (share[k] - share[k + 1])
    return float(speed[k] + step * (speed[k + 1] - speed[k]))


def figure_data(params: Params, table: pd.DataFrame, printed: FloatArray) -> pd.DataFrame:
    """Return the data of the figure: share on the target, at first impact and in the end.

    Parameters
    ----------
    printed
        Ends of the speeds at which particles piled up, m/s; none for another pair.
    """
    shown = table[
        (table["target_radius_mm"] == params.drawn_radius_mm)
        & (table["slope_deg"] == params.drawn_slope_deg)
    ]
    frames = []
    for name, rows in shown.groupby("contact", sort=False):
        speed = rows["speed_m_per_s"]
        total, at_once = (rows[share] for share in SHARES)
        frames.append(_frame(f"{name}, in the end", speed, total, "virtual experiment"))
        frames.append(_frame(f"{name}, first impact", speed, at_once))
    if len(printed):
        frames.append(_frame("printed pile-up", printed, 0.0, "printed"))
    return pd.concat(frames, ignore_index=True)
