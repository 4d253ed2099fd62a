"""Shares of counted cases and how well they are known."""

from __future__ import annotations

import numpy as np

CONFIDENCE = 0.95


def wilson_interval(part: int, whole: int) -> tuple[float, float]:
    """Ends of the 95 % interval of a share by Wilson's score.

    SciPy's `scipy.stats.binomtest` gives the same, and takes half a second to import.

    Parameters
    ----------
    part, whole
        Number of cases counted, and of all cases, at least 1.
    """
    from scipy.special import ndtri

    z = float(ndtri(0.5 * (1.0 + CONFIDENCE)))
    share, scale = part / whole, 2.0 * (whole + z**2)
    centre = (2.0 * part + z**2) / scale
    half = z / scale * float(np.sqrt(4.0 * part * (1.0 - share) + z**2))
    return (centre - half if part else 0.0), (centre + half if part < whole else 1.0)
