"""Laws of the normal force beside the article's ring force, as records of their parameters.

Each of them rests on the contact of Johnson, Kendall and Roberts 1971 (JKR), with the work of
adhesion and the materials of its `Contact`; its forces are in
`microimpact.model.dynamics.force_laws`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import ClassVar

from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, Range, Real, checked
from microimpact.core.readable import Readable

RING_FORCE = "ring force"
# Speeds c of an edge, m/s. At a hundred times the fastest sound the contact is that of JKR; at the
# slowest, separation at 20 m/s takes a thousand times the work, even with m = 0.12.
EDGE_SPEEDS = (1e-24, 1e6)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ContactLaw(Readable):
    """A law of the normal force; its parameters may be arrays, as the fields of a contact."""

    name: ClassVar[str] = ""
    # Ranges of parameters; of the others all positive numbers.
    admissible: ClassVar[Mapping[str, Range]] = {}

    def __post_init__(self) -> None:
        """Check the parameters.

        Raises TypeError, ValueError if one is not a number, or out of range.
        """
        for name, value in self.parameters.items():
            object.__setattr__(
                self, name, checked(f"law.{name}", value, self.admissible.get(name, POSITIVE))
            )

    @property
    def parameters(self) -> dict[str, Real]:
        """The parameters by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class JKR(ContactLaw):
    """JKR contact with viscous loss in the bulk (Krijt et al. 2013).

    It closes at touch and breaks at a negative overlap; that alone costs energy. The bulk opposes
    ``2 E* a A`` times the speed of compression, the stiffness of a contact of radius a.

    Parameters
    ----------
    viscous_time
        Relaxation time A, s; T_vis/nu^2 of Krijt et al.
    """

    name: ClassVar[str] = "jkr"
    admissible: ClassVar[Mapping[str, Range]] = {"viscous_time": NON_NEGATIVE}
    viscous_time: Real = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ThorntonNing(ContactLaw):
    """Adhesive elastic, perfectly plastic contact (Thornton and Ning 1998).

    JKR until the pressure in the middle reaches the yield pressure; a force that grows with the
    area of contact beyond; elastic unloading, JKR with the flattened sphere's larger radius.

    Parameters
    ----------
    yield_pressure
        p_y, Pa: about 1.6 times the yield strength, up to 2.8 times it, the hardness.
    """

    name: ClassVar[str] = "thornton-ning"
    yield_pressure: Real


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Hysteresis(ContactLaw):
    """Rate-independent hysteresis of adhesion: the contact closes by one work and opens by another.

    JKR with the contact's work of adhesion while the contact grows; at constant radius until the
    release of energy suffices for the larger work; JKR with that one while it shrinks.

    Parameters
    ----------
    unloading_work
        Work of adhesion of separation, J/m2; not below the contact's, which is that of approach.
    """

    name: ClassVar[str] = "hysteresis"
    unloading_work: Real


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class MaugisBarquins(JKR):
    """JKR contact whose edge needs the more work, the faster it opens (Maugis and Barquins 1978).

    The contact closes by the contact's work of adhesion w. While its radius a falls, the work of
    separation is ``w (1 + (|da/dt|/c)^m)``; radius and compression are then independent.

    Parameters
    ----------
    edge_speed
        Speed c at which the work of separation is twice that of adhesion, m/s, 1e-24 to 1e6.
    edge_exponent
        m, 0.02 to 2; below, it is `Hysteresis`; beyond, the loss would outgrow the energy, and
        fast spheres stick.
    viscous_time
        As of `JKR`.
    """

    name: ClassVar[str] = "maugis-barquins"
    admissible: ClassVar[Mapping[str, Range]] = {
        "edge_speed": Range(*EDGE_SPEEDS, lower_closed=True, upper_closed=True),
        "edge_exponent": Range(lower=0.02, upper=2.0, lower_closed=True, upper_closed=True),
        **JKR.admissible,
    }
    edge_speed: Real
    edge_exponent: Real


LAWS: tuple[type[ContactLaw], ...] = (JKR, ThorntonNing, Hysteresis, MaugisBarquins)
NAMES = (RING_FORCE, *(law.name for law in LAWS))


# Parameters of the laws by name, each with the first law that has it.
PARAMETERS = {field.name: law for law in reversed(LAWS) for field in fields(law)}


def _required(law: type[ContactLaw]) -> list[str]:
    """Return the parameters of a law that have no default."""
    return [field.name for field in fields(law) if field.default is MISSING]


def named_law(name: str, parameters: Mapping[str, Real]) -> ContactLaw | None:
    """Return a law by name, with the parameters that are given; None is the ring force.

    Raises ValueError if it does not know one, or lacks one.
    """
    law = next((law for law in LAWS if law.name == name), None)
    foreign = [key for key in parameters if not hasattr(law, key)]
    if foreign:
        owner = PARAMETERS[foreign[0]].name
        raise ValueError(f"law {name!r} does not know {foreign[0]}: that is of {owner!r}")
    complete = law is not None and set(_required(law)) <= set(parameters)
    return contact_law(law(**parameters) if law and complete else name)


def contact_law(value: object) -> ContactLaw | None:
    """Return a law given as a record or by name; None is the ring force.

    Raises TypeError, ValueError if it is no law, or a name whose law needs a parameter.
    """
    if value is None or value == RING_FORCE:
        return None
    if value == JKR.name:
        return JKR()
    for law in LAWS:
        if value == law.name:
            needed = ", ".join(f"{name}=..." for name in _required(law))
            raise ValueError(f"law {value!r} needs its parameters: law={law.__name__}({needed})")
    if isinstance(value, str):
        raise ValueError(f"law must be one of {', '.join(map(repr, NAMES))}, got {value!r}")
    if not isinstance(value, ContactLaw):
        records = ", ".join(law.__name__ for law in LAWS)
        raise TypeError(f"law must be {RING_FORCE!r} or one of {records}, got {value!r}")
    return value
