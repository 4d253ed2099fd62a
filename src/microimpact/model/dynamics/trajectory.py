"""Dense trajectory of one impact: compression, velocity, spin and every force against time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval

from microimpact.core.arrays import FloatArray, Numbers, Real, checked, whole
from microimpact.core.extras import optional
from microimpact.core.readable import Readable
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics import force_laws, kernel, law_paths
from microimpact.model.dynamics.impact import (
    ANGLE,
    PULL_OFF,
    SPEED,
    chosen_basis,
    velocity_components,
)
from microimpact.model.dynamics.normal import integrate, is_shallow, scaled_problems
from microimpact.model.rigid_body.algebra import APPROACHING, INERTIA, SLIP_PER_IMPULSE, SPIN

# Steps that memory is kept for at first, and at most.
STEPS, MOST_STEPS = 256, 1_000_000

# A captured sphere is followed for this many times its first compression, or the time after which
# an overdamped one is known to creep.
CAPTURED_PERIODS = 8.0

# Rounding of times, relative.
ROUNDING = 1e-14

# Time, compression, velocity and impulse per mass that friction rests on; the terms of the force,
# and whether the sphere stays.
Followed = tuple[tuple[FloatArray, ...], tuple[FloatArray, ...], bool]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True, slots=True, repr=False)
class Trajectory(Readable):
    """One impact against time; every array has the shape (points,), SI units.

    Attributes
    ----------
    time
        From touch, evenly spaced to separation (or into the adhesive well, where captured; by
        another law than the ring force to the second turning point), s.
    compression
        Approach of the sphere beyond touch, -n, m.
    velocity, tangential_velocity
        Normal velocity (negative: approaching) and tangential velocity of the centre, m/s.
    spin, slip
        Spin, rad/s, and velocity of the contact point along the surface, m/s.
    hertz_force, hertz_damping_force, adhesion_force, adhesion_damping_force
        The four terms of Eq. (19), N, positive away from the surface. By another law than the ring
        force: what presses, the loss in the bulk, the pull of adhesion, and nothing.
    normal_force, friction_force
        Their sum, and the tangential force of Eq. (27) as corrected, N.
    captured
        Whether the sphere stays.
    """

    time: FloatArray
    compression: FloatArray
    velocity: FloatArray
    tangential_velocity: FloatArray
    spin: FloatArray
    slip: FloatArray
    hertz_force: FloatArray
    hertz_damping_force: FloatArray
    adhesion_force: FloatArray
    adhesion_damping_force: FloatArray
    normal_force: FloatArray
    friction_force: FloatArray
    captured: bool

    def plot(self) -> Any:
        """Draw compression and forces against time; return Matplotlib's figure.

        Raises ModuleNotFoundError if Matplotlib is not installed.
        """
        figure, (above, below) = optional("matplotlib.pyplot").subplots(
            2, sharex=True, layout="constrained"
        )
        above.plot(1e9 * self.time, 1e9 * self.compression, color="black")
        above.set_ylabel("compression (nm)")
        for name, line in (("normal", "-"), ("friction", "--"), ("hertz", ":"), ("adhesion", "-.")):
            force = getattr(self, f"{name}_force")
            below.plot(1e9 * self.time, 1e3 * force, line, color="black", label=name.title())
        below.set(xlabel="time (ns)", ylabel="force (mN)")
        below.legend()
        return figure


def trajectory(
    contact: Contact,
    speed: Numbers,
    angle: Numbers = 90.0,
    spin: Numbers = 0.0,
    points: int = 400,
    friction_basis: str = "compressive",
) -> Trajectory:
    """Follow one impact in time.

    Parameters
    ----------
    contact
        One contact (no arrays).
    speed, angle, spin, friction_basis
        As in `simulate`; single numbers.
    points
        Number of times, at least 2.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a single number, or out of range.
    RuntimeError
        If the integration failed.
    """
    require_contact(contact, any_law=True)
    basis = chosen_basis(contact, friction_basis)
    points = whole("points", points, 2)
    speed = checked("speed", speed, SPEED)
    angle = checked("angle", angle, ANGLE)
    spin = checked("spin", spin, SPIN)
    for name, value in {"speed": speed, "angle": angle, "spin": spin}.items():
        if np.ndim(value):
            raise ValueError(f"{name} must be a single number, got an array of {np.shape(value)}")
    if contact.shape:
        raise ValueError(f"contact must be a single one, got fields of shape {contact.shape}")
    v_n, v_t = velocity_components(speed, angle)
    v_n = checked("v_n", v_n, APPROACHING)  # may have vanished
    followed = _by_ring_force if contact.law is None else _by_law
    motion, terms, captured = followed(contact, -v_n, points, basis)
    time, compression, velocity, impulse = motion
    normal = sum(terms[1:], terms[0])
    pull = normal + 2.0 * float(contact.pull_off_force or 0.0)
    supports = {"compressive": np.maximum(normal, 0.0), "hertz": terms[0], "net": normal}
    supports |= {PULL_OFF: pull}
    radius, friction = contact.radius, contact.friction
    slip_0 = v_t - radius * spin
    used = SLIP_PER_IMPULSE * friction * impulse
    # the first passage decides: what has rolled once rolls on
    rolling = np.maximum.accumulate(used) >= abs(slip_0)
    slip = np.where(rolling, 0.0, slip_0 - np.sign(slip_0) * used)
    change = (slip_0 - slip) / SLIP_PER_IMPULSE
    return Trajectory(
        time=time,
        compression=compression,
        velocity=velocity,
        tangential_velocity=v_t - change,
        spin=spin + change / (INERTIA * radius),
        slip=slip,
        hertz_force=terms[0],
        hertz_damping_force=terms[1],
        adhesion_force=terms[2],
        adhesion_damping_force=terms[3],
        normal_force=normal,
        friction_force=np.where(rolling, 0.0, -np.sign(slip_0) * friction * supports[basis]),
        captured=captured,
    )


def _by_ring_force(contact: Contact, speed: Real, points: int, basis: str) -> Followed:
    """Motion of `trajectory` by Eq. (25)."""
    problems, scales, _ = scaled_problems(contact, speed)
    problem, result = problems[0], integrate(problems, ledger=True)[0]
    captured = bool(result[kernel.STATUS] == kernel.CAPTURED)
    if problem[kernel.ALWAYS_CAPTURED]:
        # the kernel drops the damping where the sphere is always captured; the path needs it
        damping = contact.adhesion_damping_at(speed) * scales.velocity[0]
        problem[kernel.DAMPING_2] = float(damping)
    end = result[kernel.DURATION]
    if captured:
        end = CAPTURED_PERIODS * min(result[kernel.TURNING_TIME], end)
    time, s, u, impulse = _sample(problem, float(end), captured, points, basis)
    length, velocity, mass = scales.length[0], scales.velocity[0], scales.mass[0]
    force = mass * velocity**2 / length
    beta = problem[kernel.ADHESION]
    damping = np.where(u > 0.0, problem[kernel.DAMPING_1], problem[kernel.DAMPING_2])
    terms = (
        s**3 * force,
        s**3 * problem[kernel.HERTZ_DAMPING] * u * force,
        -beta * s * force,
        beta * s * damping * u * force,
    )
    motion = time * length / velocity, s**2 * length, -u * velocity, impulse * velocity
    return motion, terms, captured


def _by_law(contact: Contact, speed: Real, points: int, basis: str) -> Followed:
    """Motion of `trajectory` by another law."""
    problem, scales, _ = force_laws.scaled(contact, speed)
    path = law_paths.path(problem, points)
    length, velocity, mass = (x[0] for x in (scales.length, scales.velocity, scales.mass))
    force = mass * velocity**2 / length
    zero = np.zeros(points)
    terms = path.hertz * force, path.damping * force, path.adhesion * force, zero
    time, net = path.time * length / velocity, (problem.speed[0] - path.velocity) * velocity
    impulse = {
        "compressive": path.impulse * velocity,
        "net": net,
        PULL_OFF: net + 2.0 * contact.pull_off_force * time / mass,
    }[basis]
    motion = time, path.compression * length, -path.velocity * velocity, impulse
    return motion, terms, bool(force_laws.solve(problem).captured[0])


def _sample(
    problem: FloatArray, end: float, captured: bool, points: int, basis: str
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return times, s, u, and the impulse so far that friction rests on, all in scaled form."""
    room, steps = STEPS, -1
    while steps < 0:
        if room > MOST_STEPS:
            raise RuntimeError(
                f"more than {MOST_STEPS} steps; the impact in scaled form: {problem}"
            )
        series, ends = np.zeros((room, 2, kernel.ORDER + 1)), np.zeros((room, 3))
        # An impact that rebounds ends at s = 0, not by the clock, whose last digit is rounding.
        stop = end if captured else np.inf
        shallow = bool(is_shallow(problem[kernel.START_U], problem[kernel.ADHESION]))
        steps = kernel.record(problem, shallow, stop, series, ends)
        room *= 8
    series, ends = series[:steps], ends[:steps]
    stops = np.cumsum(ends[:, 1])
    time = np.linspace(0.0, end if captured else stops[-1], points)
    step = np.minimum(np.searchsorted(stops, time), steps - 1)
    local = time - (stops - ends[:, 1])[step]
    # Coefficients come first: Horner's scheme then runs over neighbours in memory.
    s_series, u_series = (np.ascontiguousarray(series[step, i].T) for i in (0, 1))
    # The ends, at which the contact time may be flat, are met exactly.
    tau = np.where(local <= 0.0, 0.0, ends[step, 0])
    inner = np.flatnonzero((local > 0.0) & (local < (1.0 - ROUNDING) * ends[step, 1]))
    within = np.empty(inner.size)
    kernel.instants(series, ends[:, 0], step[inner], local[inner], within)
    tau[inner] = within
    s, u = (
        np.maximum(polyval(tau, s_series, tensor=False), 0.0),
        polyval(tau, u_series, tensor=False),
    )
    if not captured:
        s[-1] = 0.0
    if basis == "net":
        return time, s, u, problem[kernel.START_U] - u
    if basis == "hertz":
        impulse = np.concatenate([[0.0], np.cumsum(ends[:, 2])])[step]
        for node, weight in zip(0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS, strict=True):
            impulse = impulse + weight * tau * polyval(node * tau, s_series, tensor=False) ** 4
        return time, s, u, impulse
    # the force has one sign within a step, so u falls through a compressive one
    drop = series[:, 1, 0] - polyval(ends[:, 0], series[:, 1].T, tensor=False)
    impulse = np.concatenate([[0.0], np.cumsum(np.maximum(drop, 0.0))])[step]
    return time, s, u, impulse + np.maximum(u_series[0] - u, 0.0)
