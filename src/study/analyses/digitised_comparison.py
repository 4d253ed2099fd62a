"""Digitised points of the article's figures against the computed series of the same panel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from study.tables import Tables, points_parts

COMPARED = ("computed", "calibrated", "virtual experiment")
# Half the length of a bar, an interval of 95 %, in standard uncertainties.
COVERAGE_FACTOR = 2.0
COLUMNS = (
    *("figure", "panel", "points", "points_evidence", "series", "named", "evidence", "unit"),
    *("n", "beyond", "bias", "rms_difference", "bars", "within_bars", "normalised_rms"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """No parameter: every digitised series is compared with every series of its panel."""


def run(params: Params, inputs: Tables) -> Tables:
    """Compare digitised points with computed curves and means of virtual experiments.

    ``digitised_residuals``: a row per digitised series and series of its panel that is a function
    of x; ``named`` says whether the latter has the name of the points, alone or before a comma.
    ``n`` points lie in its range, ``beyond`` outside: it is not continued. Their ``bias`` (mean of
    point less curve) and ``rms_difference`` are in ``unit``, empty if n is 0; ``within_bars`` is
    the fraction of those ``bars`` points that have a bar whose bar contains the curve, empty if
    none has, and ``normalised_rms`` the rms of their differences over the standard uncertainties,
    infinite where a bar without length misses the curve. A bar is taken for an interval of 95 %. No
    rows if there are no points.

    Parameters
    ----------
    params
        Not used.
    inputs
        ``digitised``: points with their figure; absent if there are none. The figure data of these
        figures, whose names begin with that of the figure, as ``fig23`` and ``fig23_points``.
    """
    points = inputs.get("digitised", pd.DataFrame())
    rows: list[dict[str, Any]] = []
    if not points.empty:
        for key, series_points in points.groupby(["figure", "panel", "series"], sort=False):
            figure, panel, series = map(str, key)
            kind, points_name = points_parts(series)
            where = {
                "figure": figure,
                "panel": panel,
                "points": points_name,
                "points_evidence": kind,
            }
            for name, table in inputs.items():
                if name == figure or name.startswith(f"{figure}_"):
                    rows += [
                        where | {"named": is_named(str(row["series"]), points_name)} | row
                        for row in _compared(series_points, table[table["panel"] == panel])
                    ]
    return {"digitised_residuals": pd.DataFrame(rows, columns=list(COLUMNS))}


def is_named(series: str, points: str) -> bool:
    """Tell whether a series has the name of points, alone or before a comma."""
    return series == points or series.startswith(f"{points}, ")


def _compared(points: pd.DataFrame, table: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Rows for every series of a panel that digitised points can be compared with."""
    x, y = table.columns[3:5]
    for (series, evidence), curve in table.groupby(["series", "evidence"], sort=False):
        places, heights = curve[x].to_numpy(float), curve[y].to_numpy(float)
        if places[0] > places[-1]:
            places, heights = places[::-1], heights[::-1]
        # An upright line, or one that turns back, is no function of x.
        is_function = places.size > 1 and bool(np.all(np.diff(places) > 0.0))
        if evidence not in COMPARED or not is_function:
            continue
        yield {
            "series": series,
            "evidence": evidence,
            "unit": y.removeprefix("y_"),
            **_differences(points, places, heights),
        }


def _differences(points: pd.DataFrame, x: FloatArray, y: FloatArray) -> dict[str, Any]:
    """Statistics of the points less the curve, interpolated linearly; gaps stay gaps."""
    places = points["x"].to_numpy(float)
    curve = np.asarray(np.interp(places, x, y, left=np.nan, right=np.nan))
    known = np.isfinite(curve)
    measured, curve = points[known], curve[known]
    difference = measured["y"].to_numpy(float) - curve
    low, high = measured["y_low"].to_numpy(float), measured["y_high"].to_numpy(float)
    barred = np.isfinite(low)
    within = (low <= curve) & (curve <= high)
    n, bars = int(known.sum()), int(barred.sum())
    return {
        "n": n,
        "beyond": len(points) - n,
        "bias": float(difference.mean()) if n else np.nan,
        "rms_difference": float(np.sqrt(np.mean(np.square(difference)))) if n else np.nan,
        "bars": bars,
        "within_bars": float(within[barred].mean()) if bars else np.nan,
        "normalised_rms": _normalised_rms(difference, low, high),
    }


def _normalised_rms(difference: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Rms of differences over standard uncertainties, of the points with a bar."""
    barred = np.isfinite(low)
    if not barred.any():
        return np.nan
    deviation, uncertainty = difference[barred], (high - low)[barred] / (2.0 * COVERAGE_FACTOR)
    # A bar without length agrees with nothing but its own point.
    scale = np.where(uncertainty > 0.0, uncertainty, np.finfo(float).tiny)
    with np.errstate(over="ignore"):
        return float(np.sqrt(np.mean(np.square(deviation / scale))))
