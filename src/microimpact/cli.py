"""The command ``microimpact``: impacts, capture velocities and materials; results compared."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.core.arrays import POSITIVE, checked
from microimpact.core.materials import declared_file, materials_from_rows
from microimpact.declared.selection import CONTACT_COLUMNS, MATERIAL_COLUMNS, read_declared
from microimpact.report.commands import COMMANDS as RESULTS

if TYPE_CHECKING:
    from microimpact.core.materials import Material
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


# What makes a contact of two materials: adhesion, damping, and how damping goes with the rate.
_CALIBRATED = (
    "work_of_adhesion",
    "hertz_damping",
    "adhesion_damping",
    "adhesion_rate_exponent",
    "reference_velocity",
)


def main() -> None:
    """Run the command; bad input ends with one line and exit code 2, a failure with 1."""
    try:
        commands.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except click.Abort:
        sys.exit(130)
    except ModuleNotFoundError as error:
        extra = "plot" if error.name == "matplotlib" else "study"
        click.echo(f"microimpact: needs {error.name}: pip install 'microimpact[{extra}]'", err=True)
        sys.exit(2)
    except (ValueError, TypeError, OSError) as error:
        click.echo(f"microimpact: {error}", err=True)
        sys.exit(2)
    except RuntimeError as error:
        # An integration that failed: no fault of the input.
        click.echo(f"microimpact: {error}", err=True)
        sys.exit(1)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(package_name="microimpact")
def commands() -> None:
    """Impact, rebound and capture of microparticles on surfaces.

    Pairs of particle and surface come from the declared tables (see 'microimpact materials'); every
    number can be replaced by an option. Input is refused with one line that says what is allowed.
    """


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


def _contact_options(command: Command) -> Command:
    options = (
        click.option("--particle", required=True, help="Material of the sphere."),
        click.option("--surface", required=True, help="Material of the surface."),
        *(click.option(f"--{name}", type=float, help=text) for name, text in _NUMBERS.items()),
        click.option(
            "--stiffness-model", default="hertz", show_default=True, help="hertz or reduced."
        ),
        click.option("--json", "as_json", is_flag=True, help="JSON in SI units; infinity is null."),
    )
    for option in reversed(options):
        command = option(command)
    return command


@commands.command("simulate")
@_contact_options
@click.option("--speed", type=float, required=True, help="Speed before impact, m/s.")
@click.option(
    "--angle", type=float, default=90.0, show_default=True, help="From the surface, degrees."
)
@click.option("--spin", type=float, default=0.0, show_default=True, help="Before impact, rad/s.")
@click.option(
    "--friction-basis",
    default="compressive",
    show_default=True,
    help="Force that supports friction: compressive, hertz or net.",
)
@click.option(
    "--tangential",
    default="rigid",
    show_default=True,
    help="Compliance along the surface: rigid, mindlin or spring.",
)
def simulate_command(
    speed: float,
    angle: float,
    spin: float,
    friction_basis: str,
    tangential: str,
    as_json: bool,
    **pair: Any,
) -> None:
    """Simulate one impact."""
    from microimpact.model.dynamics.impact import simulate

    contact, replaced = _contact(**pair)
    laws = {"friction_basis": friction_basis, "tangential": tangential}
    outcome = simulate(contact, speed, angle, spin, **laws)
    values = {name: getattr(outcome, name).item() for name in _IMPACT}
    if as_json:
        before = {"speed": speed, "angle": angle, "spin": spin, **laws}
        after = {"spin_after" if name == "spin" else name: v for name, v in values.items()}
        _print_json(_inputs(contact, replaced) | before | after)
        return
    title = (
        f"{_words(contact, replaced)}\n{speed:g} m/s at {angle:g} deg, spin {spin:g} rad/s, "
        f"friction {contact.friction:g}, supported by the {friction_basis} force"
        f"{'' if tangential == 'rigid' else f', tangential compliance {tangential}'}"
    )
    rows = [
        (label, _text(values[name], factor), unit)
        for name, (label, unit, factor) in _IMPACT.items()
    ]
    _print_table(title, ("", "value", "unit"), rows)


@commands.command("capture")
@_contact_options
def capture_command(as_json: bool, **pair: Any) -> None:
    """Find the capture velocity of a sphere, and the scales of its contact."""
    from microimpact.model.dynamics.capture import capture_velocity

    contact, replaced = _contact(**pair)
    found = float(capture_velocity(contact))
    if as_json:
        _print_json(_inputs(contact, replaced) | {"capture_velocity": found})
        return
    hertz_group, adhesion_group = contact.groups
    rows = [
        ("capture velocity", _text(found), "m/s"),
        ("velocity scale V", _text(contact.velocity_scale), "m/s"),
        ("damping group C_H", _text(hertz_group), ""),
        ("damping group C_A", _text(adhesion_group), ""),
        ("stiffness K", _text(contact.stiffness, 1e-9), "GPa"),
        ("ring force f_0", _text(contact.ring_force), "N/m"),
        ("work of adhesion w_A", _text(contact.work_of_adhesion), "J/m2"),
        ("equilibrium contact radius", _text(contact.equilibrium_contact_radius, 1e9), "nm"),
    ]
    _print_table(_words(contact, replaced), ("", "value", "unit"), rows)
    if np.isinf(found):
        click.echo("No speed rebounds: the contact is overdamped.")


@commands.command("export")
@_contact_options
@click.option(
    "--format",
    "form",
    default="c",
    show_default=True,
    help="c, csv, npz, fluent, openfoam or lammps.",
)
@click.option("-o", "--output", default=".", show_default=True, help="Folder of the files.")
@click.option(
    "--fastest", type=float, default=100.0, show_default=True, help="Fastest normal speed, m/s."
)
@click.option(
    "--tolerance", type=float, default=1e-6, show_default=True, help="Error of e and impulse."
)
@click.option("--friction-basis", default="compressive", show_default=True, help="As of simulate.")
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
    from microimpact.model.law.table import tabulate

    contact, replaced = _contact(**pair)
    checked("fastest", fastest, POSITIVE)
    law = tabulate(contact, fastest / 2.0, fastest)
    written = [str(path) for path in law.export(output, form, friction_basis, tolerance)]
    if as_json:
        asked = {"format": form, "fastest": fastest, "tolerance": tolerance}
        basis = {"friction_basis": friction_basis}
        _print_json(_inputs(contact, replaced) | asked | basis | {"files": written})
        return
    click.echo(_words(contact, replaced))
    click.echo("\n".join(written))


@commands.command("fit")
@click.argument("data")
@click.option("--unit", help="Unit of the speeds where the header says none; default m/s.")
@click.option("--sigma", type=float, help="Standard deviation of e where no column has it.")
@click.option("--confidence", type=float, default=0.95, show_default=True, help="Of intervals.")
@click.option("--plot", help="Draw data, models and interval: a .png, .svg or .pdf file.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def fit_command(
    data: str,
    unit: str | None,
    sigma: float | None,
    confidence: float,
    plot: str | None,
    as_json: bool,
) -> None:
    """Find the capture velocity from measured restitutions, by several models.

    DATA is a CSV file with the columns v, and e or V (normal speeds before and after impact), and
    optionally sigma (of e) and captured (yes or no).
    """
    from microimpact.measured.rebounds import read_rebounds
    from microimpact.model.empirical.comparison import compare_models

    measured = read_rebounds(data, unit)
    if sigma is not None and measured.sigma is not None:
        raise ValueError("sigma stands in the file; leave out --sigma")
    spread = measured.sigma if sigma is None else sigma
    found = compare_models(measured.v, measured.e, spread, confidence=confidence)
    if plot:
        from microimpact.measured.picture import draw

        draw(measured, found, plot)
    if as_json:
        numbers = ("free", "v_c", "interval", "chi_square", "criterion", "weight")
        _print_json(
            {
                "v_c": found.v_c,
                "v_c_interval": list(found.v_c_interval),
                "confidence": found.confidence,
                "sigma": found.sigma,
                "scatter_over_sigma": found.scatter,
                "warnings": list(found.warnings),
                "models": {
                    model.name: {name: getattr(model, name) for name in numbers}
                    for model in found.models
                },
            }
        )
        return
    captured = int((measured.e == 0.0).sum())
    title = f"{data}: {measured.v.size - captured} rebounds, {captured} captured"
    header = (
        "model",
        "v_c (m/s)",
        "from",
        "to",
        "free",
        "chi2",
        "AICc",
        "weight",
    )
    rows = [
        (
            model.name,
            f"{model.v_c:.4g}",
            *(f"{end:.4g}" for end in model.interval),
            str(model.free),
            "" if model.chi_square is None else f"{model.chi_square:.1f}",
            f"{model.criterion:.1f}",
            f"{model.weight:.2f}",
        )
        for model in found.models
    ]
    _print_table(title, header, rows)
    low, high = found.v_c_interval
    click.echo(
        f"v_c = {found.v_c:.4g} m/s, {100 * confidence:g} %: {low:.4g} to {high:.4g} m/s, averaged "
        "over the models by weight.\nOn condition that one of them has the shape of the true curve."
    )
    for warning in found.warnings:
        click.echo(f"Warning: {warning}.")


@commands.command("materials")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def materials_command(as_json: bool) -> None:
    """List the declared materials and pairs."""
    materials, pairs = _declared()
    properties = ("youngs_modulus", "poissons_ratio", "density")
    if as_json:
        listed = {
            name: {each: getattr(material, each) for each in properties}
            for name, material in materials.items()
        }
        declared = [{"particle": p, "surface": s} | dict(pairs[p, s]) for p, s in pairs]
        _print_json({"materials": listed, "pairs": declared})
        return
    factors = dict(zip(properties, (1e-9, 1.0, 1.0), strict=True))
    _print_table(
        "Materials",
        ("material", "Young's modulus (GPa)", "Poisson's ratio", "density (kg/m3)"),
        [
            (name, *(_text(getattr(material, each), factor) for each, factor in factors.items()))
            for name, material in materials.items()
        ],
    )
    _print_table(
        "Declared pairs (SI units)",
        ("particle", "surface", "properties"),
        [
            (*pair, ", ".join(f"{name} {value:g}" for name, value in own.items()))
            for pair, own in pairs.items()
        ],
    )


for _command in RESULTS:
    commands.add_command(_command)


def _declared() -> tuple[dict[str, Material], Mapping[tuple[str, str], Mapping[str, float]]]:
    from microimpact.model.pairs import pairs_from_rows

    materials, contacts = (
        read_declared(str(declared_file(name)), columns, numbers).rows
        for name, columns, numbers in (
            ("materials.csv", MATERIAL_COLUMNS, ("value", "low", "high")),
            ("contacts.csv", CONTACT_COLUMNS, ("value",)),
        )
    )
    return materials_from_rows(materials), pairs_from_rows(contacts)


def _contact(
    particle: str, surface: str, diameter_um: float | None, **changes: Any
) -> tuple[Contact, dict[str, float]]:
    """Return the contact, and the declared adhesion and damping that options have replaced."""
    from microimpact.model.pairs import IncompletePairError, pair_contact

    diameter = None if diameter_um is None else diameter_um * 1e-6
    materials, pairs = _declared()
    try:
        contact = pair_contact(particle, surface, materials, pairs, diameter=diameter, **changes)
    except IncompletePairError as error:
        options = [f"--{name.replace('_', '-')}" for name in error.missing]
        wanted = ", ".join("--diameter-um" if o == "--diameter" else o for o in options)
        raise ValueError(f"{error.pair}; give {wanted}{error.near}") from None
    own = pairs.get((particle, surface), {})
    if changes["ring_force"] is not None and "work_of_adhesion" in own:
        changes["work_of_adhesion"] = _inputs(contact, {})["work_of_adhesion"]
    replaced = {name: own[name] for name in _CALIBRATED if own.get(name) is not None}
    return contact, {n: v for n, v in replaced.items() if changes[n] not in {None, v}}


def _words(contact: Contact, replaced: Mapping[str, float]) -> str:
    """Return the pair with its parameters, and what of the declared contact is left."""
    title = (
        f"{contact.particle.name} on {contact.surface.name}, {contact.diameter * 1e6:g} um: "
        f"w_A = {contact.work_of_adhesion:.4g} J/m2, c_H = {contact.hertz_damping:.4g} s/m, "
        f"c_A = {contact.adhesion_damping:.4g} s/m, n = {contact.adhesion_rate_exponent:g}"
    )
    if not replaced:
        return title
    changed = ", ".join(
        f"{name} {float(getattr(contact, name)):.4g} in place of {value:.4g}"
        for name, value in replaced.items()
    )
    kept = ", ".join(name for name in _CALIBRATED[:4] if name not in replaced)
    left = f"; {kept} kept as declared" if kept else ""
    return (
        f"{title}\nNo longer the declared contact, nor what it was calibrated to: {changed}{left}."
    )


def _inputs(contact: Contact, replaced: Mapping[str, float]) -> dict[str, Any]:
    numbers = ("diameter", "ring_force", "friction", *_CALIBRATED)
    values = {name: getattr(contact, name) for name in numbers}
    return (
        {"particle": contact.particle.name, "surface": contact.surface.name}
        | {name: None if value is None else float(value) for name, value in values.items()}
        | {"stiffness_model": contact.stiffness_model, "in_place_of": dict(replaced)}
    )


def _text(value: Any, factor: float = 1.0) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value * factor:.6g}"


def _print_json(values: Mapping[str, Any]) -> None:
    """Print JSON; an infinite number, which JSON does not have, as null."""

    def plain(node: Any) -> Any:
        if isinstance(node, float) and not np.isfinite(node):
            return None
        if isinstance(node, Mapping):
            return {key: plain(child) for key, child in node.items()}
        return [plain(child) for child in node] if isinstance(node, list) else node

    click.echo(json.dumps(plain(values), indent=2, allow_nan=False))


def _print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(*columns)
    table.columns[0].no_wrap = True
    for row in rows:
        table.add_row(*row)
    click.echo(title)
    Console().print(table)


if __name__ == "__main__":
    main()
