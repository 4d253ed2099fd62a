"""Global sensitivity of the capture velocity: Sobol' indices beside the designed experiments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Row, Tables
from microimpact.declared.parameters import CaseName, Count, Positive
from microimpact.lab.contacts import calibrated_contact
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.statistics.sobol import require_power_of_two, saltelli_sample
from microimpact.studies.analyses.doe.factors import LETTERS, NAMES, at_levels, flat_family
from microimpact.studies.analyses.sensitivity.ridge import (
    Targets,
    calibrated_sample,
    material_damping,
)
from microimpact.studies.analyses.sensitivity.tables import (
    CALIBRATED_INPUTS,
    Bootstrap,
    Draw,
    convergence_rows,
    drawn,
    group_rows,
    index_rows,
    input_rows,
    parameter_rows,
)

NEEDS = {"calibration": ("calibration", "calibration_family"), "doe": ("doe_levels", "doe_effects")}

# Place of this study among the random draws of one seed.
ANALYSIS = 25
# Place among the draws of one case: after all sets of levels.
CALIBRATED = 9

OpenFraction = Annotated[float, Field(gt=0, lt=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """How many samples are drawn, and from what.

    ``level_quantile``: the levels of the designed experiments are this quantile and its complement
    of lognormal distributions where levels are realistic; between levels of the small variation
    the distribution is uniform. ``largest_capture_velocity_m_per_s``: where no speed rebounds v_c
    is infinite, and a v_c that may be so has no variance: larger ones are truncated to this.
    """

    seed: Annotated[int, Field(ge=0)]
    samples: Count
    calibrated_samples: Count
    least_samples: Count
    resamples: Annotated[int, Field(ge=20)]
    confidence: OpenFraction
    level_quantile: Annotated[float, Field(gt=0.5, lt=1)]
    restitution_deviation: Positive
    capture_velocity_deviation_m_per_s: Positive
    largest_capture_velocity_m_per_s: Positive
    drawn_case: CaseName
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]

    def __post_init__(self) -> None:
        """Refuse numbers of samples that are no powers of two, and an unknown drawn case."""
        for name in ("samples", "calibrated_samples", "least_samples"):
            require_power_of_two(name, getattr(self, name))
        if self.least_samples > self.samples:
            raise ValueError(
                f"least_samples {self.least_samples} must not be above samples {self.samples}"
            )
        if self.drawn_case not in self.cases:
            known = ", ".join(self.cases)
            raise ValueError(f"drawn_case: {self.drawn_case!r} must be one of {known}")


def run(params: Params, inputs: Tables) -> Tables:
    """Compute the indices of every case.

    ``sensitivity_indices``: indices of the five factors, varied independently, beside their
    effects. ``sensitivity_convergence``: the same by number of samples. ``sensitivity_groups``:
    variability of the radius apart from the uncertainty of all that is calibrated.
    ``sensitivity_parameters``: what is calibrated, and how it goes with w_A. ``sobol``: indices
    drawn.
    """
    tables: dict[str, list[Row]] = {
        name: [] for name in ("indices", "convergence", "groups", "parameters")
    }
    options = Bootstrap(resamples=params.resamples, confidence=params.confidence)
    for number, case in enumerate(params.cases):
        contact = calibrated_contact(inputs, case)
        levels = inputs["doe_levels"]
        levels = levels[levels["case"] == case]
        if levels.empty:
            raise ValueError(f"cases: {case!r} has no levels in the designed experiments")
        by_variation = levels.groupby("variation", sort=False)
        for turn, (variation, rows) in enumerate(by_variation):
            draw = independent(params, case, str(variation), contact, rows, (number, turn))
            numbers = _generator(params, (number, turn, 1))
            tables["indices"] += index_rows(draw, inputs["doe_effects"], numbers, options)
            if variation == "realistic":
                tables["groups"] += group_rows(draw, NAMES.index("radius"), numbers, options)
            tables["convergence"] += convergence_rows(draw, params.least_samples, numbers, options)
        target = printed_targets(inputs["calibration"], case)
        share = damping_share(contact, target[0], inputs)
        wide = by_variation.get_group("realistic")
        draw, sample = calibrated(params, case, contact, wide, target, share, (number, CALIBRATED))
        numbers = _generator(params, (number, CALIBRATED, 1))
        radius = CALIBRATED_INPUTS.index("radius")
        tables["groups"] += group_rows(draw, radius, numbers, options)
        tables["groups"] += input_rows(draw, CALIBRATED_INPUTS, numbers, options)
        tables["parameters"] += parameter_rows(case, sample)
    named = {f"sensitivity_{name}": pd.DataFrame(rows) for name, rows in tables.items()}
    return named | {"sobol": drawn(named, params.drawn_case)}


def independent(
    params: Params,
    case: str,
    variation: str,
    contact: Contact,
    levels: pd.DataFrame,
    key: tuple[int, int],
) -> Draw:
    """Return capture velocities for factors drawn independently over a set of levels."""
    cube = saltelli_sample(len(LETTERS), params.samples, _generator(params, (*key, 0)))
    multiples = multiples_of(cube, levels, variation, params.level_quantile)
    response = capture_velocity(at_levels(contact, multiples))
    largest = params.largest_capture_velocity_m_per_s
    return Draw(
        case=case,
        variation=variation,
        response=np.minimum(response, largest),
        truncated=int((response > largest).sum()),
        uncalibrated=0,
    )


def printed_targets(calibration: pd.DataFrame, case: str) -> tuple[float, float]:
    """Return the restitution and the capture velocity in m/s that a case was calibrated to.

    Raises ValueError if the case was calibrated to something else.
    """
    rows = calibration[(calibration["case"] == case) & (calibration["role"] == "target")]
    targets = rows.set_index("quantity")["target"].astype(float)
    names = ["coefficient_of_restitution", "capture_velocity"]
    if set(targets.index) != set(names):
        raise ValueError(
            f"cases: {case!r} must be calibrated to {' and '.join(names)}, not to"
            f" {', '.join(targets.index) or 'nothing'}"
        )
    e, limit = targets[names]
    return float(e), float(limit)


def damping_share(contact: Contact, restitution: float, inputs: Tables) -> tuple[float, float]:
    """Return the ends of c_H over the family with a level restitution.

    As shares of the c_H that would give the restitution without adhesion.
    """
    speed = float(contact.reference_velocity)  # type: ignore[arg-type]
    alone = float(material_damping(speed, np.array([restitution]))[0])
    damping = flat_family(contact, inputs)["hertz_damping_s_per_m"] / alone
    return float(damping.min()), float(damping.max())


def calibrated(
    params: Params,
    case: str,
    contact: Contact,
    levels: pd.DataFrame,
    target: tuple[float, float],
    share: tuple[float, float],
    key: tuple[int, int],
) -> tuple[Draw, Contact]:
    """Return capture velocities for a radius and a calibration drawn, and the contacts calibrated.

    The radius varies from sphere to sphere; the targets, the stiffness and the place on the ridge
    are uncertain, and fix w_A and both damping coefficients at the nominal radius. The last lies
    between two shares of damping, see `damping_share`.
    """
    from scipy.special import ndtri

    count = len(CALIBRATED_INPUTS)
    cube = saltelli_sample(count, params.calibrated_samples, _generator(params, (*key, 0)))
    points = cube.reshape(-1, count)
    rows = levels.set_index("factor").loc[["C", "A"]]
    radius, stiffness = multiples_of(points[:, :2], rows, "realistic", params.level_quantile).T
    e, limit = ndtri(points[:, 2:4]).T
    low, high = share
    targets = Targets(
        high_speed=float(contact.reference_velocity),  # type: ignore[arg-type]
        restitution=target[0] + params.restitution_deviation * e,
        capture_velocity=target[1] + params.capture_velocity_deviation_m_per_s * limit,
        damping_share=low + (high - low) * points[:, 4],
        stiffness=stiffness,
    )
    _require_admissible(targets)
    sample, met = calibrated_sample(contact, targets)
    found = capture_velocity(sample.replace(diameter=sample.diameter * radius))
    largest = params.largest_capture_velocity_m_per_s
    response = np.where(met, np.minimum(found, largest), np.nan).reshape(cube.shape[:2])
    draw = Draw(
        case=case,
        variation="calibrated",
        response=response,
        truncated=int((met & (found > largest)).sum()),
        uncalibrated=int((~met).sum()),
    )
    return draw, sample


def _require_admissible(targets: Targets) -> None:
    if not np.all((targets.restitution > 0.0) & (targets.restitution < 1.0)):
        raise ValueError(
            "restitution_deviation: draws of the restitution must stay within (0, 1), got"
            f" {targets.restitution.min():.3g} to {targets.restitution.max():.3g}"
        )
    largest = targets.capture_velocity.max()
    if targets.capture_velocity.min() <= 0.0 or largest >= targets.high_speed:
        raise ValueError(
            "capture_velocity_deviation_m_per_s: draws must stay above 0 and below"
            f" {targets.high_speed:g} m/s, got {targets.capture_velocity.min():.3g} to"
            f" {largest:.3g}"
        )


def multiples_of(
    cube: FloatArray, levels: pd.DataFrame, variation: str, quantile: float
) -> FloatArray:
    """Return multiples of nominal values for points of the unit cube, by a set of levels.

    `cube`: shape (..., inputs), one column per row of ``levels``; `levels`: columns
    ``low_multiple`` and ``high_multiple``; `variation`: ``realistic``: lognormal, the levels at the
    quantile and its complement. Otherwise uniform between the levels; `quantile`: of the high
    level.
    """
    from scipy.special import ndtri

    low, high = (levels[f"{end}_multiple"].to_numpy(float) for end in ("low", "high"))
    if variation != "realistic":
        evenly: FloatArray = low + (high - low) * cube
        return evenly
    middle, half = 0.5 * np.log(low * high), 0.5 * np.log(high / low)
    found: FloatArray = np.exp(middle + half * ndtri(cube) / ndtri(quantile))
    return found


def _generator(params: Params, key: tuple[int, ...]) -> np.random.Generator:
    seed = np.random.SeedSequence(params.seed, spawn_key=(ANALYSIS, *key))
    return np.random.Generator(np.random.PCG64(seed))
