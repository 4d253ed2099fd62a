"""Coordinates in which the outcome of a normal impact is smooth, and interpolation in them.

In units of the impact's own speed and mass an impact depends on three numbers alone: the damping
numbers ``c_H v`` and ``c_A v`` and the strength of adhesion ``b = (V/v)^(4/5)``, where V is the
contact's velocity scale. The two dampings are written as ``D = c_A v + 2 c_H v``, to which the loss
of a slow impact is proportional, and the Hertz damping's share of it. Captured are the impacts with
b of ``b_c(D, share)`` and more: a single surface over a rectangle, whatever the rate exponent.

* The speed at the threshold, in velocity scales, grows like ``D^(1/3)`` from zero.
* e vanishes at the threshold like the square root of the distance, so e over this root is smooth.
* The impulses feel the threshold little but b all the more where it is of order one. The contact
  time has a cube root of the speeds of approach and rebound; `slow_passage` takes it out.

Each axis runs from 0 to 1, with Chebyshev nodes.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.arrays import FloatArray

# Exponents of the axis of damping. That of the impulses makes 1/b linear at the threshold.
THRESHOLD_EXPONENT = 1.0 / 3.0
IMPULSE_EXPONENT = 4.0 / 15.0

# A sphere leaves the well with speed q, in the adhesive scale: near s = 0 the time spent is the
# integral of 2 s ds/sqrt(q^2 + 4/3 s^3), which falls short of its value for q = 0 by this times
# the cube root of q. It is -(2/3) (3/4)^(2/3) B(2/3, -1/6), with Euler's beta function.
SLOW_PASSAGE = (
    -(2.0 / 3.0)
    * 0.75 ** (2.0 / 3.0)
    * math.gamma(2.0 / 3.0)
    * math.gamma(-1.0 / 6.0)
    / math.gamma(0.5)
)


def damping_numbers(damping: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return ``(c_H v, c_A v)`` of a damping D and the share of Hertz damping in it."""
    return damping * share / 2.0, damping * (1.0 - share)


def adhesion_strength(scaled_speed: FloatArray) -> FloatArray:
    """Return b of a speed in velocity scales; 0 where that is infinite."""
    return np.power(scaled_speed, -0.8)


def closeness(strength: FloatArray, critical: FloatArray) -> FloatArray:
    """Return the axis of restitution: 0 at the threshold, 1 without adhesion."""
    return np.sqrt(1.0 - strength / critical)


def impulse_closeness(strength: FloatArray, critical: FloatArray) -> FloatArray:
    """Return the axis of impulses: 0 at the threshold, 1 without adhesion."""
    ratio = strength * (1.0 + critical) / (critical * (1.0 + strength))
    return np.power(1.0 - ratio, 0.25)


def strength_at(axis: FloatArray, critical: FloatArray) -> FloatArray:
    """Return b at a point of the axis of restitution."""
    return (1.0 - np.square(axis)) * critical


def impulse_strength_at(axis: FloatArray, critical: FloatArray) -> FloatArray:
    """Return b at a point of the axis of impulses."""
    rest = (1.0 - np.power(axis, 4)) * critical / (1.0 + critical)
    return rest / (1.0 - rest)


def impulse_unit(strength: FloatArray) -> FloatArray:
    """Return the momentum at the bottom of the well, with the speed of approach as unit."""
    return np.sqrt(1.0 + np.power(strength, 2.5))


def time_unit(strength: FloatArray) -> FloatArray:
    """Return the scale of the contact time, with that of Hertz impact as unit."""
    unit: FloatArray = np.power(1.0 + np.power(strength, 2.5), -0.1)
    return unit


def slow_passage(strength: FloatArray, restitution: FloatArray) -> FloatArray:
    """Return the cube roots of approach and rebound in the contact time over its unit."""
    speed = np.power(1.0 + np.power(strength, 2.5), -1.0 / 6.0)
    passage: FloatArray = SLOW_PASSAGE * speed * (1.0 + np.cbrt(restitution))
    return passage


def chebyshev_nodes(count: int) -> FloatArray:
    """Return the Chebyshev nodes of the first kind on (0, 1), rising."""
    angle = (2.0 * np.arange(count) + 1.0) * np.pi / (4.0 * count)
    nodes: FloatArray = np.square(np.sin(angle))
    return nodes


def node_weights(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Return what each node contributes at each point: the barycentric formula.

    Parameters
    ----------
    nodes
        Chebyshev nodes of the first kind (n,).
    at
        Points (m,) in [0, 1].

    Returns
    -------
    ndarray
        Weights (m, n); each row sums up to 1.
    """
    count = nodes.size
    angle = (2.0 * np.arange(count) + 1.0) * np.pi / (2.0 * count)
    distance = at[:, None] - nodes
    # On a node itself this counts as a distance too small to matter.
    distance[distance == 0.0] = np.finfo(np.float64).tiny
    weights = (-1.0) ** np.arange(count) * np.sin(angle) / distance
    total: FloatArray = weights / weights.sum(axis=1, keepdims=True)
    return total


def interpolate(values: FloatArray, *weights: FloatArray) -> FloatArray:
    """Return a tensor of node values (n_1, ..., n_k) at m points.

    Parameters
    ----------
    values
        Values at the nodes.
    *weights
        For each axis the weights (m, n_i) of `node_weights`.
    """
    first, *others = weights
    result = np.tensordot(first, values, axes=1)
    for rows in others:
        result = np.einsum("mi,mi...->m...", rows, result)
    return result
