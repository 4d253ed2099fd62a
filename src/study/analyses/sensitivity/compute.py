"""Global sensitivity of the capture velocity: Sobol' indices beside the designed experiments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.statistics.sobol import (
    Indices,
    require_power_of_two,
    saltelli_sample,
    sobol_indices,
)
from study.analyses.fig24_25_doe.factors import (
    LETTERS,
    NAMES,
    at_levels,
    flat_family,
)
from study.analyses.sensitivity.ridge import Targets, calibrated_sample, material_damping
from study.contacts import calibrated_contact
from study.declared.parameters import CaseName, Count, Must, OpenShare, Positive
from study.tables import Row, Tables, series_frame

NEEDS = {
    "calibration": ("calibration", "calibration_family"),
    "fig24_25_doe": ("doe_levels", "doe_effects"),
}

# Place of this study among the random draws of one seed.
ANALYSIS = 25
# Place among the draws of one case: after all sets of levels.
CALIBRATED = 9

# What is drawn with a calibration, in order: the first is variability, the others are uncertain.
CALIBRATED_INPUTS = ("radius", "stiffness", "restitution", "capture_velocity", "ridge")
# Number of base samples from which the convergence is shown.
LEAST_SAMPLES = 32
# Indices of responses at a Saltelli sample, with their intervals.
Find = Callable[[FloatArray], Indices]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Numbers of samples, and their distributions.

    ``level_quantile``: the levels of the designed experiments are this quantile and its complement
    of lognormal distributions where levels are realistic; between levels of the small variation
    the distribution is uniform.
    """

    seed: Annotated[int, Field(ge=0)]
    samples: Count
    calibrated_samples: Count
    resamples: Annotated[int, Field(ge=20)]
    confidence: OpenShare
    level_quantile: Annotated[float, Field(gt=0.5, lt=1)]
    restitution_deviation: Positive
    capture_velocity_deviation_m_per_s: Positive
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    drawn_case: Annotated[CaseName, Must("one of", "cases")]

    def __post_init__(self) -> None:
        """Refuse numbers of samples that are no powers of two."""
        for name in ("samples", "calibrated_samples"):
            require_power_of_two(name, getattr(self, name))


def run(params: Params, inputs: Tables) -> Tables:
    """Compute the indices of every case.

    ``sensitivity_indices``: indices of the five factors, varied independently, beside their
    effects. ``sensitivity_convergence``: the same by number of samples. ``sensitivity_groups``:
    variability of the radius apart from the uncertainty of all that is calibrated. ``sobol``:
    indices drawn.
    """
    parts: dict[str, list[pd.DataFrame]] = {
        name: [] for name in ("indices", "convergence", "groups")
    }

    def finder(*key: int) -> Find:
        return partial(
            sobol_indices,
            draw=_generator(params, (*key, 1)),
            resamples=params.resamples,
            confidence=params.confidence,
        )

    for number, case in enumerate(params.cases):
        contact = calibrated_contact(inputs, case)
        levels = inputs["doe_levels"]
        levels = levels[levels["case"] == case]
        if levels.empty:
            raise ValueError(f"cases: {case!r} has no levels in the designed experiments")
        by_variation = levels.groupby("variation", sort=False)
        for turn, (variation, rows) in enumerate(by_variation):
            draw = independent(params, case, str(variation), contact, rows, (number, turn))
            find = finder(number, turn)
            parts["indices"] += index_tables(draw, inputs["doe_effects"], find)
            if variation == "realistic":
                parts["groups"] += group_tables(draw, NAMES.index("radius"), find)
            parts["convergence"] += convergence_tables(draw, find)
        wide, key = by_variation.get_group("realistic"), (number, CALIBRATED)
        draw = calibrated(params, case, contact, wide, inputs, key)
        find = finder(*key)
        parts["groups"] += group_tables(draw, CALIBRATED_INPUTS.index("radius"), find)
        parts["groups"].append(_input_table(draw, "input", CALIBRATED_INPUTS, find(draw.kept())))
    named = {
        f"sensitivity_{name}": pd.concat(own, ignore_index=True) for name, own in parts.items()
    }
    return named | {"sobol": drawn(named, params.drawn_case)}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Draw:
    """One contact at the points of a Saltelli sample."""

    # Which contact, and how it was varied.
    case: str
    variation: str
    # Capture velocities in m/s, shape (samples, inputs + 2); infinite where no speed rebounds, NaN
    # where there is no calibration. Neither has a variance.
    response: FloatArray

    def kept(self, samples: int | None = None) -> FloatArray:
        """Return the first base samples, without those that lack a finite response.

        Raises ValueError if fewer than two are left.
        """
        first = self.response[:samples]
        kept: FloatArray = first[np.isfinite(first).all(axis=1)]
        if len(kept) < 2:
            raise ValueError(
                f"sensitivity: {self.case!r}, {self.variation}: {len(kept)} of {len(first)} base"
                " samples have finite capture velocities; two are needed"
            )
        return kept

    @property
    def label(self) -> Row:
        """Case, variation and counts, for a row of a table."""
        return {
            "case": self.case,
            "variation": self.variation,
            "samples": len(self.response),
            "samples_kept": len(self.kept()),
            "points": self.response.size,
            "points_without_capture_velocity": int((~np.isfinite(self.response)).sum()),
        }


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
    return Draw(case=case, variation=variation, response=response)


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
    inputs: Tables,
    key: tuple[int, int],
) -> Draw:
    """Return capture velocities for a radius and a calibration drawn.

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
    target = printed_targets(inputs["calibration"], case)
    low, high = damping_share(contact, target[0], inputs)
    targets = Targets(
        high_speed=float(contact.reference_velocity),  # type: ignore[arg-type]
        restitution=target[0] + params.restitution_deviation * e,
        capture_velocity=target[1] + params.capture_velocity_deviation_m_per_s * limit,
        damping_share=low + (high - low) * points[:, 4],
        stiffness=stiffness,
    )
    _require_admissible(targets)
    sample, met = calibrated_sample(contact, targets)
    limits = capture_velocity(sample.replace(diameter=sample.diameter * radius))
    response = np.where(met, limits, np.nan).reshape(cube.shape[:2])
    return Draw(case=case, variation="calibrated", response=response)


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

    Parameters
    ----------
    cube
        Shape (..., inputs), one column per row of ``levels``.
    levels
        Columns ``low_multiple`` and ``high_multiple``.
    variation
        ``realistic``: lognormal, the levels at the quantile and its complement. Otherwise
        uniform between the levels.
    quantile
        Of the high level.
    """
    from scipy.special import ndtri

    low, high = (levels[f"{end}_multiple"].to_numpy(float) for end in ("low", "high"))
    if variation != "realistic":
        evenly: FloatArray = low + (high - low) * cube
        return evenly
    middle, half = 0.5 * np.log(low * high), 0.5 * np.log(high / low)
    multiples: FloatArray = np.exp(middle + half * ndtri(cube) / ndtri(quantile))
    return multiples


def _generator(params: Params, key: tuple[int, ...]) -> np.random.Generator:
    seed = np.random.SeedSequence(params.seed, spawn_key=(ANALYSIS, *key))
    return np.random.Generator(np.random.PCG64(seed))


def index_tables(draw: Draw, effects: pd.DataFrame, find: Find) -> Iterator[pd.DataFrame]:
    """Yield the indices of the five factors beside their effects over the full design."""
    keys = ["case", "variation", "design"]
    whole = effects[(effects[keys] == [draw.case, draw.variation, "full"]).all(axis=1)]
    for response, values in {"v_c": draw.kept(), "ln v_c": np.log(draw.kept())}.items():
        size = whole[whole["response"] == response].set_index("effect")["effect_percent"]
        square = size**2 / float((size**2).sum())
        words = [[letter in word for word in square.index] for letter in LETTERS]
        columns = {
            "response": response,
            "factor": list(LETTERS),
            "name": NAMES,
            **asdict(find(values)),
            "effect_percent": size[list(LETTERS)].to_numpy(float),
            "effect_first": square[list(LETTERS)].to_numpy(float),
            "effect_total": [float(square[of].sum()) for of in words],
            "evidence": "computed",
        }
        yield pd.DataFrame(draw.label | columns)


def convergence_tables(draw: Draw, find: Find) -> Iterator[pd.DataFrame]:
    """Yield the indices of v_c from the first base samples, doubled until all are in."""
    samples = LEAST_SAMPLES
    while samples <= len(draw.response):
        start = {"case": draw.case, "variation": draw.variation, "samples": samples}
        indices = {"factor": list(LETTERS), **asdict(find(draw.kept(samples)))}
        yield pd.DataFrame(start | indices | {"evidence": "computed"})
        samples *= 2


def group_tables(draw: Draw, radius: int, find: Find) -> Iterator[pd.DataFrame]:
    """Yield the indices of variability, the radius, and of uncertainty, all other inputs.

    Points A and that with the radius of B differ in the radius alone; that point and B differ in
    all else: the same responses serve both groups.
    """
    groups = {"variability": [0, 1 + radius, -1], "uncertainty": [-1, 1 + radius, 0]}
    for name, columns in groups.items():
        yield _input_table(draw, "group", [name], find(draw.kept()[:, columns]))


def _input_table(
    draw: Draw, kind: str, names: Sequence[str], sobol_indices: Indices
) -> pd.DataFrame:
    indices = {"kind": kind, "input": names, **asdict(sobol_indices), "evidence": "computed"}
    return pd.DataFrame(draw.label | indices)


def drawn(tables: Tables, case: str) -> pd.DataFrame:
    """Return the figure's data: a panel per case and variation, the groups, the convergence."""
    rows, groups, steps = (
        tables[f"sensitivity_{name}"] for name in ("indices", "groups", "convergence")
    )
    frames = []
    of_v_c = rows[rows["response"] == "v_c"]
    for (name, variation), part in of_v_c.groupby(["case", "variation"], sort=False):
        x = np.arange(len(part), dtype=float)
        for series, column in (
            ("total index", "total"),
            ("first-order index", "first"),
            ("share of squared effects", "effect_total"),
        ):
            frames.append(_frame(f"{variation}, {name}", series, x, part, column))
    shown = groups[(groups["variation"] == "calibrated") & (groups["kind"] == "input")]
    for name, part in shown.groupby("case", sort=False):
        x = np.arange(len(part), dtype=float)
        frames.append(_frame("calibrated", str(name), x, part, "total"))
    chosen = steps[(steps["case"] == case) & (steps["variation"] == "realistic")]
    for letter, part in chosen.groupby("factor"):
        samples = part["samples"].to_numpy(float)
        frames.append(_frame("convergence", str(letter), samples, part, "total"))
    return pd.concat(frames, ignore_index=True)


def _frame(panel: str, series: str, x: FloatArray, rows: pd.DataFrame, column: str) -> pd.DataFrame:
    ends = [rows[name] for end in ("low", "high") if (name := f"{column}_{end}") in rows]
    y = rows[column]
    return series_frame(panel, series, x, y, "computed", *ends, x_unit="1", y_unit="1")
