"""Global sensitivity of the capture velocity: Sobol' indices beside the designed experiments.

Saltelli's scheme, drawn and analysed by SALib: A. Saltelli et al., Computer Physics Communications
181 (2010) 259.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.statistics.distributions import generator
from study.analyses.fig24_25_doe.factors import LETTERS, NAMES, at_levels
from study.contacts import calibrated_contact
from study.declared.parameters import CaseName, Count, Must, OpenShare
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration",), "fig24_25_doe": ("doe_levels", "doe_effects")}

# Place of this study among the random draws of one seed.
ANALYSIS = 25
# Number of base samples from which the convergence is shown.
LEAST_SAMPLES = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Numbers of samples, and their distributions.

    ``level_quantile``: the levels of the designed experiments are this quantile and its complement
    of lognormal distributions where levels are realistic; between levels of the small variation
    the distribution is uniform.
    """

    seed: Annotated[int, Field(ge=0)]
    samples: Count
    resamples: Annotated[int, Field(ge=20)]
    confidence: OpenShare
    level_quantile: Annotated[float, Field(gt=0.5, lt=1)]
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    drawn_case: Annotated[CaseName, Must("one of", "cases")]

    def __post_init__(self) -> None:
        """Refuse a number of samples that is no power of two."""
        if self.samples < 2 or self.samples & (self.samples - 1):
            raise ValueError(f"samples must be a power of two, 2 or more, got {self.samples}")


def run(params: Params, inputs: Tables) -> Tables:
    """Compute the indices of every case and variation of its levels.

    ``sensitivity_indices``: indices of the five factors, varied independently, beside their
    effects. ``sensitivity_convergence``: the same by number of samples. ``sobol``: indices drawn.
    """
    indices: list[pd.DataFrame] = []
    steps: list[pd.DataFrame] = []
    levels = inputs["doe_levels"]
    for number, case in enumerate(params.cases):
        contact = calibrated_contact(inputs, case)
        if (of_case := levels[levels["case"] == case]).empty:
            raise NotComputable(f"cases: {case!r} has no levels in the designed experiments")
        for turn, (name, rows) in enumerate(of_case.groupby("variation", sort=False)):
            variation = str(name)
            draws, bootstrap = (generator(params.seed, ANALYSIS, number, turn, i) for i in (0, 1))
            points = sampled(params, variation, rows, draws)
            response = capture_velocity(at_levels(contact, points)).reshape(params.samples, -1)
            label: Row = {"case": case, "variation": variation}
            indices += index_tables(params, label, response, inputs["doe_effects"], bootstrap)
            steps += convergence_tables(params, label, response, bootstrap)
    table = pd.concat(indices, ignore_index=True)
    convergence = pd.concat(steps, ignore_index=True)
    return {
        "sensitivity_indices": table,
        "sensitivity_convergence": convergence,
        "sobol": drawn(table, convergence, params.drawn_case),
    }


def sampled(
    params: Params, variation: str, levels: pd.DataFrame, draws: np.random.Generator
) -> FloatArray:
    """Return multiples of the nominal factors, shape (samples * (factors + 2), factors).

    Per base sample the points A, A with one factor each from B, and B. Realistic levels are
    quantiles of lognormal distributions, others the ends of uniform ones.
    """
    from SALib.sample import sobol
    from scipy.special import ndtri

    low, high = (levels[f"{end}_multiple"].to_numpy(float) for end in ("low", "high"))
    distribution, bounds = "unif", (low, high)
    if variation == "realistic":
        deviation = 0.5 * np.log(high / low) / ndtri(params.level_quantile)
        distribution, bounds = "lognorm", (0.5 * np.log(low * high), deviation)
    problem = _problem() | {
        "bounds": np.transpose(bounds).tolist(),
        "dists": [distribution] * len(LETTERS),
    }
    points = sobol.sample(problem, params.samples, calc_second_order=False, seed=draws)
    return np.asarray(points, dtype=float)


def sobol_indices(
    params: Params, response: FloatArray, bootstrap: np.random.Generator
) -> dict[str, FloatArray]:
    """Return first-order and total indices and the ends of their intervals, shape (factors,) each.

    Parameters
    ----------
    params
        Resamples and confidence of the percentile intervals.
    response
        At the points of `sampled`, shape (samples, factors + 2), finite.
    bootstrap
        Draws the resamples.
    """
    from SALib.analyze.sobol import analyze

    analysis: Any = analyze(
        _problem(),
        response.ravel(),
        calc_second_order=False,
        num_resamples=params.resamples,
        keep_resamples=True,
        seed=bootstrap,
    )
    tail = 0.5 * (1.0 - params.confidence)
    columns = {}
    for name, key in (("first", "S1"), ("total", "ST")):
        columns[name] = analysis[key]
        ends = np.quantile(analysis[f"{key}_conf_all"], [tail, 1.0 - tail], axis=0)
        columns[f"{name}_low"], columns[f"{name}_high"] = ends
    return columns


def _problem() -> dict[str, Any]:
    return {"num_vars": len(LETTERS), "names": list(LETTERS), "bounds": [[0.0, 1.0]] * len(LETTERS)}


def kept(response: FloatArray) -> FloatArray:
    """Return the base samples in which all responses are finite, for others have no variance.

    Raises NotComputable if fewer than two are left.
    """
    finite = response[np.isfinite(response).all(axis=1)]
    if len(finite) < 2:
        raise NotComputable(
            f"sensitivity: {len(finite)} of {len(response)} base samples have finite capture"
            " velocities; two are needed"
        )
    return finite


def index_tables(
    params: Params,
    label: Row,
    response: FloatArray,
    effects: pd.DataFrame,
    bootstrap: np.random.Generator,
) -> Iterator[pd.DataFrame]:
    """Yield the indices of the five factors beside their effects over the full design."""
    whole = effects[(effects[["case", "variation"]] == list(label.values())).all(axis=1)]
    whole = whole[whole["design"] == "full"]
    finite = kept(response)
    counts = {
        "samples": len(response),
        "samples_kept": len(finite),
        "points": response.size,
        "points_without_capture_velocity": int((~np.isfinite(response)).sum()),
    }
    for name, values in {"v_c": finite, "ln v_c": np.log(finite)}.items():
        size = whole[whole["response"] == name].set_index("effect")["effect_percent"]
        square = size**2 / float((size**2).sum())
        words = [[letter in word for word in square.index] for letter in LETTERS]
        columns = {
            "response": name,
            "factor": list(LETTERS),
            "name": NAMES,
            **sobol_indices(params, values, bootstrap),
            "effect_percent": size[list(LETTERS)].to_numpy(float),
            "effect_first": square[list(LETTERS)].to_numpy(float),
            "effect_total": [float(square[of].sum()) for of in words],
            "evidence": "computed",
        }
        yield pd.DataFrame(label | counts | columns)


def convergence_tables(
    params: Params, label: Row, response: FloatArray, bootstrap: np.random.Generator
) -> Iterator[pd.DataFrame]:
    """Yield the indices of v_c from the first base samples, doubled until all are in."""
    samples = LEAST_SAMPLES
    while samples <= len(response):
        indices = sobol_indices(params, kept(response[:samples]), bootstrap)
        start = label | {"samples": samples, "factor": list(LETTERS)}
        yield pd.DataFrame(start | indices | {"evidence": "computed"})
        samples *= 2


def drawn(indices: pd.DataFrame, steps: pd.DataFrame, case: str) -> pd.DataFrame:
    """Return the figure's data: a panel per case and variation, and the convergence of one case."""
    columns = {
        "total index": "total",
        "first-order index": "first",
        "share of squared effects": "effect_total",
    }
    frames = []
    of_v_c = indices[indices["response"] == "v_c"]
    for (name, variation), rows in of_v_c.groupby(["case", "variation"], sort=False):
        x = np.arange(len(rows), dtype=float)
        for series, column in columns.items():
            frames.append(_frame(f"{variation}, {name}", series, x, rows, column))
    chosen = steps[(steps["case"] == case) & (steps["variation"] == "realistic")]
    for letter, rows in chosen.groupby("factor"):
        samples = rows["samples"].to_numpy(float)
        frames.append(_frame("convergence", str(letter), samples, rows, "total"))
    return pd.concat(frames, ignore_index=True)


def _frame(panel: str, series: str, x: FloatArray, rows: pd.DataFrame, column: str) -> pd.DataFrame:
    ends = [rows[name] for end in ("low", "high") if (name := f"{column}_{end}") in rows]
    y = rows[column]
    return series_frame(panel, series, x, y, "computed", *ends, x_unit="1", y_unit="1")
