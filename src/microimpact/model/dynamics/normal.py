"""Normal impact: from a contact and a speed to restitution, contact time, impulses and works.

The equation of motion (25) is scaled so that every number stays of order one: by the adhesive
scale (V, equilibrium compression) below the velocity scale V, by the impact's own speed above it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Real, common_shape
from microimpact.model.contact import Contact
from microimpact.model.dynamics import kernel

# By comparison of trajectories, more damping never helps a rebound. Without adhesion damping no
# speed rebounds above C_H = 0.48741, without material damping none above C_A = 1.16280 (by the
# backward map), so beyond these bounds capture needs no integration, however stiff the equation.
ALWAYS_CAPTURED_HERTZ_GROUP = 0.49
ALWAYS_CAPTURED_ADHESION_GROUP = 1.17

# The kinetic energy is a small difference of large ones below this speed, in velocity scales, and
# after a rebound with less than this restitution from below one velocity scale: there it is taken
# from the works of damping.
SHALLOW_SPEED = 0.1
SLOW_REBOUND = 0.05
SMALLEST_SPEED = 1e-30

# Depth of the well of Hertz and ring force, in the adhesive scale.
WELL_DEPTH = 4.0 / 15.0


@dataclass(frozen=True, slots=True)
class Scales:
    """Scales of length, velocity and mass of each impact (flat arrays, SI)."""

    length: FloatArray
    velocity: FloatArray
    mass: FloatArray


@dataclass(frozen=True, slots=True)
class NormalImpact:
    """Outcome of normal impacts; every field has the broadcast shape of contact and speed.

    Attributes
    ----------
    captured
        True where the sphere does not leave.
    coefficient_of_restitution
        e of Eq. (1); 0 where captured.
    contact_time
        From touch to separation, s; infinite where captured.
    compression_time
        From touch to the greatest compression, s; infinite where an overdamped sphere creeps
        towards equilibrium and never turns.
    maximum_compression
        m; in that case the compression at equilibrium.
    compressive_impulse
        Integral of the compressive part of the normal force over the contact, N s.
    peak_net_impulse
        Greatest value that the integral of the normal force reaches, N s.
    hertz_impulse
        Integral of the Hertz term alone, N s; None unless asked for.
    ledger
        Energy and momentum balance; None unless asked for.
    interpolation_error
        Bound of the relative difference from integration; 0 where every impact was integrated.
    """

    captured: BoolArray
    coefficient_of_restitution: FloatArray
    contact_time: FloatArray
    compression_time: FloatArray
    maximum_compression: FloatArray
    compressive_impulse: FloatArray
    peak_net_impulse: FloatArray
    hertz_impulse: FloatArray | None = None
    ledger: Ledger | None = None
    interpolation_error: FloatArray | float = 0.0


@dataclass(frozen=True, slots=True)
class Ledger:
    """Where energy and momentum went, up to separation or to the moment capture is decided.

    Works in J and impulses in N s, each positive as named. The residuals are what the separately
    integrated entries leave unexplained, relative to the scale of the path: the energy before
    impact or the depth of the well, the Hertz impulse or the momentum before impact, whichever is
    larger.

    Attributes
    ----------
    kinetic_before, kinetic_after, stored
        Kinetic energy before and after; energy stored in Hertz and ring force (0 on separation).
    hertz_work, adhesion_work
        Energy dissipated by the material and by the adhesion damping.
    hertz_impulse, adhesion_impulse
    hertz_damping_impulse, adhesion_damping_impulse
        Impulse of each term of Eq. (19), positive away from the surface.
    energy_residual, momentum_residual
        Imbalance, relative.
    """

    kinetic_before: FloatArray
    kinetic_after: FloatArray
    stored: FloatArray
    hertz_work: FloatArray
    adhesion_work: FloatArray
    hertz_impulse: FloatArray
    adhesion_impulse: FloatArray
    hertz_damping_impulse: FloatArray
    adhesion_damping_impulse: FloatArray
    energy_residual: FloatArray
    momentum_residual: FloatArray


def scaled_problems(contact: Contact, speed: Real) -> tuple[FloatArray, Scales, tuple[int, ...]]:
    """Write each impact as a problem of the kernel.

    Returns
    -------
    problems, scales, shape
        Problems (n, columns), their scales (n,), and the shape the flat results go back to.

    Raises
    ------
    ValueError
        If shapes do not broadcast, or a speed is too small for double precision.
    """
    shape = common_shape({"contact": np.empty(contact.shape), "speed": speed})

    def flat(value: Real) -> FloatArray:
        return np.full(shape, value, dtype=np.float64).ravel()

    v, own_scale, mass = flat(speed), flat(contact.velocity_scale), flat(contact.mass)
    if np.any(v < SMALLEST_SPEED * own_scale):
        raise ValueError(
            f"speed must be at least {SMALLEST_SPEED:g} of the contact's velocity scale, "
            f"got {v[v < SMALLEST_SPEED * own_scale][0]:g} m/s"
        )
    hertz = flat(np.sqrt(contact.hertz_radius) * contact.stiffness)
    equilibrium = flat(contact.equilibrium_compression)
    adhesive = v < own_scale
    length = np.where(adhesive, equilibrium, (mass * v**2 / hertz) ** 0.4)
    velocity = np.where(adhesive, own_scale, v)
    damping = flat(contact.adhesion_damping_at(speed))
    always_captured = (flat(contact.hertz_damping) * own_scale > ALWAYS_CAPTURED_HERTZ_GROUP) | (
        damping * own_scale > ALWAYS_CAPTURED_ADHESION_GROUP
    )
    always_captured &= equilibrium > 0.0
    problems = np.zeros((v.size, kernel.PROBLEM_COLUMNS))
    problems[:, kernel.START_U] = v / velocity
    problems[:, kernel.ADHESION] = equilibrium / length
    problems[:, kernel.HERTZ_DAMPING] = flat(contact.hertz_damping) * velocity
    problems[:, kernel.DAMPING_2] = np.where(always_captured, 0.0, damping * velocity)
    if contact.damped_attachment:
        problems[:, kernel.DAMPING_1] = damping * velocity
    problems[:, kernel.ALWAYS_CAPTURED] = always_captured
    return problems, Scales(length, velocity, mass), shape


def is_shallow(problems: FloatArray) -> BoolArray:
    """Tell for each problem (last axis) whether its energy must be taken from the works."""
    slow = problems[..., kernel.START_U] < SHALLOW_SPEED
    shallow: BoolArray = (problems[..., kernel.ADHESION] == 1.0) & slow
    return shallow


def integrate(problems: FloatArray, *, ledger: bool) -> FloatArray:
    """Run the kernel, each problem in the mode it needs.

    Raises
    ------
    RuntimeError
        If an integration did not come to an end.
    """
    start, adhesion = problems[:, kernel.START_U], problems[:, kernel.ADHESION]
    shallow = is_shallow(problems)
    results = np.zeros((problems.shape[0], kernel.RESULT_COLUMNS))
    _run(problems, shallow, kernel.SHALLOW, results)
    _run(problems, ~shallow, kernel.LEDGER if ledger else kernel.PLAIN, results)
    slow = (results[:, kernel.STATUS] == kernel.REBOUND) & (adhesion == 1.0)
    slow &= ~shallow & (-results[:, kernel.END_U] < SLOW_REBOUND * start)
    _run(problems, slow, kernel.SHALLOW, results)
    failed = np.flatnonzero(results[:, kernel.STATUS] == kernel.FAILED)
    if failed.size:
        raise RuntimeError(
            f"the integration of {failed.size} impact(s) failed; "
            f"the first in scaled form: {problems[failed[0]].tolist()}"
        )
    return results


def _run(problems: FloatArray, chosen: BoolArray, mode: int, results: FloatArray) -> None:
    if np.all(chosen):
        kernel.integrate(problems, mode, results)
    elif np.any(chosen):
        part = np.zeros((int(chosen.sum()), kernel.RESULT_COLUMNS))
        kernel.integrate(np.ascontiguousarray(problems[chosen]), mode, part)
        results[chosen] = part


def normal_impact(contact: Contact, speed: Real, *, ledger: bool = False) -> NormalImpact:
    """Integrate normal impacts, Eq. (25).

    Parameters
    ----------
    contact
        The contact; its fields broadcast with ``speed``.
    speed
        Normal speed of approach, m/s, positive (checked by the callers).
    ledger
        Whether to compute the impulse and work of every term too.

    Raises
    ------
    ValueError
        If shapes do not broadcast.
    RuntimeError
        If an integration failed.
    """
    problems, scales, shape = scaled_problems(contact, speed)
    results = integrate(problems, ledger=ledger)
    captured = results[:, kernel.STATUS] == kernel.CAPTURED
    start, end = problems[:, kernel.START_U], results[:, kernel.END_U]
    time, impulse = scales.length / scales.velocity, scales.mass * scales.velocity

    def shaped(values: FloatArray) -> FloatArray:
        return values.reshape(shape)

    return NormalImpact(
        captured=captured.reshape(shape),
        coefficient_of_restitution=shaped(np.where(captured, 0.0, -end / start)),
        contact_time=shaped(np.where(captured, np.inf, results[:, kernel.DURATION] * time)),
        compression_time=shaped(results[:, kernel.TURNING_TIME] * time),
        maximum_compression=shaped(results[:, kernel.TURNING_S] ** 2 * scales.length),
        compressive_impulse=shaped(results[:, kernel.COMPRESSIVE_IMPULSE] * impulse),
        peak_net_impulse=shaped((start - results[:, kernel.LOWEST_U]) * impulse),
        hertz_impulse=shaped(results[:, kernel.HERTZ_IMPULSE] * impulse) if ledger else None,
        ledger=_ledger(problems, results, scales, shape) if ledger else None,
    )


def _ledger(
    problems: FloatArray, results: FloatArray, scales: Scales, shape: tuple[int, ...]
) -> Ledger:
    start, end = problems[:, kernel.START_U], results[:, kernel.END_U]
    s = results[:, kernel.END_S]
    settled = np.isinf(results[:, kernel.TURNING_TIME])
    turning = np.where(settled, s, results[:, kernel.TURNING_S])
    beta = problems[:, kernel.ADHESION]
    stored = 0.4 * s**5 - 2.0 / 3.0 * beta * s**3
    lost = results[:, kernel.HERTZ_WORK] + results[:, kernel.ADHESION_WORK]
    # The damping impulses are perfect differentials: their integrands hold u dtau = 2 ds.
    hertz_damping = 0.4 * problems[:, kernel.HERTZ_DAMPING] * s**5
    adhesion_damping = (2.0 / 3.0 * beta) * (
        problems[:, kernel.DAMPING_1] * turning**3
        - problems[:, kernel.DAMPING_2] * (turning**3 - s**3)
    )
    hertz, ring = results[:, kernel.HERTZ_IMPULSE], results[:, kernel.ADHESION_IMPULSE]
    energy_in = 0.5 * start**2
    energy_error = energy_in - 0.5 * end**2 - stored - lost
    momentum_error = start - end - (hertz - ring + hertz_damping + adhesion_damping)
    energy, impulse = scales.mass * scales.velocity**2, scales.mass * scales.velocity

    def shaped(values: FloatArray) -> FloatArray:
        return values.reshape(shape)

    return Ledger(
        kinetic_before=shaped(energy_in * energy),
        kinetic_after=shaped(0.5 * end**2 * energy),
        stored=shaped(stored * energy),
        hertz_work=shaped(results[:, kernel.HERTZ_WORK] * energy),
        adhesion_work=shaped(results[:, kernel.ADHESION_WORK] * energy),
        hertz_impulse=shaped(hertz * impulse),
        adhesion_impulse=shaped(-ring * impulse),
        hertz_damping_impulse=shaped(hertz_damping * impulse),
        adhesion_damping_impulse=shaped(adhesion_damping * impulse),
        energy_residual=shaped(energy_error / np.maximum(energy_in, WELL_DEPTH * beta**2.5)),
        momentum_residual=shaped(momentum_error / np.maximum(hertz, start)),
    )
