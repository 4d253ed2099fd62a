"""Normal impact: from a contact and a speed to restitution, contact time, impulses and works.

The equation of motion (25) is scaled so that every number stays of order one: by the adhesive
scale (V, equilibrium compression) below the velocity scale V, by the impact's own speed above it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, Real, common_shape
from microimpact.core.computable import NotComputable
from microimpact.model import passes
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics import force_laws, kernel
from microimpact.model.dynamics.force_laws import Scales

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
# Adhesion over the Hertz force at the scale of length: below, it is lost in rounding.
NEGLIGIBLE = 1e-17

# Above this c_H v the rebound is stiff: it creeps at nearly the speed 1/c_H, at which damping and
# Hertz force cancel, and is integrated only from the compression on to which this c_H v leads.
STIFF = 1e4
# Far beyond this c_H v the series of the approach leave double precision.
LARGEST_DAMPING = 1e15

# Depth of the well of Hertz and ring force, in the adhesive scale.
WELL_DEPTH = 4.0 / 15.0


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
    losses
        Where the energy went by another law than the ring force; None by that one.
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
    losses: Losses | None = None


@dataclass(frozen=True, slots=True)
class Losses:
    """Energy lost in the bulk, viscous or plastic, and to adhesion, J: all that was lost.

    For a captured sphere, `bulk` is the loss of the first compression, and `adhesion` the rest of
    the energy before impact: negative if the bulk takes more than that, by the work of the pull.
    """

    bulk: FloatArray
    adhesion: FloatArray

    @property
    def adhesion_share(self) -> FloatArray:
        """Share of all that is lost that is lost to adhesion."""
        return np.asarray(self.adhesion / (self.bulk + self.adhesion))


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

    Problems (n, columns), their scales (n,) or (1,), and the shape the flat results go back to.
    Raises ValueError if shapes do not broadcast, or a speed is too small or damped too heavily for
    double precision.
    """
    shape = common_shape({"contact": contact.extent, "speed": speed})

    def flat(value: Real) -> Any:
        return passes.flat(value, shape) if shape else float(value)

    # Plain numbers are ten times as fast as arrays of one.
    where: Any = np.where if shape else _either
    v, (mass, own_scale, hertz, equilibrium) = flat(speed), map(flat, contact.scales)
    hertz_damping, damping = flat(contact.hertz_damping), flat(contact.adhesion_damping_at(speed))
    _require_computable(v, own_scale, hertz_damping * v)
    adhesive = v < own_scale
    length = where(adhesive, equilibrium, np.power(mass * v * v / hertz, 0.4))
    velocity = where(adhesive, own_scale, v)
    always_captured = (equilibrium > 0.0) & (
        (hertz_damping * own_scale > ALWAYS_CAPTURED_HERTZ_GROUP)
        | (damping * own_scale > ALWAYS_CAPTURED_ADHESION_GROUP)
    )
    problems = np.zeros((math.prod(shape), kernel.PROBLEM_COLUMNS))
    rows = problems.T if shape else problems[0]
    adhesion = equilibrium / length
    rows[kernel.START_U] = v / velocity
    rows[kernel.ADHESION] = where(adhesion < NEGLIGIBLE, 0.0, adhesion)
    rows[kernel.HERTZ_DAMPING] = hertz_damping * velocity
    rows[kernel.DAMPING_2] = where(always_captured, 0.0, damping * velocity)
    if contact.damped_attachment:
        rows[kernel.DAMPING_1] = damping * velocity
    rows[kernel.ALWAYS_CAPTURED] = always_captured
    scales = (length, velocity, mass) if shape else np.array([[length], [velocity], [mass]])
    return problems, Scales(*scales), shape


def _either(condition: bool, true: float, false: float) -> float:
    """Return the one or the other number, as `np.where` does for arrays."""
    return true if condition else false


def _require_computable(speed: Real, velocity_scale: Real, damping: Real) -> None:
    """Refuse speeds that are too small, or damped too heavily, for double precision."""
    slow = speed < SMALLEST_SPEED * velocity_scale
    heavy = damping > LARGEST_DAMPING
    if slow is False and heavy is False:
        return
    if np.any(slow):
        raise NotComputable(
            f"speed must be at least {SMALLEST_SPEED:g} of the contact's velocity scale, "
            f"got {np.broadcast_to(speed, np.shape(slow))[slow][0]:g} m/s"
        )
    if np.any(heavy):
        raise NotComputable(
            f"hertz_damping times speed must be at most {LARGEST_DAMPING:g}, "
            f"got {np.max(damping):g}"
        )


def is_shallow(start: FloatArray, adhesion: FloatArray) -> BoolArray:
    """Whether an energy must be taken from the works, by the start and adhesion of problems."""
    shallow: BoolArray = (adhesion == 1.0) & (start < SHALLOW_SPEED)
    return shallow


def integrate(problems: FloatArray, *, ledger: bool) -> FloatArray:
    """Run the kernel, each problem in the mode it needs.

    Raises RuntimeError if an integration did not come to an end.
    """
    results = np.zeros((problems.shape[0], kernel.RESULT_COLUMNS))
    rows, after = (problems[0], results[0]) if len(problems) == 1 else (problems.T, results.T)
    start, adhesion = rows[kernel.START_U], rows[kernel.ADHESION]
    stiff = rows[kernel.HERTZ_DAMPING] * start > STIFF
    shallow = is_shallow(start, adhesion) & ~stiff
    plain = ~(shallow | stiff)
    mode = kernel.LEDGER if ledger else kernel.PLAIN
    _run(problems, shallow, kernel.SHALLOW, results)
    _run(problems, plain, mode, results)
    if _number(stiff):
        chosen = np.atleast_1d(stiff)
        results[chosen] = _stiff(problems[chosen], mode)
    slow = plain & (adhesion == 1.0) & (after[kernel.STATUS] == kernel.REBOUND)
    slow &= -after[kernel.END_U] < SLOW_REBOUND * start
    _run(problems, slow, kernel.SHALLOW, results)
    failed = after[kernel.STATUS] == kernel.FAILED
    if number := _number(failed):
        raise RuntimeError(
            f"the integration of {number} impact(s) failed; "
            f"the first in scaled form: {problems[np.atleast_1d(failed)][0].tolist()}"
        )
    return results


def _number(chosen: BoolArray | np.bool_) -> int:
    """Return how many are chosen, quickly for a single one."""
    return int(chosen) if isinstance(chosen, np.bool_) else int(np.count_nonzero(chosen))


def _run(problems: FloatArray, chosen: BoolArray, mode: int, results: FloatArray) -> None:
    number = _number(chosen)
    if number == len(problems):
        kernel.integrate(problems, mode, results)
    elif number:
        part = np.zeros((number, kernel.RESULT_COLUMNS))
        kernel.integrate(np.ascontiguousarray(problems[chosen]), mode, part)
        results[chosen] = part


def _stiff(problems: FloatArray, mode: int) -> FloatArray:
    """Integrate impacts with c_H v above `STIFF`, where explicit steps would be c_H v in number.

    In units of the speed 1/c_H the rebound obeys, with the speed w of separation at compression x,
    the strength of adhesion b and A = c_A/c_H,

        dw/dt = k (w_0 - w),  k = x^(1/2) (x + b A),  w_0 = (x - b)/(x + b A).

    As 1/k is short, w = w_0 + w_0 w_0'/k from shortly after the turning point on, and what comes
    later does not depend on where the sphere turned: the deviation dies as exp(-2/5 x^(5/2)). So
    the kernel integrates the approach, and the rebound from rest at the compression of ``STIFF``;
    between the two the terms are quadratures, with a delay of 1/k after rest. Terms of the order
    of ``STIFF**-2`` are left out. Without adhesion the speed after impact is 1/c_H.
    """
    damping = problems[:, kernel.HERTZ_DAMPING]
    velocity, length = 1.0 / damping, damping**-0.8
    scaled = problems.copy()
    scaled[:, kernel.START_U] *= damping
    scaled[:, kernel.ADHESION] /= length
    scaled[:, kernel.HERTZ_DAMPING] = 1.0
    scaled[:, [kernel.DAMPING_1, kernel.DAMPING_2]] *= velocity[:, None]
    scaled[:, kernel.ALWAYS_CAPTURED] = 1.0
    results = np.zeros((len(scaled), kernel.RESULT_COLUMNS))
    kernel.integrate(scaled, mode, results)
    back = (problems[:, kernel.ALWAYS_CAPTURED] == 0.0) & (
        results[:, kernel.STATUS] != kernel.FAILED
    )
    results[back] = _crept_back(scaled[back], results[back], mode)
    units = np.ones_like(results)
    units[:, [kernel.END_S, kernel.TURNING_S]] = np.sqrt(length)[:, None]
    units[:, [kernel.DURATION, kernel.TURNING_TIME]] = (length / velocity)[:, None]
    units[:, kernel.COMPRESSIVE_IMPULSE : kernel.ADHESION_IMPULSE + 1] = velocity[:, None]
    units[:, [kernel.HERTZ_WORK, kernel.ADHESION_WORK]] = np.square(velocity)[:, None]
    units[:, kernel.END_U] = velocity
    return results * units


@cache
def _quadrature() -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on an interval of length one around zero, made once."""
    nodes, weights = np.polynomial.legendre.leggauss(200)
    return 0.5 * nodes, 0.5 * weights


def _crept_back(problems: FloatArray, approach: FloatArray, mode: int) -> FloatArray:
    """Rebounds of `_stiff`, in its units, added to the results of the approach."""
    beta = problems[:, kernel.ADHESION, None]
    drag = beta * problems[:, kernel.DAMPING_2, None]
    top = np.square(approach[:, kernel.TURNING_S, None])
    rest = np.full_like(top, (2.5 * STIFF) ** 0.4)
    late = problems.copy()
    late[:, kernel.ALWAYS_CAPTURED] = 0.0
    late[:, kernel.START_S], late[:, kernel.START_U] = np.sqrt(rest[:, 0]), SMALLEST_SPEED
    results = np.zeros_like(approach)
    kernel.integrate(late, mode, results)

    def rate(x: FloatArray) -> FloatArray:
        return np.sqrt(x) * (x + drag)

    # Between both places: the integrals go over ln x, as top may be anything.
    nodes, weights = _quadrature()
    span = np.log(top / rest)
    x = rest * np.exp(span * (nodes + 0.5))
    steady = (x - beta) / (x + drag)
    speed = steady * (1.0 + (beta + drag) / np.square(x + drag) / rate(x))
    step = span * x * weights
    lag_top, lag_rest = 1.0 / rate(top), 1.0 / rate(rest)

    def total(per_time: FloatArray, at_top: FloatArray, at_rest: FloatArray) -> FloatArray:
        along = np.sum(per_time / speed * step, axis=1)
        return np.asarray(along + (at_top * lag_top - at_rest * lag_rest)[:, 0])

    unit = np.ones_like(top)
    results[:, kernel.DURATION] += approach[:, kernel.DURATION] + total(np.ones_like(x), unit, unit)
    # Up to the first balance of forces adhesion has added the energy of its well.
    first = np.sqrt(problems[:, kernel.START_U] ** 2 + 2.0 * WELL_DEPTH * beta[:, 0] ** 2.5)
    results[:, kernel.LOWEST_U] = -((top - beta) / (top + drag))[:, 0]
    results[:, kernel.COMPRESSIVE_IMPULSE] = first - results[:, kernel.LOWEST_U]
    results[:, kernel.STEPS] += approach[:, kernel.STEPS]
    for column in (kernel.TURNING_S, kernel.TURNING_TIME):
        results[:, column] = approach[:, column]
    if mode == kernel.PLAIN:
        return results
    for column, strength, power in (
        (kernel.HERTZ_IMPULSE, unit, 1.5),
        (kernel.ADHESION_IMPULSE, beta, 0.5),
    ):
        places = (strength * np.power(position, power) for position in (x, top, rest))
        results[:, column] += approach[:, column] + total(*places)
    for column, lost in (
        (kernel.HERTZ_WORK, np.power(x, 1.5)),
        (kernel.ADHESION_WORK, drag * np.sqrt(x)),
    ):
        results[:, column] += approach[:, column] + np.sum(lost * speed * step, axis=1)
    return results


def normal_impact(contact: Contact, speed: Real, *, ledger: bool = False) -> NormalImpact:
    """Integrate normal impacts, Eq. (25), or solve them by the contact's own law.

    Parameters
    ----------
    contact
        The contact; its fields broadcast with ``speed``.
    speed
        Normal speed of approach, m/s, positive (checked by the callers).
    ledger
        Whether to compute the impulse and work of every term too; of the ring force alone.

    Raises
    ------
    ValueError
        If shapes do not broadcast, or another law is asked for terms of the ring force.
    RuntimeError
        If an integration failed.
    """
    if contact.law is not None:
        require_contact(contact, any_law=not ledger, pair=True)
        return _by_law(contact, speed)
    problems, scales, shape = scaled_problems(contact, speed)
    results = integrate(problems, ledger=ledger)
    outcomes = np.empty((kernel.OUTCOMES, len(results)))
    kernel.outcomes(problems, results, scales.length, scales.velocity, scales.mass, outcomes)
    rows: Any = [row.reshape(shape) for row in outcomes] if shape else outcomes[:, 0].tolist()
    e, time, turning, depth, compressive, peak, hertz = rows
    status = results[:, kernel.STATUS].reshape(shape) if shape else results[0, kernel.STATUS]
    return NormalImpact(
        captured=status == kernel.CAPTURED,
        coefficient_of_restitution=e,
        contact_time=time,
        compression_time=turning,
        maximum_compression=depth,
        compressive_impulse=compressive,
        peak_net_impulse=peak,
        hertz_impulse=hertz if ledger else None,
        ledger=_ledger(problems, results, scales, shape) if ledger else None,
    )


def losses(contact: Contact, speed: Real) -> Losses:
    """Return where the energy of normal impacts went, by the ring force or by another law.

    Parameters
    ----------
    contact, speed
        As in `normal_impact`.
    """
    impact = normal_impact(contact, speed, ledger=contact.law is None)
    if impact.ledger is not None:
        return Losses(impact.ledger.hertz_work, impact.ledger.adhesion_work)
    assert impact.losses is not None
    return impact.losses


def _by_law(contact: Contact, speed: Real) -> NormalImpact:
    problem, scales, shape = force_laws.scaled(contact, speed)
    with np.errstate(over="ignore", invalid="ignore"):  # of brackets; no root is an error
        outcome = force_laws.solve(problem)
    time, impulse = scales.length / scales.velocity, scales.mass * scales.velocity
    s, energy = outcome.deepest, scales.mass * scales.velocity**2
    compression = s**4 - 4.0 * problem.closing * s

    def shaped(values: FloatArray) -> FloatArray:
        return values.reshape(shape)

    return NormalImpact(
        captured=outcome.captured.reshape(shape),
        coefficient_of_restitution=shaped(outcome.speed / problem.speed),
        contact_time=shaped(outcome.time * time),
        compression_time=shaped(outcome.turning_time * time),
        maximum_compression=shaped(compression * scales.length),
        compressive_impulse=shaped(outcome.compressive * impulse),
        peak_net_impulse=shaped(outcome.greatest * impulse),
        losses=Losses(shaped(outcome.bulk * energy), shaped(outcome.adhesion * energy)),
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
