"""Statements and figure data of the study of Eq. (34)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.studies.models.fit_coverage.truths import TRUTHS

Reference = tuple[str, float, int]
Statement = tuple[str, float, str]
EXPONENTS = {"free": "q free", "fixed": "q fixed"}
QUANTITIES = {"bias": "bias", "rms_error": "rms", "coverage": "coverage"}


def figure_data(table: pd.DataFrame, reference: Reference, confidence: float) -> pd.DataFrame:
    """Bias, rms error and coverage over the lowest speed, by truth, for the first variant."""
    variant, _, points = reference
    rows = table[(table["variant"] == variant) & (table["points"] == points)]
    frames = []
    for quantity, short in QUANTITIES.items():
        for truth in TRUTHS:
            panel = f"{short}, {truth}"
            own = rows[rows["truth"] == truth]
            for (noise, exponent), part in own.groupby(["noise_of_e", "exponent"], sort=True):
                y = part[quantity].to_numpy(float)
                error = 1.96 * part["coverage_standard_error"].to_numpy(float)
                bars = quantity == "coverage"
                frames.append(
                    series_frame(
                        panel=panel,
                        series=f"noise {noise:g}, {EXPONENTS[str(exponent)]}",
                        evidence="virtual experiment",
                        x=part["lowest_speed_in_v_c"],
                        y=y,
                        x_unit="1",
                        y_unit="1",
                        y_low=np.maximum(y - error, 0.0) if bars else np.nan,
                        y_high=np.minimum(y + error, 1.0) if bars else np.nan,
                    )
                )
            if quantity == "coverage":
                x = own["lowest_speed_in_v_c"].agg(["min", "max"])
                frames.append(_nominal(panel, x.to_numpy(float), confidence))
    return pd.concat(frames, ignore_index=True)


def _nominal(panel: str, x: FloatArray, confidence: float) -> pd.DataFrame:
    return series_frame(
        panel=panel,
        series="nominal",
        evidence="computed",
        x=x,
        y=confidence,
        x_unit="1",
        y_unit="1",
    )


def statements(
    table: pd.DataFrame, methods: pd.DataFrame, reference: Reference, tolerated: float
) -> pd.DataFrame:
    """What the study says, one quantity a row; where there is no value, the note says why."""
    variant, noise, points = reference
    first = table[table["variant"] == variant]
    usual = first[(first["noise_of_e"] == noise) & (first["points"] == points)]
    where = f"noise {noise:g} in e, {points} points"
    rows = [*_reach(usual, tolerated, where), *_extremes(first)]
    rows += [*_variants(table, reference), *_methods(methods, where)]
    return pd.DataFrame(rows, columns=["quantity", "value", "note"])


def _reach(usual: pd.DataFrame, tolerated: float, where: str) -> Iterator[Statement]:
    """Largest lowest speed up to which every rms error is tolerable."""
    for (truth, exponent), group in usual.groupby(["truth", "exponent"], sort=True):
        part = group.sort_values("lowest_speed_in_v_c")
        good = np.logical_and.accumulate(part["rms_error"].to_numpy(float) <= tolerated)
        speeds = part["lowest_speed_in_v_c"].to_numpy(float)
        yield (
            f"largest lowest speed over v_c with v_c within {100 * tolerated:g} % rms, "
            f"truth {truth}, {EXPONENTS[str(exponent)]}",
            float(speeds[good][-1]) if good.any() else np.nan,
            where if good.any() else f"{where}: not even from {speeds[0]:g} v_c",
        )


def _extremes(first: pd.DataFrame) -> Iterator[Statement]:
    """Worst cells of the full design."""
    for (truth, exponent), group in first.groupby(["truth", "exponent"], sort=True):
        of = f"truth {truth}, {EXPONENTS[str(exponent)]}"
        rows = _records(group)
        for name, column, row in (
            ("least coverage", "coverage", min(rows, key=lambda row: row["coverage"])),
            ("greatest coverage", "coverage", max(rows, key=lambda row: row["coverage"])),
            ("greatest bias of v_c", "bias", max(rows, key=lambda row: abs(row["bias"]))),
            (
                "greatest share of v_c on a bound",
                "v_c_on_bound",
                max(rows, key=lambda row: row["v_c_on_bound"]),
            ),
        ):
            yield f"{name}, {of}", row[column], _place(row)


def _variants(table: pd.DataFrame, reference: Reference) -> Iterator[Statement]:
    """Bias and coverage of every variant from the speed nearest to capture."""
    _, noise, points = reference
    lowest = table["lowest_speed_in_v_c"].min()
    for row in _records(table):
        if (row["noise_of_e"], row["points"], row["lowest_speed_in_v_c"]) == (
            noise,
            points,
            lowest,
        ):
            of = f"truth {row['truth']}, {EXPONENTS[row['exponent']]}, {row['variant']}"
            yield f"bias, {of}", row["bias"], _place(row)
            yield f"coverage, {of}", row["coverage"], _place(row)


def _methods(methods: pd.DataFrame, where: str) -> Iterator[Statement]:
    """Least coverage of every interval method, for each truth."""
    for (truth, method), group in methods.groupby(["truth", "method"], sort=False):
        row = min(_records(group), key=lambda row: row["coverage"])
        note = (
            f"{where}, {EXPONENTS[row['exponent']]}, from {row['lowest_speed_in_v_c']:g} v_c, "
            f"{row['replicates']} replicates"
        )
        yield f"least coverage, truth {truth}, {method}", row["coverage"], note


def _place(row: dict[str, Any]) -> str:
    return (
        f"noise {row['noise_of_e']:g} in e, {row['points']} points, from "
        f"{row['lowest_speed_in_v_c']:g} v_c"
    )


def _records(table: pd.DataFrame) -> list[dict[str, Any]]:
    rows: Any = table.to_dict("records")
    return list(rows)
