"""Figure data of the pair search: a stretch of a stream, and its quality against speed."""

from __future__ import annotations

import numpy as np
import pandas as pd

from microimpact.core.tables import series_frame
from microimpact.lab.pdpa.observation import Observation

SHARES = {"precision": "precision", "recall": "recall", "seen": "recall_of_seen_rebounds"}


def stream_shown(found: Observation, window: float) -> pd.DataFrame:
    """Return the stretch of a stream with the most records, velocity against time in ms.

    Parameters
    ----------
    found
        The experiment.
    window
        Length of the stretch, ms.
    """
    stream, pairing = found.stream, found.pairing
    time = 1e3 * stream.time
    # A stretch begins a little ahead of a record; those of a stream are in order of time.
    starts = time - 0.05 * window
    number = np.searchsorted(time, starts + window) - np.arange(len(time))
    start = float(starts[np.argmax(number)]) if len(time) else 0.0
    shown = (time >= start) & (time <= start + window)
    series = {
        "falling": np.flatnonzero(shown & (stream.velocity < 0.0)),
        "rising": np.flatnonzero(shown & (stream.velocity > 0.0)),
    }
    pairs = np.column_stack([pairing.incident, pairing.rebound])
    whole = pairs[np.all(shown[pairs], axis=1)]
    series |= {f"pair {i}": pair for i, pair in enumerate(whole, start=1)}
    return pd.concat(
        [
            series_frame(
                panel="stream",
                series=name,
                evidence="virtual experiment",
                x=time[records] - start,
                y=stream.velocity[records],
                x_unit="ms",
                y_unit="m_per_s",
            )
            for name, records in series.items()
        ],
        ignore_index=True,
    )


def pairing_curves(quality: pd.DataFrame) -> pd.DataFrame:
    """Return precision and recall against speed, a series per height of the probe volume."""
    frames = []
    for panel, share in SHARES.items():
        for height, rows in quality[quality[share].notna()].groupby("probe_height_mm"):
            names = (share, f"{share}_low", f"{share}_high")
            y, low, high = (rows[name].to_numpy(float) for name in names)
            frames.append(
                series_frame(
                    panel=panel,
                    series=f"h = {height:g} mm",
                    evidence="virtual experiment",
                    x=rows["speed_m_per_s"].to_numpy(float),
                    y=y,
                    x_unit="m_per_s",
                    y_unit="1",
                    y_low=low,
                    y_high=high,
                )
            )
    return pd.concat(frames, ignore_index=True)
