"""Contacts of a sphere with a surface or a second sphere (Eqs. 20-24, 30, 31).

Stiffness, ring force, scales and damping.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, Real, checked, choice, common_shape
from microimpact.core.computable import NotComputable
from microimpact.core.materials import Material
from microimpact.core.plausible import warn_caller
from microimpact.core.readable import Readable
from microimpact.model.choices import STIFFNESS_MODELS
from microimpact.model.contact_laws import RING_FORCE, ContactLaw, Hysteresis, contact_law

ADHESIONS = ("work_of_adhesion", "ring_force")
LOSSES = ("hertz_damping", "adhesion_damping", "friction", "adhesion_rate_exponent")
# Of all numbers but 0, in SI units: so their products stay within double precision.
SMALLEST, LARGEST = 1e-30, 1e30
# These may also be as small as they like.
MAY_VANISH = {*ADHESIONS, *LOSSES, "particle.poissons_ratio", "surface.poissons_ratio"}
# Eq. (31) with the static equilibrium radius a_c^3 = 6 pi w_A r^2 / K is a constant share of K.
REDUCED_STIFFNESS_SHARE = 1.0 - 2.5 * (5.0 / 9.0) ** 1.5 / 6.0


def hertz_stiffness(particle: Material, surface: Material) -> Real:
    """Hertz stiffness K in Pa, Eqs. (20), (21): ``K = 4 / (3 pi (k_1 + k_2))``.

    The square printed in Eq. (20) is a misprint: it would not be a pressure.
    """
    k_1, k_2 = (
        (1.0 - np.square(m.poissons_ratio)) / (np.pi * m.youngs_modulus)
        for m in (particle, surface)
    )
    return 4.0 / (3.0 * np.pi * (k_1 + k_2))


def ring_force_from_work(work_of_adhesion: Real, radius: Real, stiffness: Real) -> Real:
    """Ring force f_0 in N/m, Eq. (30): equal contact radius to JKR's at zero load.

    Parameters
    ----------
    work_of_adhesion
        Dupre energy w_A, J/m2.
    radius
        Effective radius r of Eq. (22), m.
    stiffness
        Hertz stiffness K of Eq. (20), Pa.
    """
    return (9.0 * stiffness * radius * np.square(work_of_adhesion) / (2.0 * np.pi)) ** (1.0 / 3.0)


def work_from_ring_force(ring_force: Real, radius: Real, stiffness: Real) -> Real:
    """Work of adhesion w_A in J/m2 that Eq. (30) turns into ``ring_force``.

    Parameters
    ----------
    ring_force
        Force f_0 per length of the contact's edge, N/m.
    radius
        Effective radius r of Eq. (22), m.
    stiffness
        Hertz stiffness K of Eq. (20), Pa.
    """
    return np.sqrt(2.0 * np.pi * np.power(ring_force, 3) / (9.0 * stiffness * radius))


def _beyond(value: Any, least: float) -> float | None:
    """First number of a value that is neither 0, infinite nor from ``least`` to `LARGEST`."""
    if isinstance(value, float | bool):
        within = least <= abs(value) <= LARGEST or value in {0.0, math.inf}
        return None if within else value
    size = np.abs(value)
    beyond = ((size < least) & (size > 0.0)) | ((size > LARGEST) & (size < math.inf))
    return float(np.extract(beyond, value)[0]) if np.any(beyond) else None


def resized(contact: Contact, diameter: Real | None = None, **sizes: Real) -> Contact:
    """Return the contact at other sizes: w_A, c_H and c_A stay, f_0 follows Eq. (30).

    Parameters
    ----------
    contact
        Contact at its sizes.
    diameter
        Diameter of the sphere, m; as it is if None.
    **sizes
        Other sizes, as ``surface_radius``, m.
    """
    if diameter is not None:
        sizes["diameter"] = diameter
    return contact.replace(**sizes, work_of_adhesion=contact.work_of_adhesion)


def require_contact(value: object, *, any_law: bool = False, pair: bool = False) -> None:
    """Refuse a value that is no contact, or one of a kind that will not do.

    Parameters
    ----------
    value
        What was given as a contact.
    any_law
        Whether another law than the ring force will do.
    pair
        Whether one of two spheres will do.

    Raises
    ------
    TypeError, ValueError
        If it is no contact, or one of a kind that will not do.
    """
    if not isinstance(value, Contact):
        raise TypeError(f"contact must be a Contact, got {value!r}")
    if value.law is not None and not any_law:
        raise NotComputable(
            f"contact must have the law {RING_FORCE!r} here, got {value.law.name!r}"
        )
    if value.is_pair and not pair:
        raise ValueError("contact must be one with a surface here, got one with a partner_diameter")


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Contact(Readable):
    """A sphere on a surface, or two spheres, with adhesion, damping and friction.

    Every number may be an array; the fields broadcast with each other and with the speeds, angles
    and spins of a simulation. Give either ``work_of_adhesion`` or ``ring_force``: the other is
    resolved by Eq. (30).

    Parameters
    ----------
    particle, surface
        The two materials; of two spheres ``surface`` is that of the second.
    diameter
        Diameter of the sphere, m.
    work_of_adhesion
        Dupre energy w_A, J/m2.
    ring_force
        Adhesion force f_0 per length of the contact's edge, N/m.
    hertz_damping, adhesion_damping
        Damping coefficients c_H and c_A of Eq. (19), s/m.
    friction
        Coulomb coefficient f.
    stiffness_model
        ``"hertz"``: K of Eq. (20). ``"reduced"``: Eq. (31) as printed, in place of K.
    adhesion_rate_exponent
        n in ``c_A (v_N/|v_n|)^n``, constant within an impact.
    reference_velocity
        v_N, m/s; needed where n is not zero.
    surface_radius
        Radius of curvature of the surface, m (Eq. 22); infinite for a plane.
    partner_diameter
        Diameter of a second, free sphere in place of the surface, m; infinite for a surface, which
        is its limit. Speeds are then those of the sphere relative to the second.
    damped_attachment
        Whether adhesion is damped during approach too (the article: no).
    law
        Law of the normal force: ``"ring force"`` (the article's), or a record of another one from
        `microimpact.model.contact_laws`: `JKR`, `ThorntonNing`, `Hysteresis` or
        `MaugisBarquins`. These take ``work_of_adhesion`` and have losses of their own, so none of
        the damping above.

    Attributes
    ----------
    adhesion_input
        Which of ``work_of_adhesion`` and ``ring_force`` was given.
    shape
        Broadcast shape of the fields.
    hertz_stiffness
        K of Eq. (20), Pa.

    Raises
    ------
    TypeError, ValueError
        If a field is not a number, out of range, or the fields do not broadcast.

    Warns
    -----
    UserWarning
        If a number is hardly meant, as a diameter in micrometres.
    """

    particle: Material
    surface: Material
    diameter: Real
    work_of_adhesion: Real | None = None
    ring_force: Real | None = None
    hertz_damping: Real = 0.0
    adhesion_damping: Real = 0.0
    friction: Real = 0.15
    stiffness_model: str = "hertz"
    adhesion_rate_exponent: Real = 0.0
    reference_velocity: Real | None = None
    surface_radius: Real = math.inf
    partner_diameter: Real = math.inf
    damped_attachment: bool = False
    law: ContactLaw | None = None
    # Adhesions of the contact that this one is made of by `replace`, the one given first.
    _passed_on: tuple[tuple[str, Real | None], ...] = field(default=(), repr=False, compare=False)
    adhesion_input: str = field(init=False, default="", repr=False)
    shape: tuple[int, ...] = field(init=False, default=(), repr=False)
    hertz_stiffness: Real = field(init=False, default=math.nan, repr=False, compare=False)
    # Mass, velocity scale, r^(1/2) K and equilibrium compression, which every impact needs.
    scales: tuple[Real, ...] = field(init=False, default=(), repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("particle", "surface"):
            if not isinstance(getattr(self, name), Material):
                raise TypeError(f"{name} must be a Material, got {getattr(self, name)!r}")
        self._choose_adhesion()
        if not isinstance(self.damped_attachment, bool):
            raise TypeError(
                f"damped_attachment must be True or False, got {self.damped_attachment!r}"
            )
        choice("stiffness_model", self.stiffness_model, STIFFNESS_MODELS)
        self._set("law", contact_law(self.law))
        self._check_numbers()
        if self.law is not None:
            self._check_law(self.law)
        self._resolve_adhesion()
        warn_caller(self, depth=3)

    def _choose_adhesion(self) -> None:
        """Keep the adhesion that is given; of both, which `dataclasses.replace` gives, the new one.

        Raises ValueError if that is neither, or both.
        """
        values = {name: getattr(self, name) for name in ADHESIONS}
        inputs = [name for name, value in values.items() if value is not None]
        if len(inputs) > 1 and self._passed_on:
            before = dict(self._passed_on)
            changed = [name for name in inputs if values[name] is not before[name]]
            inputs = changed or [self._passed_on[0][0]]
        if len(inputs) != 1:
            number = "both" if inputs else "neither"
            raise ValueError(f"give either {' or '.join(ADHESIONS)}, got {number}")
        for name in ADHESIONS:
            self._set(name, values[name] if name == inputs[0] else None)
        self._set("adhesion_input", inputs[0])

    def _check_law(self, law: ContactLaw) -> None:
        """Refuse parameters of the ring force, and works of adhesion that would gain energy."""
        foreign = {
            "ring_force": self.adhesion_input == "ring_force",
            "stiffness_model": self.stiffness_model != "hertz",
            "damped_attachment": self.damped_attachment,
        } | {
            name: bool(np.any(np.asarray(getattr(self, name))))
            for name in ("hertz_damping", "adhesion_damping", "adhesion_rate_exponent")
        }
        refused = [name for name, present in foreign.items() if present]
        if refused:
            raise NotComputable(
                f"law {law.name!r} does not know {', '.join(refused)}: leave that to the ring force"
            )
        work = np.asarray(self.work_of_adhesion, dtype=np.float64)
        if isinstance(law, Hysteresis) and np.any(np.asarray(law.unloading_work) < work):
            raise ValueError(
                f"law.unloading_work must not be below work_of_adhesion {work}, "
                f"got {law.unloading_work}"
            )

    def _resolve_adhesion(self) -> None:
        radius, stiffness = self.hertz_radius, hertz_stiffness(self.particle, self.surface)
        self._set("hertz_stiffness", stiffness)
        if self.ring_force is not None:
            self._set("work_of_adhesion", work_from_ring_force(self.ring_force, radius, stiffness))
        elif self.work_of_adhesion is not None:
            self._set("ring_force", ring_force_from_work(self.work_of_adhesion, radius, stiffness))
        order = sorted(ADHESIONS, key=lambda name: name != self.adhesion_input)
        self._set("_passed_on", tuple((name, getattr(self, name)) for name in order))
        hertz = np.sqrt(radius) * self.stiffness
        scales = (self.mass, self.velocity_scale, hertz, self.equilibrium_compression)
        self._set("scales", scales if self.shape else tuple(map(float, scales)))

    def _check_numbers(self) -> None:
        self._check("diameter", POSITIVE)
        for name in (self.adhesion_input, *LOSSES):
            self._check(name, NON_NEGATIVE)
        if self.reference_velocity is not None:
            self._check("reference_velocity", POSITIVE)
        elif np.any(self.adhesion_rate_exponent):
            raise ValueError(
                "reference_velocity is needed where adhesion_rate_exponent is not zero"
            )
        curved = [
            name
            for name in ("surface_radius", "partner_diameter")
            if not (isinstance(value := getattr(self, name), float) and value == math.inf)
        ]
        if len(curved) > 1:
            raise ValueError(f"give either {' or '.join(curved)}, got both")
        for name in curved:
            self._check(name, POSITIVE)
        numbers = self._arrays()
        self._set("shape", common_shape(numbers))
        for name, value in numbers.items():
            least = 0.0 if name in MAY_VANISH else SMALLEST
            if (wrong := _beyond(value, least)) is not None:
                raise ValueError(
                    f"{name} must be from {least:g} to {LARGEST:g} in SI units, got {wrong:g}"
                )

    @property
    def extent(self) -> Real:
        """An array of the shape of the fields without memory, or a number, to broadcast with."""
        return np.broadcast_to(0.0, self.shape) if self.shape else 0.0

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check(self, name: str, allowed: Any) -> None:
        self._set(name, checked(name, getattr(self, name), allowed))

    def _arrays(self) -> dict[str, object]:
        named = {
            f.name: getattr(self, f.name)
            for f in fields(self)
            if f.init
            and f.name not in {"particle", "surface", "stiffness_model", "law", "_passed_on"}
        }
        if self.law is not None:
            named |= {f"law.{name}": value for name, value in self.law.parameters.items()}
        for role in ("particle", "surface"):
            for name in ("youngs_modulus", "poissons_ratio", "density"):
                named[f"{role}.{name}"] = getattr(getattr(self, role), name)
        return {name: value for name, value in named.items() if value is not None}

    def shown(self) -> dict[str, Any]:
        """Return the fields that were given, and the friction in any case."""
        derived = set(ADHESIONS) - {self.adhesion_input}
        values = Readable.shown(self) | {"friction": self.friction}
        return {name: value for name, value in values.items() if name not in derived}

    def replace(self, **changes: Any) -> Contact:
        """Return a contact with some fields changed; the given adhesion input is kept."""
        if set(ADHESIONS) & set(changes):
            changes = dict.fromkeys(ADHESIONS) | changes
        contact = replace(self, **changes)
        warn_caller({name: getattr(contact, name) for name in changes}, depth=2)
        return contact

    def at(self, index: Any, shape: tuple[int, ...] | None = None) -> Contact:
        """Index the array of contacts.

        Parameters
        ----------
        shape
            One to which theirs is broadcast first.
        """
        whole = self.shape if shape is None else shape

        def part(record: Any) -> dict[str, Any]:
            values = {f.name: getattr(record, f.name) for f in fields(record) if f.init}
            arrays = {
                name: value for name, value in values.items() if isinstance(value, np.ndarray)
            }
            return {name: np.broadcast_to(value, whole)[index] for name, value in arrays.items()}

        records = {name: getattr(self, name) for name in ("particle", "surface", "law")}
        changes = part(self) | {
            name: replace(value, **part(value))
            for name, value in records.items()
            if value is not None
        }
        for name in set(ADHESIONS) - {self.adhesion_input}:
            changes.pop(name, None)
        return self.replace(**changes)

    def by_law(self, law: ContactLaw, work_of_adhesion: Real) -> Contact:
        """Return a contact of the same bodies by another law, without damping of its own."""
        none = dict.fromkeys(("hertz_damping", "adhesion_damping", "adhesion_rate_exponent"), 0.0)
        law_fields = {"work_of_adhesion": work_of_adhesion, "reference_velocity": None, "law": law}
        return self.replace(**none, damped_attachment=False, **law_fields)

    @classmethod
    def from_zeta(
        cls, *, zeta_hertz: object, zeta_adhesion: object, reference_velocity: object, **fields: Any
    ) -> Contact:
        """Build a contact from the dissipation parameters of Eqs. (23), (24).

        ``c = zeta (m / (r^3 K v_N^(1/2)))^(2/5)``; the printed exponent 5/2 is a misprint, and the
        constant is 1.

        Parameters
        ----------
        zeta_hertz, zeta_adhesion
            Nondimensional damping of material and adhesion.
        reference_velocity
            The nominal normal velocity v_N, m/s.
        **fields
            The other fields of `Contact`.
        """
        bare = cls(reference_velocity=reference_velocity, **fields)  # type: ignore[arg-type]
        zeta_h = checked("zeta_hertz", zeta_hertz, NON_NEGATIVE)
        zeta_a = checked("zeta_adhesion", zeta_adhesion, NON_NEGATIVE)
        unit = bare.damping_unit
        return bare.replace(hertz_damping=zeta_h * unit, adhesion_damping=zeta_a * unit)

    @property
    def damping_unit(self) -> Real:
        """Damping in s/m of zeta = 1 at the reference velocity (Eqs. 23, 24)."""
        if self.reference_velocity is None:
            raise ValueError("reference_velocity is needed for the dissipation parameters zeta")
        group = np.power(self.hertz_radius, 3) * self.stiffness * np.sqrt(self.reference_velocity)
        return np.power(self.mass / group, 0.4)

    @property
    def stiffness(self) -> Real:
        """Stiffness of the chosen model, Pa."""
        if self.stiffness_model == "hertz":
            return self.hertz_stiffness
        adhesive = np.asarray(getattr(self, self.adhesion_input)) > 0.0
        return np.where(adhesive, REDUCED_STIFFNESS_SHARE, 1.0)[()] * self.hertz_stiffness

    @property
    def radius(self) -> Real:
        """Radius of the sphere, m."""
        return self.diameter / 2.0

    @property
    def hertz_radius(self) -> Real:
        """Effective radius r of Eq. (22), m; the sphere's on a plane."""
        radii = self.radius, self.surface_radius, np.asarray(self.partner_diameter) / 2.0
        sphere, surface, partner = (1.0 / np.asarray(radius) for radius in radii)
        return 1.0 / (sphere + surface + partner)[()]

    @property
    def is_pair(self) -> bool:
        """Whether the contact is one of two spheres."""
        partner = self.partner_diameter
        if isinstance(partner, float):
            return math.isfinite(partner)
        return bool(np.any(np.isfinite(partner)))

    @property
    def mass_share(self) -> Real:
        """Reduced mass over the sphere's: the share of it in relative motion, 1 on a surface."""
        size = np.power(self.diameter / np.asarray(self.partner_diameter), 3)
        return 1.0 / (1.0 + self.particle.density / self.surface.density * size)[()]

    @property
    def pull_off_force(self) -> Real:
        """Pull-off force of JKR, ``3 pi w r / 2`` with the work w of separation, N."""
        hysteresis = isinstance(self.law, Hysteresis)
        work = self.law.unloading_work if hysteresis else self.work_of_adhesion  # type: ignore[union-attr]
        return 1.5 * np.pi * work * self.hertz_radius  # type: ignore[operator]

    @property
    def mass(self) -> Real:
        """Mass of the sphere, kg; of two spheres the reduced mass."""
        sphere = self.particle.density * np.pi * np.power(self.diameter, 3) / 6.0
        return sphere * self.mass_share if self.is_pair else sphere

    @property
    def equilibrium_compression(self) -> Real:
        """Compression at which Hertz and ring force balance, ``2 pi f_0 / K``, m."""
        return 2.0 * np.pi * self.ring_force / self.stiffness  # type: ignore[operator]

    @property
    def equilibrium_contact_radius(self) -> Real:
        """Contact radius at that compression, m."""
        return np.sqrt(self.hertz_radius * self.equilibrium_compression)

    @property
    def velocity_scale(self) -> Real:
        """Velocity scale ``V = (r^(1/2) K d^(5/2) / m)^(1/2)``, d the equilibrium one, m/s."""
        energy = np.sqrt(self.hertz_radius) * self.stiffness * self.equilibrium_compression**2.5
        return np.sqrt(energy / self.mass)

    @property
    def groups(self) -> tuple[Real, Real]:
        """Damping groups (C_H, C_A) = (c_H V, c_A V), the latter at the reference velocity."""
        scale = self.velocity_scale
        return self.hertz_damping * scale, self.adhesion_damping * scale

    def adhesion_damping_at(self, speed: Real) -> Real:
        """Adhesion damping in s/m of an impact with normal speed ``speed`` (m/s, positive)."""
        if self.reference_velocity is None:
            return self.adhesion_damping
        ratio = self.reference_velocity / speed
        with np.errstate(over="ignore"):
            return self.adhesion_damping * np.power(ratio, self.adhesion_rate_exponent)
