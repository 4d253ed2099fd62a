"""Commands about one contact: an impact, its capture velocity, its rebound law; materials."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.cli.options import Pair, contact_options, joined, quantiles
from microimpact.cli.output import (
    Command,
    Sweep,
    echo,
    number,
    option,
    print_json,
    print_table,
    warn,
)
from microimpact.core.arrays import POSITIVE, checked
from microimpact.core.files import require_writable
from microimpact.core.materials import read_materials
from microimpact.core.plausible import implausible
from microimpact.model.choices import FORMATS, FRICTION_BASES, INTERVAL, TANGENTIAL_LAWS

if TYPE_CHECKING:
    from microimpact.core.arrays import FloatArray

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
# Properties of a pair beside its diameter, and their symbols.
_SYMBOLS = {
    "work_of_adhesion": "w_A",
    "ring_force": "f_0",
    "hertz_damping": "c_H",
    "adhesion_damping": "c_A",
    "adhesion_rate_exponent": "n",
    "reference_velocity": "v_N",
    "friction": "f",
}
_basis_option = option(
    "Impact",
    "--friction-basis",
    type=click.Choice((*FRICTION_BASES, "pull-off")),
    default=FRICTION_BASES[0],
    show_default=True,
    help="Normal force in Coulomb's law.",
)


@click.command("simulate", cls=Command, short_help="One impact, or a sweep.")
@option("Impact", "--speed", type=Sweep(), required=True, help="Before impact, m/s.")
@option(
    "Impact", "--angle", type=Sweep(), default="90", help="From the surface, degrees; default 90."
)
@option("Impact", "--spin", type=Sweep(), default="0", help="Before impact, rad/s; default 0.")
@option("Impact", "--partner-spin", type=float, default=0.0, help="Of a second sphere, rad/s.")
@_basis_option
@option(
    "Impact",
    "--tangential",
    type=click.Choice(TANGENTIAL_LAWS),
    default=TANGENTIAL_LAWS[0],
    show_default=True,
    help="Compliance along the surface.",
)
@option(
    "Impact",
    "--yield-strength-mpa",
    type=float,
    help="Of the softer body, MPa: warns of impacts beyond.",
)
@contact_options
def simulate_command(
    speed: FloatArray,
    angle: FloatArray,
    spin: FloatArray,
    partner_spin: float,
    friction_basis: str,
    tangential: str,
    yield_strength_mpa: float | None,
    as_json: bool,
    pair: Pair,
) -> None:
    """Simulate one impact, or all of several speeds, angles and spins: then as CSV."""
    from microimpact.model.dynamics.impact import simulate
    from microimpact.model.plausibility import doubts

    chosen = pair.contact()
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
        name: _summary(joined([getattr(outcome, name) for outcome in outcomes]), chosen.draws)
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
        echo(_csv(before, after), nl=False)


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


@click.command("capture", cls=Command, short_help="Capture velocity and scales of a contact.")
@contact_options
def capture_command(as_json: bool, pair: Pair) -> None:
    """Find the capture velocity of a sphere, and the scales of its contact."""
    from microimpact.model.closed_forms import contact_regime, tabor_number
    from microimpact.model.dynamics.capture import capture_velocity
    from microimpact.model.plausibility import doubts

    chosen = pair.contact()
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
        ("Tabor's number, JKR or DMT", number(tabor), contact_regime(tabor)),
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


@click.command("export", cls=Command, short_help="The rebound law for other programs.")
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
@contact_options
def export_command(
    form: str,
    output: str,
    diameters_um: tuple[float, float] | None,
    fastest: float,
    tolerance: float,
    speeds: FloatArray | None,
    friction_basis: str,
    as_json: bool,
    pair: Pair,
) -> None:
    """Write the rebound law of a contact for a program of flow or of particles."""
    from microimpact.model.law.export import export
    from microimpact.model.plausibility import doubts

    if diameters_um is not None and "diameter" not in pair.numbers:
        pair = replace(pair, numbers={**pair.numbers, "diameter": 1e-6 * diameters_um[0]})
    chosen = pair.contact()
    require_writable(f"{output}/law")
    sizes = np.atleast_1d(1e-6 * checked("diameters-um", diameters_um or (), POSITIVE))
    warn(chosen.doubts(*sizes.tolist()))
    contact = chosen.best
    if len(chosen.bests) > 1:
        laws = ", ".join(chosen.contacts)
        warn([f"of contacts by {laws}, the best by the {next(iter(chosen.bests))} is written"])
    if diameters_um is not None:
        contact = contact.replace(diameter=sizes)
    files = export(contact, output, form, fastest, friction_basis, tolerance, speeds)
    written = [str(path) for path in files]
    warn(doubts(contact))
    whole = {next(iter(chosen.bests)): contact}
    if as_json:
        options = {"format": form, "fastest": fastest, "tolerance": tolerance}
        inputs = replace(chosen, contacts=whole, bests=whole).inputs() | options
        print_json({"inputs": inputs | {"friction_basis": friction_basis}, "files": written})
        return
    echo(chosen.title())
    if diameters_um is not None:
        echo("The law is for all diameters from {:g} to {:g} um.".format(*sorted(diameters_um)))
    echo("\n".join(written))


@click.command("materials", short_help="Declared materials and pairs.")
@click.option("--materials", help="CSV of own materials, as config/materials.csv.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def materials_command(materials: str | None, as_json: bool) -> None:
    """List the declared materials and pairs."""
    from microimpact.core.declared import materials as shipped
    from microimpact.model.pairs import declared_pairs

    known, pairs = dict(shipped), declared_pairs()
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
        "\nDeclared pairs (SI units, but for d)",
        ("particle", "surface", "d (um)", *_SYMBOLS.values()),
        [
            (
                *pair,
                number(values["diameter"], 1e6),
                *(number(values[name]) if name in values else "" for name in _SYMBOLS),
            )
            for pair, values in pairs.items()
        ],
    )
