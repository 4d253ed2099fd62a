"""Commands about one contact: an impact, its capture velocity, its rebound law; materials."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.cli.output import Sweep, number, print_json, print_table, warn
from microimpact.core.arrays import POSITIVE, checked
from microimpact.core.materials import Material, declared_file, read_materials
from microimpact.model.choices import (
    CALIBRATED,
    FORMATS,
    FRICTION_BASES,
    STIFFNESS_MODELS,
    TANGENTIAL_LAWS,
)

if TYPE_CHECKING:
    from microimpact.core.arrays import FloatArray
    from microimpact.model.contact import Contact

Command = Callable[..., None]

# Result field -> label, unit, factor from SI.
_IMPACT = {
    "coefficient_of_restitution": ("coefficient of restitution", "", 1.0),
    "captured": ("captured", "", 1.0),
    "impulse_ratio": ("impulse ratio (-mu)", "", 1.0),
    "rolling": ("rolling at separation", "", 1.0),
    "normal_velocity": ("normal velocity after", "m/s", 1.0),
    "tangential_velocity": ("tangential velocity after", "m/s", 1.0),
    "spin": ("spin after", "rad/s", 1.0),
    "contact_time": ("contact time", "ns", 1e9),
    "maximum_compression": ("maximum compression", "nm", 1e9),
    "energy_loss": ("energy loss, total", "", 1.0),
    "translational_energy_loss": ("energy loss, translational", "", 1.0),
}
# Options that replace a number of the declared pair.
_NUMBERS = {
    "diameter-um": "Diameter, um; default: the pair's.",
    "work-of-adhesion": "w_A, J/m2.",
    "ring-force": "f_0, N/m, in place of w_A.",
    "hertz-damping": "c_H, s/m.",
    "adhesion-damping": "c_A, s/m.",
    "adhesion-rate-exponent": "n in c_A (v_N/v_n)^n.",
    "reference-velocity": "v_N, m/s.",
    "friction": "Coulomb coefficient f.",
}
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
_basis_option = click.option(
    "--friction-basis",
    type=click.Choice(FRICTION_BASES),
    default=FRICTION_BASES[0],
    show_default=True,
    help="Normal force in Coulomb's law.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """A contact, the numbers of its declared pair that options replaced, and what is odd of it.

    A contact from a file of draws has arrays of shape (draws, 1); ``best`` is its best one.
    """

    contact: Contact
    best: Contact
    replaced: Mapping[str, float]

    @property
    def draws(self) -> int:
        """Number of draws, 0 for one contact."""
        return int(np.prod(self.contact.shape)) if self.contact.shape else 0

    def words(self) -> str:
        """Return the pair with its parameters, and what of the declared contact is left."""
        contact = self.best
        title = (
            f"{contact.particle.name} on {contact.surface.name}, {contact.diameter * 1e6:g} um: "
            f"w_A = {contact.work_of_adhesion:.4g} J/m2, c_H = {contact.hertz_damping:.4g} s/m, "
            f"c_A = {contact.adhesion_damping:.4g} s/m, n = {contact.adhesion_rate_exponent:.4g}"
        )
        if self.draws:
            return f"{title}\nThe best of {self.draws} contacts; ranges are from 5 to 95 % of them."
        if not self.replaced:
            return title
        changed = ", ".join(
            f"{name} {float(getattr(contact, name)):.4g} in place of {value:.4g}"
            for name, value in self.replaced.items()
        )
        kept = ", ".join(name for name in CALIBRATED[:4] if name not in self.replaced)
        left = f"; {kept} kept as declared" if kept else ""
        return (
            f"{title}\nNo longer the declared contact, nor what it was calibrated to: "
            f"{changed}{left}."
        )

    def inputs(self) -> dict[str, Any]:
        """Return all parameters in SI units: with them the answer can be had again."""
        contact = self.contact if self.draws else self.best
        numbers = ("diameter", "friction", "ring_force", *CALIBRATED)
        values = {name: getattr(contact, name) for name in numbers}
        return (
            {role: asdict(getattr(contact, role)) for role in ("particle", "surface")}
            | {name: None if of is None else np.squeeze(of) for name, of in values.items()}
            | {"stiffness_model": contact.stiffness_model, "in_place_of": dict(self.replaced)}
        )


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
    friction_basis: str,
    tangential: str,
    yield_strength_mpa: float | None,
    as_json: bool,
    **pair: Any,
) -> None:
    """Simulate one impact, or all of several speeds, angles and spins: then as CSV."""
    from microimpact.model.dynamics.impact import simulate
    from microimpact.model.plausibility import doubts

    asked = contact_of(**pair)
    # All combinations, the last axis the fastest.
    grid = (axis.ravel() for axis in np.meshgrid(speed, angle, spin, indexing="ij"))
    before = dict(zip(("speed", "angle", "spin"), grid, strict=True))
    laws: dict[str, Any] = {"friction_basis": friction_basis, "tangential": tangential}
    outcome = simulate(asked.contact, before["speed"], before["angle"], before["spin"], **laws)
    limit = None
    if yield_strength_mpa is not None:
        limit = 1e6 * float(checked("yield-strength-mpa", yield_strength_mpa, POSITIVE))
    warn(doubts(asked.contact, outcome.maximum_compression, limit))
    found = {name: _summary(getattr(outcome, name), asked.draws) for name in _IMPACT}
    single = before["speed"].size == 1
    if as_json:
        given = {name: of[0] if single else of for name, of in before.items()}
        after = {n: {k: v[0] if single else v for k, v in of.items()} for n, of in found.items()}
        outputs = {n: of["value"] if not asked.draws else of for n, of in after.items()}
        print_json({"inputs": asked.inputs() | given | laws, "outputs": outputs})
        return
    if not single:
        click.echo(_csv(before, found), nl=False)
        return
    first = {name: float(of[0]) for name, of in before.items()}
    title = (
        f"{asked.words()}\n{first['speed']:g} m/s at {first['angle']:g} deg, spin "
        f"{first['spin']:g} rad/s, friction {asked.best.friction:g}, supported by the "
        f"{friction_basis} force"
        f"{'' if tangential == 'rigid' else f', tangential compliance {tangential}'}"
    )
    rows: list[tuple[str, ...]] = []
    for name, (label, unit, factor) in _IMPACT.items():
        of = {end: number(value[0], factor) for end, value in found[name].items()}
        if asked.draws:
            of["value"] += "" if "low" in of else " of all"
            span = f"{of['low']} to {of['high']}" if "low" in of else ""
            rows.append((label, of["value"], span, unit))
        else:
            rows.append((label, of["value"], unit))
    ranges = ["5 to 95 %"] if asked.draws else []
    print_table(title, ("", "median" if asked.draws else "value", *ranges, "unit"), rows)


def _summary(values: Any, draws: int) -> dict[str, Any]:
    """Return the values (n,), or of draws (draws, n) the median and 5 and 95 %; shares of yes."""
    if not draws:
        return {"value": np.atleast_1d(values)}
    if np.asarray(values).dtype == bool:
        return {"value": np.mean(values, axis=0)}
    array = np.asarray(values, dtype=float)
    with np.errstate(invalid="ignore"):  # between infinite contact times
        low, middle, high = np.quantile(array, [0.05, 0.5, 0.95], axis=0, method="nearest")
    return {"value": middle, "low": low, "high": high}


def _csv(before: Mapping[str, FloatArray], found: Mapping[str, Mapping[str, Any]]) -> str:
    """Return one row an impact, SI units in the header."""
    units = {"speed": "m_per_s", "angle": "deg", "spin": "rad_per_s"}
    columns = {f"{name}_{units[name]}": of for name, of in before.items()}
    for name, (_, unit, _) in _IMPACT.items():
        si = {"ns": "_s", "nm": "_m", "": ""}.get(unit, f"_{unit.replace('/', '_per_')}")
        own = f"{name}_after" if name == "spin" else name
        for end, of in found[name].items():
            columns[f"{own}{'' if end == 'value' else f'_{end}'}{si}"] = of
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(np.asarray(of).tolist() for of in columns.values()), strict=True))
    return target.getvalue()


@click.command("capture")
@contact_options
def capture_command(as_json: bool, **pair: Any) -> None:
    """Find the capture velocity of a sphere, and the scales of its contact."""
    from microimpact.model.dynamics.capture import capture_velocity
    from microimpact.model.plausibility import doubts

    asked = contact_of(**pair)
    contact, found = asked.best, _summary(np.ravel(capture_velocity(asked.contact)), 0)["value"]
    warn(doubts(asked.contact))
    if as_json:
        limit = found if asked.draws else found[0]
        print_json({"inputs": asked.inputs(), "outputs": {"capture_velocity": limit}})
        return
    own = float(capture_velocity(contact))
    hertz_group, adhesion_group = contact.groups
    rows = [
        ("capture velocity", number(own), "m/s"),
        ("velocity scale V", number(contact.velocity_scale), "m/s"),
        ("damping group C_H", number(hertz_group), ""),
        ("damping group C_A", number(adhesion_group), ""),
        ("stiffness K", number(contact.stiffness, 1e-9), "GPa"),
        ("ring force f_0", number(contact.ring_force), "N/m"),
        ("work of adhesion w_A", number(contact.work_of_adhesion), "J/m2"),
        ("equilibrium contact radius", number(contact.equilibrium_contact_radius, 1e9), "nm"),
    ]
    if asked.draws:
        low, middle, high = np.quantile(found, [0.05, 0.5, 0.95], method="nearest")
        span = f"{number(middle)} ({number(low)} to {number(high)})"
        rows.insert(1, ("of all contacts, median (5 to 95 %)", span, "m/s"))
    print_table(asked.words(), ("", "value", "unit"), rows)


@click.command("export")
@contact_options
@click.option("--format", "form", type=click.Choice(FORMATS), default=FORMATS[0], show_default=True)
@click.option("-o", "--output", default=".", show_default=True, help="Folder of the files.")
@click.option(
    "--fastest", type=float, default=100.0, show_default=True, help="Fastest normal speed, m/s."
)
@click.option(
    "--tolerance", type=float, default=1e-6, show_default=True, help="Error of e and impulse."
)
@_basis_option
def export_command(
    form: str,
    output: str,
    fastest: float,
    tolerance: float,
    friction_basis: str,
    as_json: bool,
    **pair: Any,
) -> None:
    """Write the rebound law of a contact for a program of flow or of particles."""
    from microimpact.model.dynamics.impact import SPEED
    from microimpact.model.law.table import tabulate
    from microimpact.model.plausibility import doubts

    asked = contact_of(**pair)
    checked("fastest", fastest, SPEED)
    law = tabulate(asked.best, fastest / 2.0, fastest)
    written = [str(path) for path in law.export(output, form, friction_basis, tolerance)]
    warn(doubts(asked.best))
    if as_json:
        options = {"format": form, "fastest": fastest, "tolerance": tolerance}
        inputs = replace(asked, contact=asked.best).inputs() | options
        print_json({"inputs": inputs | {"friction_basis": friction_basis}, "files": written})
        return
    click.echo(asked.words())
    click.echo("\n".join(written))


@click.command("materials")
@click.option("--materials", help="CSV of own materials, as config/materials.csv.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def materials_command(materials: str | None, as_json: bool) -> None:
    """List the declared materials and pairs."""
    known, pairs = _declared(materials)
    properties = {"youngs_modulus": 1e-9, "poissons_ratio": 1.0, "density": 1.0}
    if as_json:
        listed = {name: {p: getattr(of, p) for p in properties} for name, of in known.items()}
        declared = [{"particle": p, "surface": s} | dict(pairs[p, s]) for p, s in pairs]
        print_json({"materials": listed, "pairs": declared})
        return
    print_table(
        "Materials",
        ("material", "Young's modulus (GPa)", "Poisson's ratio", "density (kg/m3)"),
        [
            (name, *(number(getattr(of, p), factor) for p, factor in properties.items()))
            for name, of in known.items()
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


def _declared(
    own: str | None = None,
) -> tuple[dict[str, Material], Mapping[tuple[str, str], Mapping[str, float]]]:
    """Return the materials, those of a file of one's own in place of those shipped, and pairs."""
    from microimpact.model.pairs import declared_pairs

    materials = read_materials(declared_file("materials.csv"))
    if own is not None:
        materials |= read_materials(own)
    return materials, declared_pairs()


def contact_of(
    particle: str | None,
    surface: str | None,
    file: str | None,
    diameter_um: float | None,
    materials: str | None,
    **options: Any,
) -> Asked:
    """Return the contact that the options make.

    Raises ValueError if they do not suffice, or contradict each other.
    """
    from microimpact.model.pairs import IncompletePairError, pair_contact

    diameter = None if diameter_um is None else diameter_um * 1e-6
    fields = (name.replace("-", "_") for name in _NUMBERS if name != "diameter-um")
    changes = {name: options[name] for name in fields}
    if file is not None:
        others = options | {"particle": particle, "surface": surface, "materials": materials}
        model = others.pop("stiffness_model")
        given = [name for name, value in others.items() if value is not None]
        given += ["stiffness_model"] * (model != STIFFNESS_MODELS[0])
        if given:
            raise ValueError(
                "--contact holds the whole contact, but the diameter may change; leave out "
                f"{', '.join('--' + name.replace('_', '-') for name in given)}"
            )
        return _from_file(file, diameter)
    if particle is None or surface is None:
        raise ValueError("give --particle and --surface, or --contact")
    known, pairs = _declared(materials)
    for role, name in (("particle", particle), ("surface", surface)):
        known |= _own_material(role, name, known, options)
    try:
        contact = pair_contact(
            particle,
            surface,
            known,
            pairs,
            diameter=diameter,
            stiffness_model=options["stiffness_model"],
            **changes,
        )
    except IncompletePairError as error:
        flags = [f"--{name.replace('_', '-')}" for name in error.missing]
        wanted = ", ".join("--diameter-um" if flag == "--diameter" else flag for flag in flags)
        raise ValueError(f"{error.pair}; give {wanted}{error.near}") from None
    own = pairs.get((particle, surface), {})
    if changes["ring_force"] is not None and "work_of_adhesion" in own:
        changes["work_of_adhesion"] = float(contact.work_of_adhesion)  # type: ignore[arg-type]
    replaced = {name: own[name] for name in CALIBRATED if own.get(name) is not None}
    replaced = {n: v for n, v in replaced.items() if changes[n] not in {None, v}}
    return Asked(contact=contact, best=contact, replaced=replaced)


def _own_material(
    role: str, name: str, known: Mapping[str, Material], options: Mapping[str, Any]
) -> dict[str, Material]:
    """Return the material with what options say of it, if anything."""
    said = {option: options[f"{role}_{option.replace('-', '_')}"] for option in _ELASTIC}
    given: dict[str, Any] = {
        field: factor * said[option]
        for option, (field, factor, _) in _ELASTIC.items()
        if said[option] is not None
    }
    if not given:
        return {}
    missing = [f"--{role}-{option}" for option, value in said.items() if value is None]
    if missing and name not in known:
        raise ValueError(f"the material {name!r} is not declared; give {', '.join(missing)}, too")
    try:
        own = replace(known[name], **given) if name in known else Material(name=name, **given)
    except ValueError as error:
        raise ValueError(f"--{role} {name!r}: {error}") from None
    return {name: own}


def _from_file(file: str, diameter: float | None) -> Asked:
    """Return the contacts of a file, at another diameter if wished."""
    from microimpact.measured.contacts import read_contacts
    from microimpact.model.contact import resized

    contact, best = read_contacts(file)
    if diameter is not None:
        contact, best = resized(contact, diameter), resized(best, diameter)
    return Asked(contact=contact, best=best, replaced={})
