"""One frame of the imaging system as figure data: its pixels, and the track found in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.lab.ptis.system import Setup
from microimpact.lab.ptis.tracks import Track

# Dashes of each leg that are shown, room around them, px, and points of a fitted path.
SHOWN = 5
MARGIN_PX = 12
POINTS = 200


def pixels(frame: NDArray[np.uint8], track: Track, setup: Setup) -> pd.DataFrame:
    """Return the grey levels around a track: one series per row, of the row's number."""
    lines = setup.instrument.frame_px[1] // frame.shape[0]
    left, top, right, bottom = window(track, setup)
    columns = np.arange(left, right)
    return pd.concat(
        [
            series_frame(
                panel="pixels",
                series=str(row * lines),
                evidence="virtual experiment",
                x=columns,
                y=frame[row, left:right],
                x_unit="px",
                y_unit="counts",
            )
            for row in range(top // lines, bottom // lines)
        ],
        ignore_index=True,
    )


def window(track: Track, setup: Setup) -> tuple[int, int, int, int]:
    """Return the part of the frame around the impact: left, top, right, bottom."""
    near = np.concatenate([track.incident.points[-SHOWN:], track.rebound.points[:SHOWN]])
    contact = track.incident.at(np.array([track.incident.contact]))
    places = _places(np.concatenate([near, contact]), setup)
    low = np.maximum(np.floor(places.min(axis=0)) - MARGIN_PX, 0.0)
    high = np.minimum(np.ceil(places.max(axis=0)) + MARGIN_PX, setup.instrument.frame_px)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def drawn_track(track: Track, setup: Setup) -> pd.DataFrame:
    """Return centroids and fitted paths of both legs and the line of the surface, px."""
    inside = _Window(*window(track, setup))
    frames = []
    for name, leg in (("incident", track.incident), ("rebound", track.rebound)):
        last = (len(leg.points) - 1) / setup.chop_rate
        contact = float(leg.contact)
        times = np.linspace(min(0.0, contact), max(last, contact), POINTS)
        frames.append(_series(f"{name} centroids", inside.of(_places(leg.points, setup))))
        frames.append(_series(f"{name} path", inside.of(_places(leg.at(times), setup)), "computed"))
    # Points of the surface, along and below the horizontal: it is turned by 90 deg - alpha.
    alpha = np.radians(setup.angle)
    along = np.linspace(-1.0, 1.0, 2001) * np.hypot(*setup.instrument.frame_px)
    line = inside.of(setup.centre + along[:, None] * [np.sin(alpha), np.cos(alpha)])
    frames.append(_series("surface", line[[0, -1]], "computed"))
    return pd.concat(frames, ignore_index=True)


class _Window(NamedTuple):
    left: int
    top: int
    right: int
    bottom: int

    def of(self, places: FloatArray) -> FloatArray:
        """Return the places inside."""
        low, high = self[:2], self[2:]
        inside: FloatArray = places[np.all((places >= low) & (places < high), axis=1)]
        return inside


def _places(points: FloatArray, setup: Setup) -> FloatArray:
    """Columns and rows of points in m from the image of the target's origin."""
    return setup.centre + points * [1.0, -1.0] / setup.pixel


def _series(series: str, places: FloatArray, evidence: str = "virtual experiment") -> pd.DataFrame:
    return series_frame(
        panel="frame",
        series=series,
        evidence=evidence,
        x=places[:, 0],
        y=places[:, 1],
        x_unit="px",
        y_unit="px",
    )
