"""A normal impact integrated by heyoka in 80-bit numbers, with its impulses, works and times."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import heyoka as hy
import numpy as np

from microimpact.model.contact import Contact

TOLERANCE = 1e-18
FOREVER = 1e9
# Outcomes of terminal events, in their order below: -1 - index.
TURNED, SEPARATED, FORCE_CHANGED_SIGN = -1, -2, -3

Number = np.longdouble


@dataclass(frozen=True)
class Impact:
    """As `microimpact.model.dynamics.normal.NormalImpact` and its ledger; SI units."""

    captured: bool
    coefficient_of_restitution: float
    contact_time: float
    compression_time: float
    maximum_compression: float
    compressive_impulse: float
    peak_net_impulse: float
    hertz_impulse: float
    adhesion_impulse: float
    hertz_work: float
    adhesion_work: float


@cache
def _integrator(adhesive: bool) -> hy.taylor_adaptive_ldbl:
    """The regular form with quadratures; par: strength of adhesion, C_H, C_A of the leg."""
    names = hy.make_vars("s", "u", "t", "hertz", "ring", "hertz_work", "ring_work")
    s, u = names[:2]
    b, c_h, c_a = hy.par[0], hy.par[1], hy.par[2]
    p = s * s
    rates = [
        0.5 * u,
        b * p * (1.0 - c_a * u) - p * p * (1.0 + c_h * u),
        s,
        p * p,
        b * p,
        c_h * p * p * u * u,
        b * c_a * p * u * u,
    ]
    kind = {"fp_type": Number}
    events = [hy.t_event(u, **kind), hy.t_event(s, direction=hy.event_direction.negative, **kind)]
    if adhesive:
        events.append(hy.t_event(p * (1.0 + c_h * u) - b * (1.0 - c_a * u), **kind))
    return hy.taylor_adaptive(
        list(zip(names, rates, strict=True)),
        [Number(0)] * len(names),
        pars=[Number(0)] * 3,
        t_events=events,
        tol=Number(TOLERANCE),
        compact_mode=True,
        **kind,
    )


def impact(contact: Contact, speed: float) -> Impact:
    """Integrate one impact in the scale of its own speed, straight from the fields of a contact."""
    mass, radius = Number(contact.mass), Number(contact.hertz_radius)
    v = Number(speed)
    stiffness = Number(contact.stiffness) * np.sqrt(radius)
    length = (mass * v * v / stiffness) ** (Number(2) / 5)
    ring = 2 * Number(np.pi) * Number(contact.ring_force) * np.sqrt(radius)
    exponent = float(contact.adhesion_rate_exponent)
    ratio = contact.reference_velocity / speed if exponent else 1.0
    c_a = Number(contact.adhesion_damping) * v * Number(ratio) ** Number(exponent)
    strength = ring / (stiffness * length)

    run = _integrator(bool(strength > 0))
    run.time = Number(0)
    run.state[:] = 0
    run.state[1] = 1
    run.pars[:] = strength, Number(contact.hertz_damping) * v, 0
    run.reset_cooldowns()

    # du is minus the impulse, so the compressive impulse is the fall of u while the force presses.
    pressing, u_before = strength == 0, Number(1)
    compressive, lowest = Number(0), Number(1)
    turning, ended = None, None
    while ended is None:
        outcome = int(run.propagate_until(Number(FOREVER))[0])
        u = run.state[1].copy()
        if outcome == FORCE_CHANGED_SIGN:
            compressive += (u_before - u) if pressing else 0
            pressing, u_before = not pressing, u
        elif outcome == TURNED and turning is None:
            turning = run.state.copy()
            run.pars[2] = c_a
        elif outcome in {TURNED, SEPARATED}:
            ended = outcome
        else:
            raise RuntimeError(f"heyoka ended with {outcome}")
        lowest = min(lowest, u)
    compressive += (u_before - u) if pressing else 0
    captured = ended == TURNED
    time, impulse, energy = length / v, mass * v, mass * v * v
    state = run.state
    return Impact(
        captured=captured,
        coefficient_of_restitution=0.0 if captured else float(-u),
        contact_time=np.inf if captured else float(state[2] * time),
        compression_time=float(turning[2] * time),
        maximum_compression=float(turning[0] ** 2 * length),
        compressive_impulse=float(compressive * impulse),
        peak_net_impulse=float((1 - lowest) * impulse),
        hertz_impulse=float(state[3] * impulse),
        adhesion_impulse=float(-state[4] * impulse),
        hertz_work=float(state[5] * energy),
        adhesion_work=float(state[6] * energy),
    )
