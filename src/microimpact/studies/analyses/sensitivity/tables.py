"""Tables of the global sensitivity: indices, their convergence, groups, and what is drawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Row, Tables, series_frame
from microimpact.model.contact import Contact
from microimpact.statistics.sobol import Indices, sobol_indices
from microimpact.studies.analyses.doe.factors import FACTORS, LETTERS, factor_values

# What is drawn with a calibration, in order: the first is variability, the others are uncertain.
CALIBRATED_INPUTS = ("radius", "stiffness", "restitution", "capture_velocity", "ridge")

RESPONSES = ("v_c", "ln v_c")
CENTRAL = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class Bootstrap:
    """How intervals of indices are found."""

    resamples: int
    confidence: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Draw:
    """One contact at the points of a Saltelli sample."""

    # Which contact, and how it was varied.
    case: str
    variation: str
    # Capture velocities in m/s, shape (samples, inputs + 2); NaN where there is no calibration.
    response: FloatArray
    # Points whose capture velocity was above the largest one that counts, infinite ones among them,
    # and points whose calibration has no solution.
    truncated: int
    uncalibrated: int

    def kept(self, samples: int | None = None) -> FloatArray:
        """Return the first base samples, without those that lack a response.

        Raises ValueError if fewer than two are left.
        """
        first = self.response[:samples]
        kept: FloatArray = first[np.isfinite(first).all(axis=1)]
        if len(kept) < 2:
            raise ValueError(
                f"sensitivity: {self.case!r}, {self.variation}: {len(kept)} of {len(first)} base"
                " samples are calibrated throughout; two are needed"
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
            "points_truncated": self.truncated,
            "points_without_calibration": self.uncalibrated,
        }


def index_rows(
    draw: Draw, effects: pd.DataFrame, numbers: np.random.Generator, options: Bootstrap
) -> Iterator[Row]:
    """Yield the indices of the five factors beside their effects over the full design."""
    whole = effects[
        (effects["case"] == draw.case)
        & (effects["variation"] == draw.variation)
        & (effects["design"] == "full")
    ]
    for response in RESPONSES:
        values = np.log(draw.kept()) if response == "ln v_c" else draw.kept()
        found = _indices(values, numbers, options)
        size = whole[whole["response"] == response].set_index("effect")["effect_percent"]
        square = size**2 / float((size**2).sum())
        ranks = _ranks(found.total), _ranks(np.abs(size[list(LETTERS)].to_numpy(float)))
        for i, letter in enumerate(LETTERS):
            yield draw.label | {
                "response": response,
                "standard_deviation_percent": _spread(draw.kept()),
                "factor": letter,
                "name": FACTORS[letter][0],
                **_at(found, i),
                "effect_percent": float(size[letter]),
                "effect_first": float(square[letter]),
                "effect_total": float(square[[letter in word for word in square.index]].sum()),
                "rank_by_total": int(ranks[0][i]),
                "rank_by_effect": int(ranks[1][i]),
                "evidence": "computed",
            }


def convergence_rows(
    draw: Draw, least: int, numbers: np.random.Generator, options: Bootstrap
) -> Iterator[Row]:
    """Yield the indices of v_c from the first base samples, doubled until all are in."""
    samples = least
    while samples <= len(draw.response):
        found = _indices(draw.kept(samples), numbers, options)
        for i, letter in enumerate(LETTERS):
            yield {
                "case": draw.case,
                "variation": draw.variation,
                "samples": samples,
                "factor": letter,
                **_at(found, i),
                "evidence": "computed",
            }
        samples *= 2


def group_rows(
    draw: Draw, radius: int, numbers: np.random.Generator, options: Bootstrap
) -> Iterator[Row]:
    """Yield the indices of variability, the radius, and of uncertainty, all other inputs.

    Points A and that with the radius of B differ in the radius alone; that point and B differ in
    all else: the same responses serve both groups.
    """
    kept = draw.kept()
    for name, columns in (
        ("variability", [0, 1 + radius, -1]),
        ("uncertainty", [-1, 1 + radius, 0]),
    ):
        found = _indices(kept[:, columns], numbers, options)
        yield _input_row(draw, "group", name, _at(found, 0))


def input_rows(
    draw: Draw, names: Sequence[str], numbers: np.random.Generator, options: Bootstrap
) -> Iterator[Row]:
    """Yield the indices of each input."""
    found = _indices(draw.kept(), numbers, options)
    for i, name in enumerate(names):
        yield _input_row(draw, "input", name, _at(found, i))


def _input_row(draw: Draw, kind: str, name: str, indices: Mapping[str, float]) -> Row:
    spread = {"standard_deviation_percent": _spread(draw.kept())}
    return draw.label | spread | {"kind": kind, "input": name, **indices, "evidence": "computed"}


def parameter_rows(case: str, sample: Contact) -> Iterator[Row]:
    """Yield medians, 90 % ranges and rank correlations of what is calibrated."""
    values = {name: np.asarray(factor_values(sample)[name]) for name in "ABDE"}
    ranks = {name: pd.Series(value).rank() for name, value in values.items()}
    for letter, value in values.items():
        low, median, high = np.quantile(value, [0.5 - CENTRAL / 2, 0.5, 0.5 + CENTRAL / 2])
        yield {
            "case": case,
            "factor": letter,
            "name": FACTORS[letter][0],
            "unit": FACTORS[letter][1],
            "low": low,
            "median": median,
            "high": high,
            "rank_correlation_with_B": float(np.corrcoef(ranks[letter], ranks["B"])[0, 1]),
            "evidence": "calibrated",
        }


def drawn(tables: Tables, case: str) -> pd.DataFrame:
    """Return the figure's data: a panel per case and variation, the groups, the convergence."""
    frames = []
    rows = tables["sensitivity_indices"]
    of_v_c = rows[rows["response"] == "v_c"]
    for (name, variation), part in of_v_c.groupby(["case", "variation"], sort=False):
        panel = f"{variation}, {name}"
        for series, column, bounded in (
            ("total index", "total", True),
            ("first-order index", "first", True),
            ("share of squared effects", "effect_total", False),
        ):
            place = np.arange(len(part), dtype=float)
            frames.append(_frame(panel, series, place, part, column, bounded=bounded))
    groups = tables["sensitivity_groups"]
    shown = (groups["variation"] == "calibrated") & (groups["kind"] == "input")
    for name, part in groups[shown].groupby("case", sort=False):
        place = np.arange(len(part), dtype=float)
        frames.append(_frame("calibrated", str(name), place, part, "total"))
    steps = tables["sensitivity_convergence"]
    chosen = steps[(steps["case"] == case) & (steps["variation"] == "realistic")]
    for letter, part in chosen.groupby("factor"):
        samples = part["samples"].to_numpy(float)
        frames.append(_frame("convergence", str(letter), samples, part, "total"))
    return pd.concat(frames, ignore_index=True)


def _frame(
    panel: str,
    series: str,
    place: FloatArray,
    rows: pd.DataFrame,
    column: str,
    *,
    bounded: bool = True,
) -> pd.DataFrame:
    ends = [rows[f"{column}_{end}"] for end in ("low", "high") if bounded]
    y = rows[column]
    return series_frame(panel, series, place, y, "computed", *ends, x_unit="1", y_unit="1")


def _indices(values: FloatArray, numbers: np.random.Generator, options: Bootstrap) -> Indices:
    return sobol_indices(
        values, numbers, resamples=options.resamples, confidence=options.confidence
    )


def _at(found: Indices, column: int) -> dict[str, float]:
    return {name: float(value[column]) for name, value in asdict(found).items()}


def _spread(kept: FloatArray) -> float:
    """Return the standard deviation in % of the mean, over the points A and B."""
    independent = kept[:, [0, -1]]
    return float(100.0 * independent.std(ddof=1) / independent.mean())


def _ranks(sizes: FloatArray) -> FloatArray:
    """Return ranks from the largest; sizes equal but for rounding share one."""
    ranks: FloatArray = np.asarray(pd.Series(sizes).round(9).rank(ascending=False, method="min"))
    return ranks
