"""Capture velocity by time reversal.

The state of a sphere that has just escaped, at rest with no compression, determines the impact that
led to it: its initial speed is the capture velocity, found by one integration.
"""

from __future__ import annotations

import math

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.solve import roots
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics import force_laws, kernel
from microimpact.model.dynamics.normal import (
    ALWAYS_CAPTURED_ADHESION_GROUP,
    ALWAYS_CAPTURED_HERTZ_GROUP,
    integrate,
)

# The exit at rest is a degenerate point of the regular form. On the branch that leaves it,
# s = r^2 and u = r^3 y with y regular in r; at this r its neglected terms are below rounding, and
# the small steps from nearer to the exit are spared.
BRANCH_START = 1e-2

# Logarithms of the speed, in velocity scales, and of a damping group, beyond which is nothing new.
LARGEST_LOG_SPEED = 50.0
LARGEST_LOG_GROUP = 7.0
SEARCH = {"absolute": 1e-14, "relative": 1e-14, "residual": 1e-14}


def threshold(
    hertz_group: FloatArray, adhesion_group: FloatArray, damped_attachment: bool
) -> FloatArray:
    """Capture velocity in velocity scales from the damping groups (flat arrays).

    Infinite where no speed rebounds.

    Parameters
    ----------
    hertz_group, adhesion_group
        Damping groups C_H and C_A at the reference velocity, flat arrays of one shape.
    damped_attachment
        Whether adhesion is damped during approach, too.
    """
    # Beyond these all is captured, and far beyond them the equation is too stiff to integrate.
    hertz_group = np.minimum(hertz_group, ALWAYS_CAPTURED_HERTZ_GROUP)
    adhesion_group = np.minimum(adhesion_group, ALWAYS_CAPTURED_ADHESION_GROUP)
    problems = np.zeros((hertz_group.size, kernel.PROBLEM_COLUMNS))
    r = BRANCH_START
    y = math.sqrt(4.0 / 3.0) + 4.0 / 9.0 * adhesion_group * r**3 - 0.4 / math.sqrt(4.0 / 3.0) * r**4
    problems[:, kernel.START_S] = r**2
    problems[:, kernel.START_U] = r**3 * y
    problems[:, kernel.ADHESION] = 1.0
    problems[:, kernel.HERTZ_DAMPING] = -hertz_group
    problems[:, kernel.DAMPING_1] = -adhesion_group
    if damped_attachment:
        problems[:, kernel.DAMPING_2] = -adhesion_group
    results = integrate(problems, ledger=True)
    escaped = results[:, kernel.STATUS] == kernel.ESCAPED
    return np.where(escaped, np.inf, -results[:, kernel.END_U])


def capture_velocity(contact: Contact) -> FloatArray:
    """Normal speed below which the sphere is captured.

    Parameters
    ----------
    contact
        The contact, its fields of any shape.

    Returns
    -------
    ndarray
        m/s, in the contact's shape. Zero without adhesion or without damping, infinite where no
        speed rebounds.

    Raises
    ------
    RuntimeError
        If an integration failed.
    """
    require_contact(contact, any_law=True, pair=True)
    if contact.law is not None:
        return force_laws.capture_speed(contact)
    shape = contact.shape

    def flat(value: Real) -> FloatArray:
        return np.full(shape, value, dtype=np.float64).ravel()

    scale = flat(contact.velocity_scale)
    hertz, adhesion = (flat(group) for group in contact.groups)
    reference = np.ones_like(scale)
    if contact.reference_velocity is not None:
        reference = flat(contact.reference_velocity) / np.where(scale > 0.0, scale, 1.0)
    limit = np.zeros(scale.size)
    adhesive = scale > 0.0
    groups = (hertz, adhesion, flat(contact.adhesion_rate_exponent), reference)
    limit[adhesive] = scaled_capture_velocity(
        *(group[adhesive] for group in groups), damped_attachment=contact.damped_attachment
    )
    return (limit * scale).reshape(shape)[()]


def scaled_capture_velocity(
    hertz: FloatArray,
    adhesion: FloatArray,
    exponent: FloatArray,
    reference: FloatArray,
    *,
    damped_attachment: bool,
) -> FloatArray:
    """Capture velocity of adhesive contacts in velocity scales, all arguments flat arrays.

    Parameters
    ----------
    hertz, adhesion
        Damping groups C_H and C_A, the latter at the reference velocity.
    exponent, reference
        n and the reference velocity, in velocity scales, of the rate of adhesion damping.
    damped_attachment
        Whether adhesion is damped during approach too.

    Returns
    -------
    ndarray
        Zero without damping, infinite where no speed rebounds.
    """
    limit = np.zeros(hertz.size)
    damped = (hertz > 0.0) | (adhesion > 0.0)
    rated = damped & (exponent > 0.0) & (adhesion > 0.0)
    plain = damped & ~rated
    if np.any(plain):
        limit[plain] = threshold(hertz[plain], adhesion[plain], damped_attachment)
    if np.any(rated):
        groups = hertz[rated], adhesion[rated], exponent[rated], reference[rated]
        limit[rated] = _rated_threshold(*groups, damped_attachment=damped_attachment)
    return limit


def _rated_threshold(
    hertz: FloatArray,
    adhesion: FloatArray,
    exponent: FloatArray,
    reference: FloatArray,
    *,
    damped_attachment: bool,
) -> FloatArray:
    """Solve ``w = threshold(C_H, C_A (w_N/w)^n)``: the right side falls with w, so one w does."""

    def log_limit(
        log_w: FloatArray, c_h: FloatArray, c_a: FloatArray, n: FloatArray, w_n: FloatArray
    ) -> FloatArray:
        log_group = np.log(c_a) + n * (np.log(w_n) - log_w)
        group = np.exp(np.minimum(log_group, LARGEST_LOG_GROUP))
        limit = threshold(np.ravel(c_h), np.ravel(group), damped_attachment)
        return np.log(limit).reshape(log_w.shape)

    def excess(log_w: FloatArray, *arguments: FloatArray) -> FloatArray:
        return np.maximum(log_w - log_limit(log_w, *arguments), -LARGEST_LOG_SPEED)

    arguments = hertz, adhesion, exponent, reference
    top = np.full(hertz.size, LARGEST_LOG_SPEED)
    # As the right side falls, the solution lies between any w and the right side there.
    start = np.log(reference)
    ends = start, np.clip(log_limit(start, *arguments), -top, top)
    # Only where nothing rebounds at the one speed may there be no solution at all.
    there = ends[1] < top
    if not np.all(there):
        there[~there] = excess(top[~there], *(a[~there] for a in arguments)) > 0.0
    limit = np.full(top.size, np.inf)
    limit[there] = np.exp(roots(excess, *(a[there] for a in (*ends, *arguments)), **SEARCH))
    return limit
