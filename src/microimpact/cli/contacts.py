"""Commands about one contact: an impact, its capture velocity, its rebound law; materials."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.cli.output import Sweep, number, print_json, print_table, warn
from microimpact.core.arrays import POSITIVE, checked
from microimpact.core.materials import Material, read_materials
from microimpact.core.nearest import nearest
from microimpact.core.plausible import implausible
from microimpact.model.choices import (
    CALIBRATED,
    FORMATS,
    FRICTION_BASES,
    INTERVAL,
    STIFFNESS_MODELS,
    TANGENTIAL_LAWS,
)
from microimpact.model.contact_laws import NAMES as LAW_NAMES
from microimpact.model.contact_laws import RING_FORCE, named_law

if TYPE_CHECKING:
    from microimpact.core.arrays import FloatArray
    from microimpact.model.contact import Contact
    from microimpact.model.contact_laws import ContactLaw

# Diameters that differ by less than this share are one.
SAME_SIZE = 0.01
Command = Callable[..., None]
Pair = tuple[str, str]
# Values of impacts (n,) by "value", and over draws by "low" and "high", too.
Summary = Mapping[str, Any]

# Result field -> label, unit, factor from SI.
_IMPACT = {
    "coefficient_of_restitution": ("coefficient of restitution", "", 1.0),
    "captured": ("captured", "", 1.0),
    "impulse_ratio": ("impulse ratio (-mu)", "", 1.0),
    "rolling": ("rolling at separation", "", 1.0),
    "normal_velocity": ("normal velocity after", "m/s", 1.0),
    "tangential_velocity": ("tangential velocity after", "m/s", 1.0),
    "spin": ("spin after", "rad/s", 1.0),
    "partner_spin": ("spin of the second sphere after", "rad/s", 1.0),
    "contact_time": ("contact time", "ns", 1e9),
    "maximum_compression": ("maximum compression", "nm", 1e9),
    "energy_loss": ("energy loss, total", "", 1.0),
    "translational_energy_loss": ("energy loss, translational", "", 1.0),
}
# Options that replace a number of the declared pair.
_NUMBERS = {
    "diameter-um": "Diameter, um; default: the pair's.",
    "partner-diameter-um": "Diameter of a second, free sphere in place of the surface, um.",
    "work-of-adhesion": "w_A, J/m2.",
    "ring-force": "f_0, N/m, in place of w_A.",
    "hertz-damping": "c_H, s/m.",
    "adhesion-damping": "c_A, s/m.",
    "adhesion-rate-exponent": "n in c_A (v_N/v_n)^n.",
    "reference-velocity": "v_N, m/s.",
    "friction": "Coulomb coefficient f.",
}
_FIELDS = [name.replace("-", "_") for name in _NUMBERS if not name.endswith("diameter-um")]
# Properties of a pair, and their symbols.
_SYMBOLS = {
    "diameter": "d",
    "work_of_adhesion": "w_A",
    "ring_force": "f_0",
    "hertz_damping": "c_H",
    "adhesion_damping": "c_A",
    "adhesion_rate_exponent": "n",
    "reference_velocity": "v_N",
    "friction": "f",
}
# Options of a material: its field, the factor to SI, and words.
_ELASTIC = {
    "youngs-modulus-gpa": ("youngs_modulus", 1e9, "E, GPa"),
    "poissons-ratio": ("poissons_ratio", 1.0, "nu"),
    "density": ("density", 1.0, "kg/m3"),
}
_BODIES = [
    f"{role}_{name}".replace("-", "_") for role in ("particle", "surface") for name in _ELASTIC
]
# Parameters of other laws of the normal force: options, factors to SI, and words.
_LAW_NUMBERS = {
    "viscous_time": ("viscous-time-ns", 1e-9, "Of jkr and maugis-barquins: A of the bulk, ns."),
    "yield_pressure": ("yield-pressure-gpa", 1e9, "Of thornton-ning: p_y, GPa."),
    "unloading_work": ("unloading-work", 1.0, "Of hysteresis: work of separation, J/m2."),
    "edge_speed": ("edge-speed", 1.0, "Of maugis-barquins: c that doubles the work, m/s."),
    "edge_exponent": ("edge-exponent", 1.0, "Of maugis-barquins: m of the work over the speed."),
}
_basis_option = click.option(
    "--friction-basis",
    type=click.Choice((*FRICTION_BASES, "pull-off")),
    default=FRICTION_BASES[0],
    show_default=True,
    help="Normal force in Coulomb's law.",
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
        return _joined([quantity(contact) for contact in self.contacts.values()])

    def doubts(self) -> Iterator[str]:
        """Say that draws are extrapolated to another diameter, and how their laws disagree."""
        from microimpact.model.dynamics.capture import capture_velocity

        size = float(self.best.diameter)
        if self.measured is None or abs(size / self.measured - 1.0) < SAME_SIZE:
            return
        limits = [
            f"{number(middle)} ({number(low)} to {number(high)}) by {law}"
            for law, contact in self.contacts.items()
            for low, middle, high in [quantiles(capture_velocity(contact))]
        ]
        yield (
            f"the contacts were calibrated at {self.measured * 1e6:g} um and are extrapolated to "
            f"{size * 1e6:g} um, each by its law: v_c = {'; '.join(limits)} m/s"
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
        inputs: dict[str, Any] = {
            role: asdict(getattr(contact, role)) for role in ("particle", "surface")
        }
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


def quantiles(values: Any) -> tuple[float, float, float]:
    """Ends and middle of the 95 % interval of values."""
    low, middle, high = np.quantile(values, INTERVAL, method="nearest").tolist()
    return low, middle, high


def contact_options(command: Command) -> Command:
    """Give a command the options that make a contact, as ``pair``, and ``--json``."""
    options = (
        click.option("--particle", help="Material of the sphere."),
        click.option("--surface", help="Material of the surface."),
        click.option("--contact", "file", help="Contacts that 'microimpact calibrate' wrote."),
        *(click.option(f"--{name}", type=float, help=text) for name, text in _NUMBERS.items()),
        *(
            click.option(f"--{role}-{name}", type=float, help=f"Of the {role}: {text}.")
            for role in ("particle", "surface")
            for name, (_, _, text) in _ELASTIC.items()
        ),
        click.option("--materials", help="CSV of own materials, as config/materials.csv."),
        click.option(
            "--law",
            type=click.Choice(LAW_NAMES),
            default=RING_FORCE,
            show_default=True,
            help="Law of the normal force; other ones have losses of their own.",
        ),
        *(
            click.option(f"--{flag}", name, type=float, help=text)
            for name, (flag, _, text) in _LAW_NUMBERS.items()
        ),
        click.option(
            "--stiffness-model",
            type=click.Choice(STIFFNESS_MODELS),
            default=STIFFNESS_MODELS[0],
            show_default=True,
        ),
        click.option("--json", "as_json", is_flag=True, help="JSON in SI units; infinity is null."),
    )
    for option in reversed(options):
        command = option(command)
    return command


@click.command("simulate")
@contact_options
@click.option("--speed", type=Sweep(), required=True, help="Before impact, m/s.")
@click.option("--angle", type=Sweep(), default="90", help="From the surface, degrees; default 90.")
@click.option("--spin", type=Sweep(), default="0", help="Before impact, rad/s; default 0.")
@click.option("--partner-spin", type=float, default=0.0, help="Of a second sphere, rad/s.")
@_basis_option
@click.option(
    "--tangential",
    type=click.Choice(TANGENTIAL_LAWS),
    default=TANGENTIAL_LAWS[0],
    show_default=True,
    help="Compliance along the surface.",
)
@click.option(
    "--yield-strength-mpa", type=float, help="Of the softer body, MPa: warns of impacts beyond."
)
def simulate_command(
    speed: FloatArray,
    angle: FloatArray,
    spin: FloatArray,
    partner_spin: float,
    friction_basis: str,
    tangential: str,
    yield_strength_mpa: float | None,
    as_json: bool,
    **pair: Any,
) -> None:
    """Simulate one impact, or all of several speeds, angles and spins: then as CSV."""
    from microimpact.model.dynamics.impact import simulate
    from microimpact.model.plausibility import doubts

    chosen = contact_of(**pair)
    # All combinations, the last axis the fastest.
    axes = np.meshgrid(speed, angle, spin, indexing="ij")
    names = ("speed", "angle", "spin")
    before = {name: axis.ravel() for name, axis in zip(names, axes, strict=True)}
    laws: dict[str, Any] = {"friction_basis": friction_basis, "tangential": tangential}
    motion: dict[str, Any] = before | {"partner_spin": partner_spin}
    outcomes = [simulate(contact, **motion, **laws) for contact in chosen.contacts.values()]
    limit = None
    if yield_strength_mpa is not None:
        limit = 1e6 * float(checked("yield-strength-mpa", yield_strength_mpa, POSITIVE))
    warn((*chosen.doubts(), *implausible({"angle": np.max(angle)})))
    for contact, outcome in zip(chosen.contacts.values(), outcomes, strict=True):
        warn(doubts(contact, outcome.maximum_compression, limit))
    after = {
        name: _summary(_joined([getattr(outcome, name) for outcome in outcomes]), chosen.draws)
        for name in _IMPACT
        if chosen.best.is_pair or name != "partner_spin"
    }
    single = before["speed"].size == 1
    if as_json:
        row = 0 if single else slice(None)
        incident = {name: values[row] for name, values in before.items()}
        if chosen.best.is_pair:
            incident["partner_spin"] = np.asarray(partner_spin)
        outputs: dict[str, Any] = {}
        for name, summary in after.items():
            numbers = {key: values[row] for key, values in summary.items()}
            outputs[name] = numbers if chosen.draws else numbers["value"]
        print_json({"inputs": chosen.inputs() | incident | laws, "outputs": outputs})
    elif single:
        v, degrees, omega = (float(values[0]) for values in before.values())
        title = (
            f"{chosen.title()}\n{v:g} m/s at {degrees:g} deg, spin {omega:g} rad/s, "
            f"friction {chosen.best.friction:g}, supported by the {friction_basis} force"
            f"{'' if tangential == 'rigid' else f', tangential compliance {tangential}'}"
        )
        _print_impact(title, after, draws=bool(chosen.draws))
    else:
        click.echo(_csv(before, after), nl=False)


def _print_impact(title: str, after: Mapping[str, Summary], *, draws: bool) -> None:
    """Print one impact, or the median and the range over draws of the contact."""
    rows: list[tuple[str, ...]] = []
    for name, summary in after.items():
        label, unit, factor = _IMPACT[name]
        numbers = {key: number(values[0], factor) for key, values in summary.items()}
        if not draws:
            rows.append((label, numbers["value"], unit))
        elif "low" in numbers:
            rows.append((label, numbers["value"], f"{numbers['low']} to {numbers['high']}", unit))
        else:
            rows.append((label, f"{numbers['value']} of all", "", unit))
    header = ("", "median", "95 %", "unit") if draws else ("", "value", "unit")
    print_table(title, header, rows)


def _joined(values: Sequence[Any]) -> Any:
    """Join values of draws by several laws along the first axis."""
    return np.concatenate(values) if len(values) > 1 else values[0]


def _summary(values: Any, draws: int) -> Summary:
    """Values (n,), or of draws (draws, n) the median and the 95 % interval; shares of yes."""
    if not draws:
        return {"value": np.atleast_1d(values)}
    if np.asarray(values).dtype == bool:
        return {"value": np.mean(values, axis=0)}
    array = np.asarray(values, dtype=float)
    with np.errstate(invalid="ignore"):  # between infinite contact times
        low, middle, high = np.quantile(array, INTERVAL, axis=0, method="nearest")
    return {"value": middle, "low": low, "high": high}


def _csv(before: Mapping[str, FloatArray], after: Mapping[str, Summary]) -> str:
    """One row an impact, SI units in the header."""
    units = {"speed": "m_per_s", "angle": "deg", "spin": "rad_per_s"}
    columns = {f"{name}_{units[name]}": values for name, values in before.items()}
    for name, summary in after.items():
        unit = _IMPACT[name][1]
        si = {"ns": "_s", "nm": "_m", "": ""}.get(unit, f"_{unit.replace('/', '_per_')}")
        stem = f"{name}_after" if name.endswith("spin") else name
        for key, values in summary.items():
            columns[f"{stem}{'' if key == 'value' else f'_{key}'}{si}"] = values
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return target.getvalue()


@click.command("capture")
@contact_options
def capture_command(as_json: bool, **pair: Any) -> None:
    """Find the capture velocity of a sphere, and the scales of its contact."""
    from microimpact.model.closed_forms import contact_regime, tabor_number
    from microimpact.model.dynamics.capture import capture_velocity
    from microimpact.model.plausibility import doubts

    chosen = contact_of(**pair)
    limits = np.ravel(chosen.of_all(capture_velocity))
    warn(chosen.doubts())
    for each in chosen.contacts.values():
        warn(doubts(each))
    if as_json:
        outputs = {"capture_velocity": limits if chosen.draws else limits[0]}
        print_json({"inputs": chosen.inputs(), "outputs": outputs})
        return
    contact = chosen.best
    tabor = float(tabor_number(contact))
    rows = [
        ("capture velocity", number(float(capture_velocity(contact))), "m/s"),
        ("stiffness K", number(contact.stiffness, 1e-9), "GPa"),
        ("work of adhesion w_A", number(contact.work_of_adhesion), "J/m2"),
        ("Tabor's number, JKR or DMT", f"{number(tabor)}: {contact_regime(tabor)}", ""),
    ]
    if contact.law is None:
        hertz_group, adhesion_group = contact.groups
        rows += [
            ("ring force f_0", number(contact.ring_force), "N/m"),
            ("velocity scale V", number(contact.velocity_scale), "m/s"),
            ("damping group C_H", number(hertz_group), ""),
            ("damping group C_A", number(adhesion_group), ""),
            ("equilibrium contact radius", number(contact.equilibrium_contact_radius, 1e9), "nm"),
        ]
    if chosen.draws:
        low, middle, high = quantiles(limits)
        span = f"{number(middle)} ({number(low)} to {number(high)})"
        rows.insert(1, ("of all contacts, median (95 %)", span, "m/s"))
    print_table(chosen.title(), ("", "value", "unit"), rows)


@click.command("export")
@contact_options
@click.option("--format", "form", type=click.Choice(FORMATS), default=FORMATS[0], show_default=True)
@click.option("-o", "--output", default=".", show_default=True, help="Folder of the files.")
@click.option(
    "--diameters-um", type=(float, float), help="Smallest and largest, um: a law for all between."
)
@click.option(
    "--fastest", type=float, default=100.0, show_default=True, help="Fastest normal speed, m/s."
)
@click.option(
    "--tolerance", type=float, default=1e-6, show_default=True, help="Error of e and impulse."
)
@click.option("--speeds", type=Sweep(), help="Of fitted coefficients, m/s; default 1.5 to 15 v_c.")
@_basis_option
def export_command(
    form: str,
    output: str,
    diameters_um: tuple[float, float] | None,
    fastest: float,
    tolerance: float,
    speeds: FloatArray | None,
    friction_basis: str,
    as_json: bool,
    **pair: Any,
) -> None:
    """Write the rebound law of a contact for a program of flow or of particles."""
    from microimpact.model.law.export import export
    from microimpact.model.plausibility import doubts

    if diameters_um is not None and pair["diameter_um"] is None:
        pair["diameter_um"] = diameters_um[0]
    chosen = contact_of(**pair)
    warn(chosen.doubts())
    contact = chosen.best
    if len(chosen.bests) > 1:
        laws = ", ".join(chosen.contacts)
        warn([f"of contacts by {laws}, the best by the {next(iter(chosen.bests))} is written"])
    if diameters_um is not None:
        contact = contact.replace(diameter=1e-6 * checked("diameters-um", diameters_um, POSITIVE))
    files = export(contact, output, form, fastest, friction_basis, tolerance, speeds)
    written = [str(path) for path in files]
    warn(doubts(contact))
    whole = {next(iter(chosen.bests)): contact}
    if as_json:
        options = {"format": form, "fastest": fastest, "tolerance": tolerance}
        inputs = replace(chosen, contacts=whole, bests=whole).inputs() | options
        print_json({"inputs": inputs | {"friction_basis": friction_basis}, "files": written})
        return
    click.echo(chosen.title())
    if diameters_um is not None:
        click.echo(
            "The law is for all diameters from {:g} to {:g} um.".format(*sorted(diameters_um))
        )
    click.echo("\n".join(written))


@click.command("materials")
@click.option("--materials", help="CSV of own materials, as config/materials.csv.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def materials_command(materials: str | None, as_json: bool) -> None:
    """List the declared materials and pairs."""
    known, pairs = _shipped()
    if materials is not None:
        known |= read_materials(materials)
    factors = {"youngs_modulus": 1e-9, "poissons_ratio": 1.0, "density": 1.0}
    if as_json:
        listed = {
            name: {key: getattr(body, key) for key in factors} for name, body in known.items()
        }
        declared = [{"particle": p, "surface": s} | dict(pairs[p, s]) for p, s in pairs]
        print_json({"materials": listed, "pairs": declared})
        return
    print_table(
        "Materials",
        ("material", "Young's modulus (GPa)", "Poisson's ratio", "density (kg/m3)"),
        [
            (name, *(number(getattr(body, key), factor) for key, factor in factors.items()))
            for name, body in known.items()
        ],
    )
    print_table(
        "Declared pairs (SI units)",
        ("particle", "surface", *_SYMBOLS.values()),
        [
            (*pair, *(f"{values[name]:g}" if name in values else "" for name in _SYMBOLS))
            for pair, values in pairs.items()
        ],
    )


def _shipped() -> tuple[dict[str, Material], dict[Pair, dict[str, float]]]:
    """Shipped materials and pairs."""
    from microimpact.core.declared import materials
    from microimpact.model.pairs import declared_pairs

    return dict(materials), declared_pairs()


def contact_of(
    particle: str | None,
    surface: str | None,
    file: str | None,
    diameter_um: float | None,
    partner_diameter_um: float | None,
    materials: str | None,
    missing: Sequence[str] = (),
    **options: Any,
) -> Chosen:
    """Return the contact that the options make.

    Parameters
    ----------
    particle, surface
        Names of the materials.
    file
        Contacts as `measured.contacts.write_contacts` writes them: all but the diameter.
    diameter_um, partner_diameter_um
        um; None: that of the pair or of the file, and no second sphere.
    materials
        CSV of own materials.
    missing
        Options that the command lacks beside these, to be asked for together.
    **options
        All other options of `contact_options`; None where they are not set.

    Raises
    ------
    OSError, ValueError
        If a file cannot be read, or the options do not suffice or contradict each other.
    """
    microns = {"diameter": diameter_um, "partner_diameter": partner_diameter_um}
    sizes = {name: size * 1e-6 for name, size in microns.items() if size is not None}
    if file is not None:
        excess = options | {"particle": particle, "surface": surface, "materials": materials}
        return _from_file(file, sizes, excess, missing)
    if particle is None or surface is None:
        raise ValueError("give --particle and --surface, or --contact")
    from microimpact.model.pairs import pair_contact

    declared, pairs = _shipped()
    if materials is not None:
        declared |= read_materials(materials)
    law = _law(options)
    changes = {name: options[name] for name in _FIELDS}
    changes |= {"stiffness_model": options["stiffness_model"]} | sizes
    if law is not None:  # its losses take the place of any damping
        changes |= {"hertz_damping": 0.0, "adhesion_damping": 0.0}
    known = _completed((particle, surface), declared, pairs, options, changes, missing)
    contact = pair_contact(particle, surface, known, pairs, **changes)
    if law is not None:
        contact = contact.by_law(law, contact.work_of_adhesion or 0.0)
    whole = {RING_FORCE if law is None else law.name: contact}
    replaced = []
    if law is None and (particle, surface) in pairs:
        replaced = [name for name in (*_FIELDS, *_BODIES) if options[name] is not None]
    return Chosen(contacts=whole, bests=whole, replaced=replaced)


def _law(options: Mapping[str, Any]) -> ContactLaw | None:
    """Law of the normal force that the options make; None is the ring force.

    Raises ValueError if a parameter is missing, or of another law.
    """
    name = options["law"]
    parameters = {
        key: factor * options[key]
        for key, (_, factor, _) in _LAW_NUMBERS.items()
        if options[key] is not None
    }
    damping = ("ring_force", "hertz_damping", "adhesion_damping", "adhesion_rate_exponent")
    foreign = [_flag(key) for key in damping if options[key] is not None]
    if name != RING_FORCE and foreign:
        raise ValueError(f"--law {name} has losses of its own; leave out {', '.join(foreign)}")
    try:
        return named_law(name, parameters)
    except ValueError as error:
        if parameters:
            raise
        flags = ", ".join(f"--{flag}" for flag, _, text in _LAW_NUMBERS.values() if name in text)
        raise ValueError(f"{error}: give {flags}") from None


def _completed(
    pair: Pair,
    known: Mapping[str, Material],
    pairs: Mapping[Pair, Mapping[str, float]],
    options: Mapping[str, Any],
    changes: Mapping[str, Any],
    missing: Sequence[str],
) -> Mapping[str, Material]:
    """Known materials with those of the options; all options that are missing are asked for."""
    from microimpact.model.pairs import IncompletePairError, pair_fields

    reasons: list[str] = []
    flags: list[str] = []
    for role, name in zip(("particle", "surface"), pair, strict=True):
        known, missing_here = _with_options(role, name, known, options)
        if missing_here:
            reasons.append(f"the material {name!r} is not declared{nearest(name, known)}")
            flags += missing_here
    try:
        pair_fields(*pair, pairs, **changes)
    except IncompletePairError as error:
        reasons.append(f"{error.pair}{error.near}")
        flags += ["--diameter-um" if name == "diameter" else _flag(name) for name in error.missing]
    if flags or missing:
        raise ValueError("; ".join([*reasons, f"give {', '.join([*flags, *missing])}"]))
    return known


def _flag(name: str) -> str:
    """Command line option of a parameter."""
    return f"--{name.replace('_', '-')}"


def _with_options(
    role: str, name: str, known: Mapping[str, Material], options: Mapping[str, Any]
) -> tuple[dict[str, Material], list[str]]:
    """Known materials, a body's with the properties that options give; and options it lacks."""
    values = {option: options[f"{role}_{option.replace('-', '_')}"] for option in _ELASTIC}
    fields: dict[str, Any] = {
        field: factor * values[option]
        for option, (field, factor, _) in _ELASTIC.items()
        if values[option] is not None
    }
    missing = [f"--{role}-{option}" for option, value in values.items() if value is None]
    if name not in known and missing:
        return dict(known), missing
    if not fields:
        return dict(known), []
    try:
        body = replace(known[name], **fields) if name in known else Material(name=name, **fields)
    except ValueError as error:
        raise ValueError(f"--{role} {name!r}: {error}") from None
    return {**known, name: body}, []


def _from_file(
    file: str, sizes: Mapping[str, float], others: Mapping[str, Any], missing: Sequence[str]
) -> Chosen:
    """Contacts of a file, at other diameters (m) if these are given.

    Raises OSError or ValueError if the file cannot be read, other options are set, or some that the
    command needs are missing.
    """
    from microimpact.measured.contacts import read_contacts
    from microimpact.model.contact import resized

    contacts, bests = read_contacts(file)
    usual = {"stiffness_model": STIFFNESS_MODELS[0], "law": RING_FORCE}
    flags = [_flag(n) for n, value in others.items() if value is not None and value != usual.get(n)]
    if flags:
        raise ValueError(
            "--contact holds the whole contact, but the diameter may change; leave out "
            f"{', '.join(flags)}"
        )
    if missing:
        raise ValueError(f"give {', '.join(missing)}")
    measured = float(next(iter(bests.values())).diameter)
    contacts, bests = (
        {law: resized(contact, **sizes) for law, contact in by_law.items()}
        for by_law in (contacts, bests)
    )
    return Chosen(contacts=contacts, bests=bests, measured=measured)
