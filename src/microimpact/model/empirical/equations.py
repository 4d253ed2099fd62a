"""Empirical coefficients of restitution and adhesion as functions of impact speed (Eqs. 32-34).

The printed forms carry two constants each, k_1 and k_2, kappa_1 and kappa_2. R tends to 1
for a slow impact and rho equals 1 at the capture velocity, as the article states, only if
they are equal, so one constant of each kind is kept. Speeds are magnitudes of the normal
velocity. At and below the capture velocity the sphere stays: rho = 1 and e = 0, where the
bare formula would rise again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, FloatArray, checked, common_shape


def body_restitution(v: ArrayLike, k: ArrayLike, p: ArrayLike) -> FloatArray:
    """Return R, the coefficient of restitution without adhesion (Eq. 32).

    ``R = k^p / (k^p + v^p)``, with k_1 = k_2 = k, in [0, 1].

    Parameters
    ----------
    v
        Normal impact speeds, m/s.
    k
        Speed at which R = 1/2, m/s.
    p
        Exponent.
    """
    speed, scale, exponent = _checked(v=v, k=k, p=p)
    return _share(scale, speed, exponent)


def adhesion_coefficient(
    v: ArrayLike, kappa: ArrayLike, q: ArrayLike, v_c: ArrayLike
) -> FloatArray:
    """Return rho, the part of the rebound impulse that adhesion takes back (Eq. 33).

    ``rho = kappa^q / (kappa^q + (v - v_c)^q)``, with kappa_1 = kappa_2 = kappa, in [0, 1], and 1 up
    to v_c.

    Parameters
    ----------
    v
        Normal impact speeds, m/s.
    kappa
        Excess of speed over v_c at which rho = 1/2, m/s.
    q
        Exponent.
    v_c
        Capture velocity, m/s.
    """
    speed, scale, exponent, capture = _checked(v=v, kappa=kappa, q=q, v_c=v_c)
    return _share(scale, np.maximum(speed - capture, 0.0), exponent)


def restitution(
    v: ArrayLike, k: ArrayLike, p: ArrayLike, kappa: ArrayLike, q: ArrayLike, v_c: ArrayLike
) -> FloatArray:
    """Return e = R (1 - rho), the overall coefficient of restitution (Eq. 34).

    Parameters
    ----------
    v
        Normal impact speed in m/s, any shape; 0 or more.
    k, p
        Speed scale in m/s and exponent of R (Eq. 32); positive.
    kappa, q
        Speed scale in m/s and exponent of rho (Eq. 33); positive.
    v_c
        Capture velocity in m/s, at and below which e = 0; 0 or more.

    Returns
    -------
    ndarray
        e in [0, 1], of the broadcast shape.

    Raises
    ------
    TypeError
        If an argument does not hold real numbers.
    ValueError
        If an argument is out of range or not finite, or the shapes do not broadcast.
    """
    speed, k, p, kappa, q, capture = _checked(v=v, k=k, p=p, kappa=kappa, q=q, v_c=v_c)
    excess = np.maximum(speed - capture, 0.0)
    # The last factor is 1 - rho, without the cancellation near the capture velocity.
    return _share(k, speed, p) * _share(excess, kappa, q)


def _share(a: FloatArray, b: FloatArray, exponent: FloatArray) -> FloatArray:
    """Return a^n / (a^n + b^n) for a, b >= 0, not both 0, without overflow."""
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(1.0 / (1.0 + np.exp(exponent * (np.log(b) - np.log(a)))))


def _checked(**arguments: object) -> list[FloatArray]:
    """Return the arguments as arrays of one shape, all finite and in range."""
    arrays = {
        name: np.asarray(checked(name, value, NON_NEGATIVE if name in {"v", "v_c"} else POSITIVE))
        for name, value in arguments.items()
    }
    shape = common_shape(arrays)
    return [np.broadcast_to(array, shape) for array in arrays.values()]
