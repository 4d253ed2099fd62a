"""Parameters estimated from impacts: the article's two-stage method (3.2.1), and its kin.

At a high speed the material damping is chosen to meet the measured restitution; with it the
adhesion damping is chosen at a low speed; and so on in turn until both targets hold. Here the low
target is the capture velocity, where restitution is zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from microimpact.core.arrays import POSITIVE, BoolArray, Range, Real, checked, common_shape
from microimpact.core.computable import NotComputable
from microimpact.core.solve import root, threshold
from microimpact.model.choices import FittedLaw
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity, scaled_capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.trajectory import trajectory

OPEN_UNIT_INTERVAL = Range(lower=0.0, upper=1.0)

MOST_TURNS = 200
TOLERANCE = 1e-10
# Relative error of each root.
ROOT_TOLERANCE = 1e-13

# Viscous times, s, and inverse yield pressures, 1/Pa, looked through.
LOSSES = {JKR.name: (1e-14, 1e-6), ThorntonNing.name: (1e-13, 1e-6)}

# Damping per 1/speed beyond which nothing rebounds any more.
LARGEST_DAMPING = 1e3


class NoSolutionError(NotComputable):
    """No admissible parameter meets the target."""


@dataclass(frozen=True, slots=True)
class TwoStage:
    """A contact with both damping coefficients estimated, and how often both stages were run."""

    contact: Contact
    turns: int


def two_stage(
    contact: Contact, high_speed: Real, restitution: Real, capture_speed: Real
) -> TwoStage:
    """Estimate both damping coefficients of a contact, or of each of many.

    Parameters
    ----------
    contact
        The contact, its fields of any shape; its damping coefficients are not used.
    high_speed
        Normal speed of the first stage, m/s; this and the targets broadcast with the contact.
    restitution
        Restitution measured there, in (0, 1).
    capture_speed
        Capture velocity of the second stage, m/s.

    Raises
    ------
    NoSolutionError
        If no pair of non-negative coefficients meets both; the message says which end fails, what
        to change, and of an array, where.
    ValueError, TypeError
        If a target is not a number or out of range, or shapes do not broadcast.
    """
    targets = {
        "high_speed": checked("high_speed", high_speed, POSITIVE),
        "restitution": checked("restitution", restitution, OPEN_UNIT_INTERVAL),
        "capture_speed": checked("capture_speed", capture_speed, POSITIVE),
    }
    undamped = contact.replace(hertz_damping=0.0, adhesion_damping=0.0)
    shape = common_shape({"contact": undamped.extent, **targets})
    every = np.stack(
        [np.broadcast_to(target, shape).ravel() for target in targets.values()], axis=-1
    )
    for speed, _, limit in every[every[:, 2] >= every[:, 0]]:
        raise ValueError(f"capture_speed must be below high_speed {speed:g}, got {limit:g}")
    solutions = []
    for index, (speed, e, limit) in zip(np.ndindex(shape), every.tolist(), strict=True):
        try:
            solutions.append(_two_stages(undamped.at(index, shape), speed, e, limit))
        except NoSolutionError as error:
            where = f"; at index {index}" if shape else ""
            raise NoSolutionError(f"{error}{where}") from None
    if not shape:
        return solutions[0]
    dampings = {
        name: np.reshape([getattr(solution.contact, name) for solution in solutions], shape)
        for name in ("hertz_damping", "adhesion_damping")
    }
    return TwoStage(contact.replace(**dampings), max(solution.turns for solution in solutions))


def _two_stages(contact: Contact, speed: float, restitution: float, limit: float) -> TwoStage:
    return _in_turn(
        contact,
        speed,
        lambda current: hertz_damping_for(current, speed, restitution),
        lambda current: adhesion_damping_for(current, limit),
    )


def _in_turn(contact: Contact, speed: float, *stages: Callable[[Contact], Contact]) -> TwoStage:
    """Run stages in turn, each for a target of its own, until c_H settles."""
    for turn in range(1, MOST_TURNS + 1):
        before = float(contact.hertz_damping)
        for stage in stages:
            contact = stage(contact)
        if abs(float(contact.hertz_damping) - before) <= TOLERANCE / speed:
            return TwoStage(contact, turn)
    raise NoSolutionError(f"the two stages do not settle within {MOST_TURNS} turns")


def hertz_damping_for(contact: Contact, speed: float, restitution: float) -> Contact:
    """Choose c_H to meet a restitution at a normal speed.

    Parameters
    ----------
    contact
        Contact whose c_H is looked for; its other fields stay.
    speed
        Normal speed, m/s.
    restitution
        Coefficient of restitution to be met there.

    Raises
    ------
    NoSolutionError
        If restitution is below the target even without material damping.
    """

    def excess(damping: float) -> float:
        changed = contact.replace(hertz_damping=damping)
        return float(normal_impact(changed, speed).coefficient_of_restitution) - restitution

    if excess(0.0) < 0.0:
        raise NoSolutionError(
            f"the adhesion damping alone lowers e at {speed:g} m/s to "
            f"{excess(0.0) + restitution:.4g}, below the target {restitution:g}: raise the work of "
            "adhesion or the rate exponent"
        )
    root = _falling_root(excess, LARGEST_DAMPING / speed, float(contact.hertz_damping))
    return contact.replace(hertz_damping=root)


def damping_factor_for(contact: Contact, speed: float, restitution: float) -> Contact:
    """Scale c_H and c_A by one factor to meet a restitution at a normal speed; of any shape.

    Parameters
    ----------
    contact
        Damped contact, of any shape.
    speed
        Normal speed, m/s.
    restitution
        Coefficient of restitution to be met there.

    Raises
    ------
    NoSolutionError
        If no factor up to 1000 does.
    """

    def scaled(factor: Real) -> Contact:
        return contact.replace(
            hertz_damping=factor * contact.hertz_damping,
            adhesion_damping=factor * contact.adhesion_damping,
        )

    def slowed(factor: Real) -> BoolArray:
        e = normal_impact(scaled(factor), speed).coefficient_of_restitution
        return np.asarray(e <= restitution)

    enough = np.ones(contact.shape)
    while not np.all(slow := slowed(enough)):
        enough = np.where(slow, enough, 4.0 * enough)
        if np.any(enough > LARGEST_DAMPING):
            raise NoSolutionError(f"no factor up to {LARGEST_DAMPING:g} slows to {restitution:g}")
    return scaled(threshold(slowed, np.zeros(contact.shape), enough)[()])


def adhesion_damping_for(contact: Contact, capture_speed: float) -> Contact:
    """Choose c_A to meet a capture velocity.

    An impact at the capture velocity depends on its damping at that speed only, whatever its rate
    exponent: that damping is sought, and referred back to the reference velocity. Raises
    NoSolutionError if the material damping alone captures faster spheres already.
    """
    scale = float(contact.velocity_scale)
    hertz, rateless = np.array([contact.hertz_damping * scale]), (np.zeros(1), np.ones(1))

    def limit(damping: float) -> float:
        groups = hertz, np.array([damping * scale]), *rateless
        scaled = scaled_capture_velocity(*groups, damped_attachment=contact.damped_attachment)
        return float(scaled[0]) * scale

    def shortfall(damping: float) -> float:
        return _capture_shortfall(limit(damping), capture_speed)

    if shortfall(0.0) < 0.0:
        raise NoSolutionError(
            f"without adhesion damping the capture velocity is already {limit(0.0):.4g} m/s, "
            f"above the target {capture_speed:g}: lower the work of adhesion"
        )
    growth = contact.replace(adhesion_damping=1.0).adhesion_damping_at(capture_speed)
    guess = float(contact.adhesion_damping * growth)
    damping = _falling_root(shortfall, LARGEST_DAMPING / capture_speed, guess)
    return contact.replace(adhesion_damping=damping / growth)


def work_of_adhesion_for(contact: Contact, capture_speed: float) -> Contact:
    """Choose w_A to meet a capture velocity at given damping coefficients.

    Raises NoSolutionError if no work of adhesion up to 1000 J/m2 does.
    """

    def shortfall(work: float) -> float:
        limit = float(capture_velocity(contact.replace(work_of_adhesion=work)))
        return _capture_shortfall(limit, capture_speed)

    if shortfall(1e3) > 0.0:
        raise NoSolutionError(
            f"no work of adhesion up to 1000 J/m2 gives a capture velocity of {capture_speed:g} m/s"
        )
    return contact.replace(work_of_adhesion=_falling_root(shortfall, 1e3))


def law_for(
    contact: Contact, law: FittedLaw, speed: float, restitution: float, limit: float
) -> Contact:
    """Choose w_A and the loss of a law of contact to meet a restitution and a capture velocity.

    Parameters
    ----------
    contact
        The bodies.
    law
        Of `JKR` the viscous time is chosen, of `ThorntonNing` the yield pressure.
    speed
        Normal speed, m/s.
    restitution
        Coefficient of restitution to be met there.
    limit
        Capture velocity, m/s.

    Raises
    ------
    NoSolutionError
        If restitution is below the target even without that loss, or no loss lowers it so far.
    """

    def with_loss(loss: float) -> Contact:
        chosen = (
            JKR(viscous_time=loss) if law == JKR.name else ThorntonNing(yield_pressure=1.0 / loss)
        )
        return work_of_adhesion_for(contact.by_law(chosen, 1.0), limit)

    def excess(logarithm: float) -> float:
        e = normal_impact(with_loss(np.exp(logarithm)), speed).coefficient_of_restitution
        return float(e) - restitution

    least, greatest = np.log(LOSSES[law])
    if excess(least) < 0.0 or excess(greatest) > 0.0:
        raise NoSolutionError(
            f"{law}: e at {speed:g} m/s is {excess(least) + restitution:.4g} with hardly any"
            f" loss and {excess(greatest) + restitution:.4g} with a large one, the target"
            f" {restitution:g}"
        )
    return with_loss(np.exp(root(excess, least, greatest, relative=ROOT_TOLERANCE)))


def dissipation_ratio_for(contact: Contact, speed: float, ratio: float) -> Contact:
    """Choose c_A to meet the ratio of the peaks of adhesion dissipation and adhesion (Fig. 20).

    Parameters
    ----------
    contact
        Contact whose c_A is looked for.
    speed
        Normal speed, m/s.
    ratio
        Peak of the force of adhesion damping over the peak of the force of adhesion.

    Raises
    ------
    NoSolutionError
        If no damping in the range looked through does.
    """

    def shortfall(damping: float) -> float:
        return ratio - peak_ratios(contact.replace(adhesion_damping=damping), speed)[1]

    # The ratio is below c_A v, so c_A exceeds ratio/v; it is looked for up to ten times that.
    least = ratio / speed
    if shortfall(10.0 * least) > 0.0:
        raise NoSolutionError(
            f"no adhesion damping up to {10.0 * least:g} s/m gives a dissipation ratio of {ratio:g}"
        )
    guess = max(float(contact.adhesion_damping), least)
    return contact.replace(adhesion_damping=_falling_root(shortfall, 10.0 * least, guess))


def hertz_damping_for_adhesion_ratio(
    contact: Contact, speed: float, adhesion_ratio: float, dissipation_ratio: float
) -> Contact:
    """Choose c_H and c_A to meet the ratios of adhesion to Hertz and of dissipation to adhesion.

    Parameters
    ----------
    contact
        Contact whose c_H and c_A are looked for.
    speed
        Normal speed, m/s.
    adhesion_ratio
        Peak of the force of adhesion over that of the Hertz force (Fig. 20).
    dissipation_ratio
        Peak of the force of adhesion damping over that of adhesion (Fig. 20).

    Raises
    ------
    NoSolutionError
        If adhesion is stronger against Hertz even without material damping.
    """

    def damped(current: Contact) -> Contact:
        def shortfall(damping: float) -> float:
            return adhesion_ratio - peak_ratios(current.replace(hertz_damping=damping), speed)[0]

        if shortfall(0.0) < 0.0:
            raise NoSolutionError(
                f"the peak of adhesion over that of Hertz is {adhesion_ratio - shortfall(0.0):.4g}"
                f" even without material damping, above the target {adhesion_ratio:.4g}; a larger"
                " sphere, a faster impact or a smaller ring force lowers it"
            )
        guess = float(current.hertz_damping)
        root = _falling_root(shortfall, LARGEST_DAMPING / speed, guess)
        return current.replace(hertz_damping=root)

    return _in_turn(
        contact.replace(hertz_damping=0.0),
        speed,
        damped,
        lambda current: dissipation_ratio_for(current, speed, dissipation_ratio),
    ).contact


def peak_ratios(contact: Contact, speed: float, points: int = 2000) -> tuple[float, float]:
    """Ratios of peaks in a normal impact: adhesion to Hertz force, adhesion damping to adhesion.

    Parameters
    ----------
    contact
        Single contact.
    speed
        Normal speed, m/s.
    points
        Instants at which the forces are evaluated.
    """
    path = trajectory(contact, speed, points=points)
    adhesion = float((-path.adhesion_force).max())
    dissipation = float(abs(path.adhesion_damping_force).max())
    return adhesion / float(path.hertz_force.max()), dissipation / adhesion


def _capture_shortfall(limit: float, capture_speed: float) -> float:
    """How far a capture velocity is below a wanted one: 1 for none, -1 for an infinite one."""
    return (capture_speed - limit) / (capture_speed + limit) if limit < float("inf") else -1.0


def _falling_root(function: Callable[[float], float], largest: float, guess: float = 0.0) -> float:
    """Zero of a falling function with a value >= 0 at 0, sought from a guess on.

    In steps that grow, from the guess or from zero, to where the sign changes.
    """
    value = cache(function)
    near = far = guess
    step = 1e-3 * guess if guess > 0.0 else 1e-6 * largest
    upwards = value(guess) > 0.0
    while (value(far) > 0.0) == upwards:
        if far == 0.0 and not upwards:
            return 0.0
        near, far = far, far + step if upwards else max(far - step, 0.0)
        step *= 4.0
        if far > largest:
            raise NoSolutionError(f"no solution up to {largest:g}")
    return root(value, near, far, relative=ROOT_TOLERANCE)
