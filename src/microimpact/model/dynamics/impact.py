"""Oblique impact with friction and spin, Eqs. (26)-(29), planar and in three dimensions.

Slip of the contact point, ``v_t - r omega``, keeps its line and falls by 7/2 of the tangential
impulse per mass. In a rigid contact it stops for good. So the outcome follows from the impulse of
the normal force in Coulomb's law: the sphere slides throughout, or rolls from the instant at which
the slip would be used up. A compliant contact gives slip back, see `dynamics.tangential`. Eq. (29)
is used with the moment ``-R F_t``: with the printed sign friction would speed the slip up.

Two spheres of radii R and R' move, relative to each other, as one sphere of the reduced mass m that
spins with ``omega + omega' R'/R``: friction turns the sphere of mass M by the share m/M of this
spin's change, and the second by the rest. Both turn in the same sense.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from microimpact.core.arrays import (
    BoolArray,
    FloatArray,
    Numbers,
    Range,
    Real,
    checked,
    choice,
    common_shape,
)
from microimpact.core.computable import NotComputable
from microimpact.core.plausible import PLAUSIBLE, warn_caller
from microimpact.core.readable import Readable
from microimpact.model import passes
from microimpact.model.choices import FRICTION_BASES, TANGENTIAL_LAWS
from microimpact.model.contact import Contact, require_contact
from microimpact.model.contact_laws import RING_FORCE, MaugisBarquins
from microimpact.model.dynamics.normal import NormalImpact, normal_impact
from microimpact.model.dynamics.tangential import compliant_impulse
from microimpact.model.rigid_body.algebra import (
    APPROACHING,
    INERTIA,
    SLIP_PER_IMPULSE,
    SPEED_OF_LIGHT,
    SPIN,
    VELOCITY,
)

# Friction basis F + 2 F_pull-off; not for laws that may pull harder than F_pull-off.
PULL_OFF = "pull-off"
SPEED = Range(lower=0.0, upper=SPEED_OF_LIGHT)
ANGLE = Range(lower=0.0, upper=90.0, upper_closed=True)

# Impacts integrated at a time, which bounds the memory for all but the outcomes.
BLOCK = 2**16

# Fields of an `Impact` by the rows of a compiled pass.
PLANAR = {
    "coefficient_of_restitution": passes.OUT_RESTITUTION,
    "impulse_ratio": passes.OUT_IMPULSE_RATIO,
    "normal_velocity": passes.OUT_NORMAL,
    "tangential_velocity": passes.OUT_TANGENTIAL,
    "spin": passes.OUT_SPIN,
    "energy_loss": passes.OUT_LOSS,
    "translational_energy_loss": passes.OUT_LINEAR_LOSS,
}

# Normal impacts of contacts (first) at normal speeds in m/s (second).
NormalLaw = Callable[[Contact, Real], NormalImpact]


class Outcome(Readable):
    """Base of impacts: energy of which a share was lost that is a number."""

    __slots__ = ()
    energy_loss: FloatArray

    def __post_init__(self) -> None:
        """Raise ValueError if numbers left double precision on the way."""
        if not np.all(np.isfinite(self.energy_loss)):
            raise ValueError(
                "the impact is beyond double precision: sizes, speeds, spins, adhesion"
            )


@dataclass(frozen=True, slots=True, repr=False)
class Impact(Outcome):
    """Outcome of planar impacts; every field has the broadcast shape of the arguments.

    Attributes
    ----------
    coefficient_of_restitution
        e of Eq. (1); 0 where captured.
    impulse_ratio
        -mu of Eq. (2): tangential over normal impulse, positive where friction acts against +t.
    captured
        True where the sphere stays on the surface, with V_n = 0; with friction it ends rolling.
    contact_time
        s; infinite where captured.
    normal_velocity, tangential_velocity, spin
        After impact, m/s and rad/s; of two spheres the velocity relative to the second.
    rolling
        True where slip has ended; with a compliant contact, where it stuck for some time.
    energy_loss, translational_energy_loss
        Fractions of the initial translational kinetic energy, with and without rotation.
    maximum_compression
        m.
    interpolation_error
        Bound of the relative difference of normal impacts from integration: 0 unless they come
        from a table, see `model.law.table.Law`.
    partner_spin
        Of a second sphere after impact, rad/s.
    """

    coefficient_of_restitution: FloatArray
    impulse_ratio: FloatArray
    captured: BoolArray
    contact_time: FloatArray
    normal_velocity: FloatArray
    tangential_velocity: FloatArray
    spin: FloatArray
    rolling: BoolArray
    energy_loss: FloatArray
    translational_energy_loss: FloatArray
    maximum_compression: FloatArray
    interpolation_error: FloatArray | float = 0.0
    partner_spin: FloatArray | float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return the fields by name, as for ``pandas.DataFrame``."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


@dataclass(frozen=True, slots=True, repr=False)
class SpatialImpact(Outcome):
    """Outcome of impacts in three dimensions, surface normal along z.

    As `Impact`, with ``velocity`` and the spins vectors (..., 3), m/s and rad/s, and
    ``impulse_ratio`` the tangential over the normal impulse, positive against the slip.
    """

    coefficient_of_restitution: FloatArray
    impulse_ratio: FloatArray
    captured: BoolArray
    contact_time: FloatArray
    velocity: FloatArray
    spin: FloatArray
    rolling: BoolArray
    energy_loss: FloatArray
    translational_energy_loss: FloatArray
    maximum_compression: FloatArray
    partner_spin: FloatArray | float = 0.0


AnyImpact = TypeVar("AnyImpact", Impact, SpatialImpact)


class Spins(NamedTuple):
    """Spins of a sphere and its partner, rad/s: numbers, or vectors along the last axis."""

    sphere: Real
    partner: Real
    size: Real | None  # Radius of the partner over the sphere's; None without one
    share: Real  # Reduced mass over the sphere's

    @classmethod
    def of(cls, contact: Contact, spin: Real, partner_spin: Real, vectors: bool = False) -> Spins:
        """Return the spins before an impact.

        Parameters
        ----------
        contact
            Contact of the impact.
        spin
            Spin of the sphere, rad/s; (..., 3) if `vectors`.
        partner_spin
            Spin of the second sphere, in the same form; 0 on a surface.
        vectors
            Whether spins are vectors.

        Raises
        ------
        ValueError
            If a second sphere spins that is not there.
        """
        if not contact.is_pair:
            spinning = partner_spin if isinstance(partner_spin, float) else np.any(partner_spin)
            if spinning:
                raise ValueError(
                    "partner_spin is of a second sphere: contact has no partner_diameter"
                )
            return cls(spin, partner_spin, None, 1.0)
        size = np.asarray(contact.partner_diameter) / contact.diameter
        share = np.asarray(contact.mass_share)
        if vectors:
            size, share = size[..., None], share[..., None]
        return cls(spin, partner_spin, size, share)

    @property
    def joint(self) -> Real:
        """Spin of one sphere with the slip and the energy of both."""
        return self.sphere if self.size is None else self.sphere + self.size * self.partner

    def separate(self, impact: AnyImpact) -> AnyImpact:
        """Return an impact computed with the joint spin, with the spins of both spheres."""
        if self.size is None:
            return impact
        turn = impact.spin - self.joint
        partner = self.partner + (1.0 - self.share) / self.size * turn
        return replace(impact, spin=self.sphere + self.share * turn, partner_spin=partner)


def friction_impulse(
    contact: Contact,
    normal: NormalImpact,
    slip: Real,
    basis: str,
    speed: Real,
    tangential: str = "rigid",
) -> tuple[Any, Any]:
    """Friction impulse per mass against the slip, m/s, and whether the sphere ends rolling.

    Parameters
    ----------
    slip
        Magnitude of the initial slip, m/s.
    basis
        Normal force in Coulomb's law: ``compressive`` max(F_n, 0), ``hertz`` the Hertz term alone,
        ``net`` the normal force as printed in Eq. (27); there rolling is decided at first passage.
        ``pull-off`` the normal force and twice the pull-off force (Thornton and Yin 1991), which
        is for contacts with another law than the ring force, as ``hertz`` is for that one.
    speed
        Normal speed of approach, m/s.
    tangential
        As in `planar`.
    """
    sliding, available = supporting_impulses(contact, normal, basis, speed)
    # A captured sphere is pressed on for ever: it rolls in the end, if there is friction at all.
    stays = normal.captured & (contact.friction > 0.0)
    if tangential == "rigid":
        rolling = stays | (SLIP_PER_IMPULSE * contact.friction * available >= slip)
        if isinstance(rolling, np.bool_):
            return slip / SLIP_PER_IMPULSE if rolling else contact.friction * sliding, rolling
        return np.where(rolling, slip / SLIP_PER_IMPULSE, contact.friction * sliding), rolling
    impulse, stuck = compliant_impulse(contact, normal, slip, speed, tangential, basis)
    impulse = np.where(stays, slip / SLIP_PER_IMPULSE, impulse)
    return np.where(stuck | stays, impulse, contact.friction * sliding), stuck | stays


def supporting_impulses(
    contact: Contact, normal: NormalImpact, basis: str, speed: Real
) -> tuple[Any, Any]:
    """Impulses per mass, m/s, of the force that supports friction: of sliding, and until rolling.

    Arguments as of `friction_impulse`.
    """
    mass: Any = contact.scales[0]
    if basis == "net":
        sliding = (1.0 + normal.coefficient_of_restitution) * speed
        return sliding, normal.peak_net_impulse / mass
    if basis == PULL_OFF:
        time = np.where(normal.captured, 0.0, normal.contact_time)
        adhesion = 2.0 * contact.pull_off_force * time / mass
        impulse = (1.0 + normal.coefficient_of_restitution) * speed + adhesion
    else:
        total = normal.hertz_impulse if basis == "hertz" else normal.compressive_impulse
        assert total is not None
        impulse = total / mass
    return impulse, impulse


def planar(
    contact: Contact,
    v_n: Numbers,
    v_t: Numbers,
    omega: Numbers = 0.0,
    friction_basis: str = "compressive",
    law: NormalLaw | None = None,
    tangential: str = "rigid",
    partner_spin: Numbers = 0.0,
) -> Impact:
    """Impact in a plane.

    Parameters
    ----------
    contact
        The contact; its fields broadcast with the velocities.
    v_n, v_t
        Normal (negative: approaching) and tangential velocity before impact, m/s.
    omega, partner_spin
        Spin before impact, rad/s, positive in the sense of rolling along t; of a second sphere in
        the same sense.
    friction_basis
        ``"compressive"``, ``"hertz"``, ``"net"`` or ``"pull-off"``; see `friction_impulse`.
    law
        Where normal impacts come from; every one is integrated if none is given.
    tangential
        ``"rigid"``: slip stops for good. ``"mindlin"``: the contact yields along the surface too
        and slips in part; ``"spring"``: it is the spring of discrete element codes; see
        `model.dynamics.tangential`. Both take the shear modulus from the materials, and friction
        that rests on ``"compressive"`` or ``"hertz"``; a captured sphere ends rolling all the same.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a number or out of range, or the shapes do not broadcast.
    RuntimeError
        If an integration failed.
    """
    require_contact(contact, any_law=True, pair=True)
    basis = chosen_basis(contact, friction_basis, tangential)
    v_n = checked("v_n", v_n, APPROACHING)
    v_t = checked("v_t", v_t, VELOCITY)
    omega = checked("omega", omega, SPIN)
    partner_spin = checked("partner_spin", partner_spin, SPIN)
    arguments = {"v_n": v_n, "v_t": v_t, "omega": omega, "partner_spin": partner_spin}
    shape = common_shape({"contact": contact.extent, **arguments})
    spins = Spins.of(contact, omega, partner_spin)
    return _planar(contact, v_n, v_t, spins, shape, basis, law, tangential)


def _planar(
    contact: Contact,
    v_n: Real,
    v_t: Real,
    spins: Spins,
    shape: tuple[int, ...],
    basis: str,
    law: NormalLaw | None,
    tangential: str,
) -> Impact:
    """Return planar impacts of a shape, of arguments that are checked; see `planar`."""
    if law is None and math.prod(shape) > BLOCK:
        return _in_blocks(contact, v_n, v_t, spins, shape, basis, tangential)
    speed, radius, omega = -v_n, contact.radius, spins.joint
    normal = law(contact, speed) if law else normal_impact(contact, speed, ledger=basis == "hertz")
    slip: Any = v_t - radius * omega
    size, rolling = friction_impulse(contact, normal, abs(slip), basis, speed, tangential)
    out = passes.outcomes(shape)[0]
    columns = speed, v_t, omega, radius, normal.coefficient_of_restitution, np.sign(slip) * size
    passes.planar(*passes.flats(columns, shape), out)
    impact = Impact(
        **planar_fields(out, shape),
        captured=_shaped(normal.captured, shape),
        rolling=_shaped(rolling, shape),
        contact_time=_shaped(normal.contact_time, shape),
        maximum_compression=_shaped(normal.maximum_compression, shape),
    )
    return spins.separate(impact)


def _in_blocks(
    contact: Contact,
    v_n: Real,
    v_t: Real,
    spins: Spins,
    shape: tuple[int, ...],
    basis: str,
    tangential: str,
) -> Impact:
    """Return impacts as `_planar` does, with memory for their outcomes and one block."""
    outcome: dict[str, Any] = {}
    size = math.prod(shape)
    for start in range(0, size, BLOCK):
        part = slice(start, min(start + BLOCK, size))
        index = np.unravel_index(np.arange(part.start, part.stop), shape)
        along, across, turning = (_at(values, shape, index) for values in (v_n, v_t, spins))
        contacts = contact.at(index, shape) if contact.shape else contact
        impact = _planar(contacts, along, across, turning, index[0].shape, basis, None, tangential)
        for field in fields(Impact):
            values = getattr(impact, field.name)
            if np.ndim(values):
                whole = outcome.setdefault(field.name, np.empty(size, values.dtype))
                whole[part] = values
            else:  # one number for all
                outcome[field.name] = values
    return Impact(**{k: v.reshape(shape) if np.ndim(v) else v for k, v in outcome.items()})


def _at(values: Any, shape: tuple[int, ...], index: Any) -> Any:
    """Return part of values, or of the spins of several impacts, that broadcast to a shape."""
    if isinstance(values, Spins):
        return Spins(*(_at(each, shape, index) for each in values))
    return np.broadcast_to(values, shape)[index] if np.ndim(values) else values


def planar_fields(out: FloatArray, shape: tuple[int, ...]) -> dict[str, Any]:
    """Return the fields of an `Impact` that a compiled pass has written."""
    if not shape:
        numbers = out[:, 0].tolist()
        return {name: numbers[row] for name, row in PLANAR.items()}
    return {name: out[row].reshape(shape)[()] for name, row in PLANAR.items()}


def simulate(
    contact: Contact,
    speed: Numbers,
    angle: Numbers = 90.0,
    spin: Numbers = 0.0,
    friction_basis: str = "compressive",
    tangential: str = "rigid",
    partner_spin: Numbers = 0.0,
) -> Impact:
    """Simulate impacts given by speed and angle of incidence, each integrated.

    Parameters
    ----------
    contact
        The contact; its fields broadcast with speed, angle and spin.
    speed
        Total speed before impact, m/s, positive; of two spheres relative to the second.
    angle
        Angle of incidence from the surface, degrees, in (0, 90].
    spin
        Spin before impact, rad/s, positive in the sense of rolling along the motion.
    friction_basis
        Normal force in Coulomb's law: ``"compressive"``, ``"hertz"``, ``"net"`` or ``"pull-off"``;
        see `friction_impulse`.
    tangential
        Compliance along the surface: ``"rigid"`` (none), ``"mindlin"`` or ``"spring"``; see
        `planar`.
    partner_spin
        Of a second sphere before impact, rad/s, positive in the same sense as ``spin``.

    Returns
    -------
    Impact
        Arrays of the common shape; a Series is taken as its values, so give its index again:
        ``pd.DataFrame(impact.to_dict(), index=series.index)``.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a number or out of range, or the shapes do not broadcast.
    RuntimeError
        If an integration failed.
    """
    arguments, spins, shape = incident(
        contact, speed, angle, spin, friction_basis, tangential, partner_spin
    )
    v_n, v_t = velocity_components(arguments["speed"], arguments["angle"])
    v_n = checked("v_n", v_n, APPROACHING)  # may have vanished
    return _planar(contact, v_n, v_t, spins, shape, friction_basis, None, tangential)


def incident(
    contact: Contact,
    speed: Numbers,
    angle: Numbers,
    spin: Numbers,
    friction_basis: str,
    tangential: str = "rigid",
    partner_spin: Numbers = 0.0,
) -> tuple[dict[str, Real], Spins, tuple[int, ...]]:
    """Return speed and angle checked, spins, and their shape with the contact; as `simulate`.

    Parameters
    ----------
    contact, speed, angle, spin, friction_basis, tangential, partner_spin
        As of `simulate`; their shapes broadcast.

    Returns
    -------
    inputs, spins, shape
        Speed (m/s) and angle (degrees) by name, the spins, and the broadcast shape.
    """
    require_contact(contact, any_law=True, pair=True)
    chosen_basis(contact, friction_basis, tangential)
    arguments = {
        "contact": contact.extent,
        "speed": checked("speed", speed, SPEED),
        "angle": checked("angle", angle, ANGLE),
        "spin": checked("spin", spin, SPIN),
        "partner_spin": checked("partner_spin", partner_spin, SPIN),
    }
    shape = common_shape(arguments)
    incidence = arguments["angle"]
    steepest = incidence if isinstance(incidence, float) else incidence.max(initial=0.0)
    if 0.0 < steepest < PLAUSIBLE["angle"][0]:
        warn_caller({"angle": steepest}, depth=3)
    spins = Spins.of(contact, arguments["spin"], arguments["partner_spin"])
    return {"speed": arguments["speed"], "angle": incidence}, spins, shape


def chosen_basis(contact: Contact, friction_basis: object, tangential: object = "rigid") -> str:
    """Return the checked basis of friction, for the contact's law and a checked tangential law."""
    basis = choice("friction_basis", friction_basis, (*FRICTION_BASES, PULL_OFF))
    compliant = choice("tangential", tangential, TANGENTIAL_LAWS) != "rigid"
    pulls_harder = contact.law is None or isinstance(contact.law, MaugisBarquins)
    if compliant and contact.law is not None:
        hint = f", with friction_basis {PULL_OFF!r} if adhesion is to support friction"
        raise NotComputable(
            f"tangential {tangential!r} is for the law {RING_FORCE!r}, got {contact.law.name!r}: "
            f"take 'rigid'{'' if pulls_harder else hint}"
        )
    if compliant and basis == "net":
        allowed = " or ".join(map(repr, FRICTION_BASES[:2]))
        raise NotComputable(
            f"friction_basis must be {allowed} with tangential {tangential!r}, got 'net': a limit "
            "that adhesion makes negative is none"
        )
    if (basis == PULL_OFF and pulls_harder) or (basis == "hertz" and contact.law is not None):
        law = contact.law.name if contact.law else RING_FORCE
        raise NotComputable(f"friction_basis {basis!r} does not go with the law {law!r}")
    return basis


def _shaped(values: Any, shape: tuple[int, ...]) -> Any:
    """Values broadcast to a shape; a single number or flag stays a number or flag."""
    if not shape:
        return values[()] if isinstance(values, np.ndarray) else values
    return values if np.shape(values) == shape else np.broadcast_to(values, shape)


def velocity_components(speed: Real, angle: Real) -> tuple[Real, Real]:
    """Normal (negative) and tangential velocity at an angle of incidence in degrees."""
    # cos(90 degrees) must be exactly zero: the complement goes through the sine.
    along = np.sin(np.radians(90.0 - angle))
    return -speed * np.sin(np.radians(angle)), speed * along


def spatial(
    contact: Contact,
    velocity: Numbers,
    spin: Numbers = (0.0, 0.0, 0.0),
    friction_basis: str = "compressive",
    tangential: str = "rigid",
    partner_spin: Numbers = (0.0, 0.0, 0.0),
) -> SpatialImpact:
    """Impact in three dimensions; the surface is the plane z = 0, the normal +z.

    A second sphere in place of the surface lies below, and velocities are relative to it.

    Spin about the normal is inert: a point contact gives it no moment.

    Parameters
    ----------
    contact
        The contact; its fields broadcast with the leading shape of the vectors.
    velocity
        Velocity before impact (..., 3), m/s, with a negative z component.
    spin, partner_spin
        Angular velocities before impact (..., 3), rad/s, right-handed.
    friction_basis, tangential
        As in `planar`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a vector of numbers, does not approach, or shapes do not broadcast.
    RuntimeError
        If an integration failed.
    """
    require_contact(contact, any_law=True, pair=True)
    basis = chosen_basis(contact, friction_basis, tangential)
    vectors = {}
    arguments = {"velocity": velocity, "spin": spin, "partner_spin": partner_spin}
    for name, value in arguments.items():
        vectors[name] = np.asarray(checked(name, value, VELOCITY if name == "velocity" else SPIN))
        if vectors[name].shape[-1:] != (3,):
            raise ValueError(f"{name} must have shape (..., 3), got {vectors[name].shape}")
    leading = {name: vector[..., 0] for name, vector in vectors.items()}
    shape = common_shape({"contact": contact.extent, **leading})
    v = np.broadcast_to(vectors["velocity"], (*shape, 3))
    spins = Spins.of(contact, vectors["spin"], vectors["partner_spin"], vectors=True)
    w = np.broadcast_to(spins.joint, (*shape, 3))
    v_n = checked("velocity[..., 2]", v[..., 2], APPROACHING)
    speed = np.abs(v_n)
    radius = np.broadcast_to(contact.radius, shape)
    normal = normal_impact(contact, speed, ledger=basis == "hertz")
    # Velocity of the contact point along the surface: v + w x (-r z).
    slip = np.stack([v[..., 0] - radius * w[..., 1], v[..., 1] + radius * w[..., 0]], axis=-1)
    length = np.hypot(slip[..., 0], slip[..., 1])
    size, rolling = friction_impulse(contact, normal, length, basis, speed, tangential)
    direction = slip / np.where(length > 0.0, length, 1.0)[..., None]
    change = direction * np.asarray(size)[..., None]
    e = normal.coefficient_of_restitution
    after_v = np.stack([v[..., 0] - change[..., 0], v[..., 1] - change[..., 1], e * speed], axis=-1)
    turn = np.stack([-change[..., 1], change[..., 0], np.zeros(shape)], axis=-1)
    after_w = w + turn / (INERTIA * radius)[..., None]
    energy = np.sum(np.square(v), axis=-1)
    linear = energy - np.sum(np.square(after_v), axis=-1)
    rotational = -radius * np.sum(turn * (w + after_w), axis=-1)

    def shaped(values: Real) -> Any:
        return _shaped(values, shape)

    impact = SpatialImpact(
        coefficient_of_restitution=shaped(e),
        impulse_ratio=shaped(size / ((1.0 + e) * speed)),
        captured=np.broadcast_to(normal.captured, shape)[()],
        contact_time=shaped(normal.contact_time),
        velocity=after_v,
        spin=after_w,
        rolling=np.broadcast_to(rolling, shape)[()],
        energy_loss=shaped((linear + rotational) / energy),
        translational_energy_loss=shaped(linear / energy),
        maximum_compression=shaped(normal.maximum_compression),
    )
    return spins.separate(impact)
