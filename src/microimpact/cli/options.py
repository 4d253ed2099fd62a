"""Options that make a contact, for all commands alike, and the contact that they make."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import wraps
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.cli.output import number, option
from microimpact.core.materials import Material, read_materials
from microimpact.core.nearest import nearest
from microimpact.model.choices import CALIBRATED, INTERVAL, STIFFNESS_MODELS
from microimpact.model.contact_laws import NAMES as LAW_NAMES
from microimpact.model.contact_laws import RING_FORCE, named_law

if TYPE_CHECKING:
    from microimpact.model.contact import Contact
    from microimpact.model.contact_laws import ContactLaw
    from microimpact.model.pairs import Pairs

# Diameters that differ by less than this share are one.
SAME_SIZE = 0.01
Command = Callable[..., None]
ROLES = ("particle", "surface")
NOTHING: Mapping[str, float] = {}
# What a contact needs, and what may be in its place.
NEEDED = ("diameter", "work_of_adhesion", "hertz_damping", "adhesion_damping")
IN_PLACE = dict(zip(("ring_force", "zeta_hertz", "zeta_adhesion"), NEEDED[1:], strict=True))
DAMPING = ("ring_force", "hertz_damping", "adhesion_damping", "adhesion_rate_exponent")
SIZES = ("diameter", "partner_diameter")

# Fields of a contact, of its bodies and of its law: option, factor to SI units, and words.
NUMBERS = {
    "diameter": ("diameter-um", 1e-6, "Diameter, um; default: the pair's."),
    "partner_diameter": (
        *("partner-diameter-um", 1e-6),
        "Diameter of a second, free sphere in place of the surface, um.",
    ),
    "work_of_adhesion": ("work-of-adhesion", 1.0, "w_A, J/m2."),
    "ring_force": ("ring-force", 1.0, "f_0, N/m, in place of w_A."),
    "hertz_damping": ("hertz-damping", 1.0, "c_H, s/m."),
    "adhesion_damping": ("adhesion-damping", 1.0, "c_A, s/m."),
    "adhesion_rate_exponent": ("adhesion-rate-exponent", 1.0, "n in c_A (v_N/v_n)^n."),
    "reference_velocity": ("reference-velocity", 1.0, "v_N, m/s."),
    "friction": ("friction", 1.0, "Coulomb coefficient f."),
} | {
    f"{role}.{name}": (f"{role}-{flag}", factor, f"Of the {role}: {words}.")
    for role in ROLES
    for name, flag, factor, words in (
        ("youngs_modulus", "youngs-modulus-gpa", 1e9, "E, GPa"),
        ("poissons_ratio", "poissons-ratio", 1.0, "nu"),
        ("density", "density", 1.0, "kg/m3"),
    )
}
LAW_NUMBERS = {
    "law.viscous_time": ("viscous-time-ns", 1e-9, "Of jkr and maugis-barquins: A of the bulk, ns."),
    "law.yield_pressure": ("yield-pressure-gpa", 1e9, "Of thornton-ning: p_y, GPa."),
    "law.unloading_work": ("unloading-work", 1.0, "Of hysteresis: work of separation, J/m2."),
    "law.edge_speed": ("edge-speed", 1.0, "Of maugis-barquins: c that doubles the work, m/s."),
    "law.edge_exponent": (
        "edge-exponent",
        1.0,
        "Of maugis-barquins: m of the work over the speed.",
    ),
}
_ALL = NUMBERS | LAW_NUMBERS
_WORDS = ("particle", "surface", "file", "materials", "law", "stiffness_model")


def contact_options(command: Command) -> Command:
    """Give a command the options that make a contact, as ``pair``, and ``--json``."""
    body, law = "Contact", "Law of the normal force"
    options = (
        option(body, "--particle", help="Material of the sphere."),
        option(body, "--surface", help="Material of the surface."),
        option(body, "--contact", "file", help="Contacts that 'microimpact calibrate' wrote."),
        *(option(body, f"--{flag}", type=float, help=text) for flag, _, text in NUMBERS.values()),
        option(body, "--materials", help="CSV of own materials, as config/materials.csv."),
        option(
            *(body, "--stiffness-model"),
            type=click.Choice(STIFFNESS_MODELS),
            help=f"Stiffness K of the bodies; default {STIFFNESS_MODELS[0]}.",
        ),
        option(
            *(law, "--law"),
            type=click.Choice(LAW_NAMES),
            help=f"Default {RING_FORCE}; the others have losses of their own.",
        ),
        *(
            option(law, f"--{flag}", type=float, help=text)
            for flag, _, text in LAW_NUMBERS.values()
        ),
        click.option("--json", "as_json", is_flag=True, help="JSON in SI units; infinity is null."),
    )

    @wraps(command)
    def with_pair(**options: Any) -> None:
        changes = {name: options.pop(flag.replace("-", "_")) for name, (flag, *_) in _ALL.items()}
        numbers = {
            name: _ALL[name][1] * value for name, value in changes.items() if value is not None
        }
        words = {name: options.pop(name) for name in _WORDS}
        command(**options, pair=Pair(**words, numbers=numbers))

    wrapped: Command = with_pair
    for each in reversed(options):
        wrapped = each(wrapped)
    return wrapped


def flags(names: Sequence[str]) -> str:
    """Options of fields, as text."""
    return ", ".join(
        f"--{_ALL[name][0] if name in _ALL else name.replace('_', '-')}" for name in names
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """The contact that the options make.

    Attributes
    ----------
    contacts
        The contact, by its law; from a file of draws, arrays of shape (draws, 1) by each law.
    bests
        The best draws, or the contact itself.
    replaced
        Properties of the declared pair that options replaced.
    measured
        Diameter at which draws were calibrated, m; None for a contact that is no draw.
    """

    contacts: Mapping[str, Contact]
    bests: Mapping[str, Contact]
    replaced: Sequence[str] = ()
    measured: float | None = None

    @property
    def best(self) -> Contact:
        """The best draw by the heaviest law, or the contact itself."""
        return next(iter(self.bests.values()))

    @property
    def draws(self) -> int:
        """Number of draws, 0 for one contact."""
        shapes = [contact.shape for contact in self.contacts.values()]
        return sum(int(np.prod(shape)) for shape in shapes if shape)

    def of_all(self, quantity: Callable[[Contact], Any]) -> Any:
        """Return a quantity of all draws, joined along the first axis."""
        return joined([quantity(contact) for contact in self.contacts.values()])

    def doubts(self, *diameters: float) -> Iterator[str]:
        """Say that draws are extrapolated to other diameters, m, and how their laws disagree."""
        from microimpact.model.contact import resized
        from microimpact.model.dynamics.capture import capture_velocity

        for size in diameters or (float(self.best.diameter),):
            if self.measured is None or abs(size / self.measured - 1.0) < SAME_SIZE:
                continue
            limits = [
                f"{number(middle)} ({number(low)} to {number(high)}) by {law}"
                for law, contact in self.contacts.items()
                for low, middle, high in [quantiles(capture_velocity(resized(contact, size)))]
            ]
            yield (
                f"the contacts were calibrated at {self.measured * 1e6:g} um and are extrapolated "
                f"to {size * 1e6:g} um, each by its law: v_c = {'; '.join(limits)} m/s"
            )

    def title(self) -> str:
        """Pair and parameters, and a line on draws or on numbers that are not the declared ones."""
        contact = self.best
        title = (
            f"{contact.particle.name} on {contact.surface.name}, {contact.diameter * 1e6:g} um"
            f"{f' on {contact.partner_diameter * 1e6:g} um' if contact.is_pair else ''}: "
            f"w_A = {contact.work_of_adhesion:.4g} J/m2, "
        )
        if contact.law is None:
            title += (
                f"c_H = {contact.hertz_damping:.4g} s/m, c_A = {contact.adhesion_damping:.4g} s/m, "
                f"n = {contact.adhesion_rate_exponent:.4g}"
            )
        else:
            parameters = contact.law.parameters.items()
            title += f"{contact.law.name}, {', '.join(f'{k} = {v:.4g}' for k, v in parameters)}"
        if self.draws:
            parts = [f"{c.shape[0]} by {law}" for law, c in self.contacts.items() if c.shape]
            laws = f", {', '.join(parts)}" if len(parts) > 1 else ""
            return f"{title}\nThe best of {self.draws} contacts{laws}; intervals hold 95 % of them."
        if not self.replaced:
            return title
        kept = ", ".join(name for name in CALIBRATED[:4] if name not in self.replaced)
        changes = ", ".join(self.replaced)
        return f"{title}\nNo longer the declared contact: {changes} by option, {kept} as declared."

    def inputs(self) -> dict[str, Any]:
        """All parameters in SI units, from which the answer can be computed again."""
        contact = self.best
        inputs: dict[str, Any] = {role: asdict(getattr(contact, role)) for role in ROLES}
        laws = {law: _fields_of(each) for law, each in self.contacts.items()}
        inputs |= {"laws": laws} if len(laws) > 1 else next(iter(laws.values()))
        if contact.is_pair:
            inputs["partner_diameter"] = contact.partner_diameter
        return inputs | {"stiffness_model": contact.stiffness_model}


def _fields_of(contact: Contact) -> dict[str, Any]:
    """Numbers of a contact in SI units, and its law if that is not the ring force."""
    numbers = {
        name: None if (value := getattr(contact, name)) is None else np.squeeze(value)
        for name in ("diameter", "friction", "ring_force", *CALIBRATED)
    }
    if contact.law is None:
        return numbers
    parameters = {name: np.squeeze(value) for name, value in contact.law.parameters.items()}
    return numbers | {"law": contact.law.name} | parameters


def joined(values: Sequence[Any]) -> Any:
    """Join values of draws by several laws along the first axis."""
    return np.concatenate(values) if len(values) > 1 else values[0]


def quantiles(values: Any) -> tuple[float, float, float]:
    """Ends and middle of the 95 % interval of values."""
    low, middle, high = np.quantile(values, INTERVAL, method="nearest").tolist()
    return low, middle, high


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """Words and numbers of a contact, by options.

    Attributes
    ----------
    particle, surface
        Names of the materials.
    file
        Contacts as `measured.contacts.write_contacts` writes them: all but the diameter.
    materials
        CSV of own materials.
    law, stiffness_model
        Words of the model; None: the usual ones.
    numbers
        Fields in SI units, as of `NUMBERS` and `LAW_NUMBERS`.
    """

    particle: str | None = None
    surface: str | None = None
    file: str | None = None
    materials: str | None = None
    law: str | None = None
    stiffness_model: str | None = None
    numbers: Mapping[str, float] = field(default_factory=dict)

    def contact(self, free: Mapping[str, float] = NOTHING) -> Chosen:
        """Return the contact.

        Parameters
        ----------
        free
            Fields that need not be given, since they are to be found, with a first value.

        Raises
        ------
        OSError, ValueError
            If a file cannot be read, or the options do not suffice or contradict each other.
        """
        if self.file is not None:
            return self._from_file(self.file)
        if self.particle is None or self.surface is None:
            raise ValueError("give --particle and --surface, or --contact")
        from microimpact.core.declared import materials
        from microimpact.model.pairs import declared_pairs, pair_contact

        known = {**materials, **(read_materials(self.materials) if self.materials else {})}
        pairs, names, law = declared_pairs(), (self.particle, self.surface), self._law()
        fields: dict[str, Any] = {
            **free,
            **{k: v for k, v in self.numbers.items() if "." not in k},
        }
        if self.stiffness_model is not None:
            fields["stiffness_model"] = self.stiffness_model
        if law is not None:  # its losses take the place of any damping
            fields |= {"hertz_damping": 0.0, "adhesion_damping": 0.0}
        self._require_enough(known, pairs, fields)
        bodies = {
            role: _body(role, name, known.get(name), self._of(role))
            for role, name in zip(ROLES, names, strict=True)
        }
        known |= zip(names, bodies.values(), strict=True)
        contact = pair_contact(*names, known, pairs, **fields).replace(**bodies)
        if law is not None:
            contact = contact.by_law(law, contact.work_of_adhesion or 0.0)
        whole = {RING_FORCE if law is None else law.name: contact}
        replaced = []
        if law is None and names in pairs:
            replaced = [k.replace(".", "_") for k in self.numbers if k not in SIZES]
        return Chosen(contacts=whole, bests=whole, replaced=replaced)

    def _require_enough(
        self, known: Mapping[str, Material], pairs: Pairs, fields: Collection[str]
    ) -> None:
        """Raise ValueError that names all options that bodies and pair lack."""
        pair = str(self.particle), str(self.surface)
        reasons, lacking = [], []
        for role, material in zip(ROLES, pair, strict=True):
            needed = [k for k in NUMBERS if k.startswith(f"{role}.") and k not in self.numbers]
            if needed and material not in known:
                reasons.append(
                    f"the material {material!r} is not declared{nearest(material, known)}"
                )
                lacking += needed
        has = {IN_PLACE.get(name, name) for name in (*fields, *pairs.get(pair, ()))}
        if needed := [name for name in NEEDED if name not in has]:
            state = "incomplete" if pair in pairs else "not declared"
            swapped = [" on ".join(pair[::-1])] if pair[::-1] in pairs else []
            name = " on ".join(pair)
            near = nearest(name, swapped) if swapped else ""
            reasons.append(f"the pair {name!r} is {state}{near}")
            lacking += needed
        if lacking:
            raise ValueError("; ".join([*reasons, f"give {flags(lacking)}"]))

    def _of(self, whose: str) -> dict[str, float]:
        """Numbers of a body, or of the law, by their own names."""
        parts = ((*name.partition("."), value) for name, value in self.numbers.items())
        return {name: value for owner, _, name, value in parts if owner == whose and name}

    def _law(self) -> ContactLaw | None:
        """Law of the normal force; None is the ring force.

        Raises ValueError if a parameter is missing, or of another law.
        """
        name, parameters = self.law or RING_FORCE, self._of("law")
        foreign = [key for key in DAMPING if key in self.numbers]
        if name != RING_FORCE and foreign:
            raise ValueError(f"--law {name} has losses of its own; leave out {flags(foreign)}")
        try:
            return named_law(name, parameters)
        except ValueError as error:
            if parameters:
                raise
            needed = [key for key, (_, _, words) in LAW_NUMBERS.items() if name in words]
            raise ValueError(f"{error}: give {flags(needed)}") from None

    def _from_file(self, file: str) -> Chosen:
        """Contacts of a file, at other diameters if these are given."""
        from microimpact.measured.contacts import read_contacts
        from microimpact.model.contact import resized

        contacts, bests = read_contacts(file)
        excess = [name for name in self.numbers if name not in SIZES]
        excess = [n for n in _WORDS if n != "file" and getattr(self, n) is not None] + excess
        if excess:
            raise ValueError(
                "--contact holds the whole contact, but the diameter may change; leave out "
                f"{flags(excess)}"
            )
        measured = float(next(iter(bests.values())).diameter)
        contacts, bests = (
            {law: resized(contact, **self.numbers) for law, contact in by_law.items()}
            for by_law in (contacts, bests)
        )
        return Chosen(contacts=contacts, bests=bests, measured=measured)


def _body(role: str, name: str, known: Material | None, changes: Mapping[str, Any]) -> Material:
    """Material of a body, with the properties that options give."""
    try:
        return Material(name=name, **changes) if known is None else replace(known, **changes)
    except ValueError as error:
        raise ValueError(f"--{role} {name!r}: {error}") from None
