"""Data of the figure of the Monte Carlo study (Fig. 23)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from microimpact.core.tables import result_evidence, series_frame
from microimpact.statistics.intervals import student_half_width
from microimpact.studies.analyses.monte_carlo.ensembles import Ensemble
from microimpact.studies.analyses.monte_carlo.events import estimate

# Half-width of the drawn band of standard error.
BAND = 2.0


def figure_data(
    means: pd.DataFrame,
    base: Ensemble,
    *,
    points: int,
    events_measured: int,
    calibration_targets: Sequence[str],
) -> pd.DataFrame:
    """Return tidy data of both panels of Fig. 23.

    Parameters
    ----------
    means
        Estimates of the variants, the table ``monte_carlo``.
    base
        The smooth surface.
    points
        Of its curve.
    events_measured
        Behind one measured mean.
    calibration_targets
        Columns of `means` on which an input was fitted.
    """
    reference = float(means["reference_angle_deg"].iloc[0])
    angles = np.linspace(90.0 / points, 90.0, points)
    curve = pd.DataFrame([estimate(base, float(angle)) for angle in angles])
    bare = estimate(base, reference).restitution
    free = curve["accepted"].to_numpy() > 0.0
    heights = {
        "restitution": curve["restitution"].to_numpy() - bare,
        "impulse_ratio": curve["impulse_ratio"].to_numpy(),
    }
    columns = {"restitution": "relative_restitution", "impulse_ratio": "impulse_ratio"}
    # A measured mean scatters about the true one by Student's t of so many events.
    spread = student_half_width(1.0, events_measured)
    frames = [
        series_frame(
            panel=panel,
            series="smooth",
            evidence="computed",
            x=angles[free],
            y=y[free],
            x_unit="deg",
            y_unit="1",
        )
        for panel, y in heights.items()
    ]
    first = means["variant"].iloc[0]
    for variant, rows in means.groupby("variant", sort=False):
        for panel, column in columns.items():
            y = rows[column].to_numpy()
            bands = {str(variant): BAND * rows[f"{column}_error"].to_numpy()}
            if variant == first:
                bands["measured means"] = spread * rows[f"{panel}_sd"].to_numpy()
            frames += [
                series_frame(
                    panel=panel,
                    series=series,
                    evidence=result_evidence(column, calibration_targets),
                    x=rows["angle_deg"].to_numpy(),
                    y=y,
                    x_unit="deg",
                    y_unit="1",
                    y_low=y - half,
                    y_high=y + half,
                )
                for series, half in bands.items()
            ]
    return pd.concat(frames, ignore_index=True)
