"""Figure data of the study of Eq. (34)."""

from __future__ import annotations

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.studies.models.fit_coverage.truths import TRUTHS

Reference = tuple[str, float, int]
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
