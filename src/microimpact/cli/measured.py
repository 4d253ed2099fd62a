"""Commands about measurements: the capture velocity in them, the contacts that they admit."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.cli.contacts import contact_of, contact_options, quantiles
from microimpact.cli.output import number, patience, print_json, print_table, warn
from microimpact.model.choices import CALIBRATED
from microimpact.model.contact_laws import RING_FORCE

if TYPE_CHECKING:
    from microimpact.measured.rebounds import Rebounds
    from microimpact.model.contact import Contact
    from microimpact.model.posterior import LawDraws

# What a file may leave to options: the columns, and the options.
_SPREADS = {"sigma": "--sigma", "sigma_v": "--sigma-v", "size_scatter": "--size-scatter"}
_READ = ("unit", "columns", "delimiter", "decimal", "encoding", *_SPREADS)
SYMBOLS = dict(zip(("w_A", "c_H", "c_A", "n"), CALIBRATED[:4], strict=True))


def data_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options that say how DATA is read, as ``reading``."""
    options = (
        click.option("--unit", help="Unit of the speeds where the header says none; default m/s."),
        click.option(
            "--columns", help="Headers by the names above: 'v=Impact speed [cm/s],V=Rebound'."
        ),
        click.option("--delimiter", help="Between cells: comma, semicolon, tab, bar or space."),
        click.option("--decimal", help="Of numbers: '.' or ','."),
        click.option("--encoding", help="Of the file; default UTF-8, or else Latin-1."),
        click.option("--sigma", type=float, help="Standard deviation of e where no column has it."),
        click.option("--sigma-v", help="That of the speeds where no column has it: '1.5%' or m/s."),
        click.option("--size-scatter", help="That of the diameters: '7%', or 'free': to be found."),
    )

    @wraps(command)
    def with_reading(**options: Any) -> None:
        reading = {name: options.pop(name) for name in _READ}
        command(**options, reading=reading)

    wrapped: Callable[..., None] = with_reading
    for option in reversed(options):
        wrapped = option(wrapped)
    return wrapped


@click.command("fit")
@click.argument("data")
@data_options
@click.option("--confidence", type=float, default=0.95, show_default=True, help="Of intervals.")
@click.option(
    "--model", "models", multiple=True, help="Try the one of this name, not all; may be repeated."
)
@click.option("--plot", help="Draw data, models and interval: a .png, .svg or .pdf file.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def fit_command(
    data: str,
    reading: Mapping[str, Any],
    confidence: float,
    models: tuple[str, ...],
    plot: str | None,
    as_json: bool,
) -> None:
    """Find the capture velocity from measured restitutions, by several models.

    DATA is a text file with the columns v, and e or V (normal speeds before and after impact), and
    optionally sigma (of e), sigma_v, d (diameter), sigma_d, captured (yes or no) and angle (degrees
    from the surface; v is then the total speed). A header may have a unit: v (cm/s), sigma_v (%).
    Comments begin with # or %. Other columns are not used.
    """
    from microimpact.model.empirical.comparison import compare_models

    measured = _measured(data, **reading)
    spreads = {name: getattr(measured, name) for name in ("sigma", "sigma_v", "d", "size_scatter")}
    with patience(
        f"fitting {measured.v.size} points; with errors of speed or size this takes minutes"
    ):
        comparison = compare_models(
            measured.v, measured.e, **spreads, confidence=confidence, models=models or None
        )
    if plot:
        from microimpact.measured.picture import draw

        draw(measured, comparison, plot)
    if as_json:
        numbers = ("free", "v_c", "interval", "chi_square", "criterion", "weight")
        print_json(
            {
                "v_c": comparison.v_c,
                "v_c_interval": list(comparison.v_c_interval),
                "confidence": comparison.confidence,
                "sigma": comparison.sigma,
                "scatter_over_sigma": comparison.scatter,
                "speeds_and_sizes_exact": comparison.exact,
                "diameter": comparison.diameter,
                "size_scatter": comparison.size_scatter,
                "warnings": list(comparison.warnings),
                "models": {
                    model.name: {name: getattr(model, name) for name in numbers}
                    for model in comparison.models
                },
            }
        )
        return
    captured = int((measured.e == 0.0).sum())
    title = f"{data}: {measured.v.size - captured} rebounds, {captured} captured"
    click.echo(f"{title}\n{comparison.summary()}")
    warn(comparison.warnings)


@click.command("calibrate")
@click.argument("data", required=False)
@contact_options
@data_options
@click.option(
    "--free",
    help="By the ring force alone: parameters to be found, of w_A, c_H, c_A and n.",
)
@click.option("--draws", type=int, default=400, show_default=True, help="Contacts to be drawn.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--restitution", type=float, help="Without DATA: e at --at-speed.")
@click.option("--at-speed", type=float, help="m/s.")
@click.option("--capture-velocity", type=float, help="Without DATA: v_c, m/s.")
@click.option("-o", "--output", help="File of the contacts, for --contact of other commands.")
def calibrate_command(
    data: str | None,
    reading: Mapping[str, Any],
    free: str | None,
    draws: int,
    seed: int,
    restitution: float | None,
    at_speed: float | None,
    capture_velocity: float | None,
    output: str | None,
    as_json: bool,
    **pair: Any,
) -> None:
    """Find contacts from measured restitutions, or c_H and c_A from two numbers.

    DATA is a file as of 'microimpact fit'. The result is a sample of contacts that agree with
    the data, by several laws of contact and with their weights; predictions from it ('microimpact
    simulate --contact FILE') have a range. --free draws by the ring force alone.
    """
    from microimpact.measured.contacts import write_contacts
    from microimpact.model.calibration import two_stage
    from microimpact.model.posterior import FREE, calibrate, free_fields

    targets = _targets(data, restitution, at_speed, capture_velocity)
    names = FREE if free is None else free_fields(name.strip() for name in free.split(","))
    names = ("hertz_damping", "adhesion_damping") if targets else names
    measured = None if targets else _measured(str(data), **reading)
    # Without it all contacts fit.
    missing = [] if measured is None or measured.sigma is not None else ["--sigma or its column"]
    start = _start(pair, names, missing)
    weights, words = {RING_FORCE: 1.0}, ""
    if measured is None:
        contacts = bests = {RING_FORCE: two_stage(start, *(targets or ())).contact}
    elif free is None:
        with patience("drawing contacts by law; errors of speed or size take minutes"):
            drawn = _by_laws(start, measured, draws, seed)
        contacts, bests = dict(drawn.contacts), dict(drawn.best)
        weights = {model.name: model.weight for model in drawn.comparison.models}
        words = f"{drawn.summary()}\n"
        warn(drawn.warnings)
    else:
        if not (measured.sigma_v is None and measured.d is None and measured.size_scatter is None):
            raise ValueError(
                "--free takes speeds and sizes as exact; leave it out, or their errors"
            )
        spread: Any = measured.sigma
        with patience("drawing contacts by the ring force"):
            posterior = calibrate(
                start, measured.v, measured.e, spread, names, draws=draws, seed=seed
            )
        contacts, bests = {RING_FORCE: posterior.contact}, {RING_FORCE: posterior.best}
        words = f"{posterior.summary()}\nThe ring force is supposed to be the law.\n"
        warn(posterior.misfit.warnings)
    if output:
        write_contacts(output, contacts, bests)
    _print_contacts(contacts, bests, weights, words, output, as_json=as_json)


def _by_laws(start: Contact, measured: Rebounds, draws: int, seed: int) -> LawDraws:
    """Draws by several laws."""
    from microimpact.model.posterior import calibrate_laws

    sigma: Any = measured.sigma
    spreads = {name: getattr(measured, name) for name in ("sigma_v", "d", "size_scatter")}
    try:
        return calibrate_laws(
            start, measured.v, measured.e, sigma, **spreads, draws=draws, seed=seed
        )
    except ValueError as error:
        raise ValueError(f"{error}; with --free the ring force alone is drawn") from None


def _print_contacts(
    contacts: Mapping[str, Contact],
    bests: Mapping[str, Contact],
    weights: Mapping[str, float],
    words: str,
    output: str | None,
    *,
    as_json: bool,
) -> None:
    """Print parameters by law, and the capture velocity of all draws."""
    from microimpact.model.dynamics.capture import capture_velocity

    limits = {law: np.atleast_1d(capture_velocity(contact)) for law, contact in contacts.items()}
    best = next(iter(bests.values()))
    v_c = _range(np.concatenate([*limits.values()]), capture_velocity(best))
    by_law = {}
    for law, contact in contacts.items():
        ranges = {"v_c (m/s)": _range(limits[law], capture_velocity(bests[law]))}
        for symbol, name in (SYMBOLS if contact.law is None else {"w_A": SYMBOLS["w_A"]}).items():
            ranges[symbol] = _range(getattr(contact, name), getattr(bests[law], name))
        if contact.law is not None:
            for name, values in contact.law.parameters.items():
                best_law: Any = bests[law].law
                ranges[name] = _range(values, getattr(best_law, name))
        by_law[law] = ranges
    if as_json:
        laws = {
            law: {"weight": weights[law], "draws": limits[law].size} | ranges
            for law, ranges in by_law.items()
        }
        draws = sum(each.size for each in limits.values())
        print_json({"v_c (m/s)": v_c, "laws": laws, "draws": draws, "file": output})
        return
    title = (
        f"{best.particle.name} on {best.surface.name}, {best.diameter * 1e6:g} um, "
        f"friction {best.friction:g} (not from these data)"
    )
    rows = [("v_c (m/s)", *map(number, v_c.values()))]
    for law, ranges in by_law.items():
        rows += [
            (f"{law}: {symbol}", *map(number, numbers.values()))
            for symbol, numbers in ranges.items()
        ]
    print_table(title, ("", "best", "median", "95 % from", "to"), rows)
    click.echo(words, nl=False)
    if output:
        click.echo(f"Written: {output}")


def _targets(
    data: str | None,
    restitution: float | None,
    at_speed: float | None,
    capture_velocity: float | None,
) -> tuple[float, float, float] | None:
    """Speed, e at it and v_c, or None where data take their place."""
    numbers = {"--at-speed": at_speed, "--restitution": restitution}
    numbers["--capture-velocity"] = capture_velocity
    values = [value for value in numbers.values() if value is not None]
    if (data is None) == (not values):
        raise ValueError(f"give either DATA, or {', '.join(numbers)}")
    missing = [name for name, value in numbers.items() if value is None]
    if values and missing:
        raise ValueError(f"without DATA give {', '.join(missing)}, too")
    return (values[0], values[1], values[2]) if values else None


def _start(pair: dict[str, Any], free_fields: Sequence[str], missing: Sequence[str]) -> Contact:
    """Contact from which a search starts; numbers that it is to find need not be given."""
    if pair["file"] is None:
        for name in free_fields:
            ring_force = name == "work_of_adhesion" and pair["ring_force"] is not None
            if pair[name] is None and not ring_force:
                pair[name] = 0.1
    return contact_of(**pair, missing=missing).best


def _measured(data: str, columns: str | None, **options: Any) -> Rebounds:
    """Read measurements; options give the spreads that the file has not."""
    from microimpact.measured.rebounds import read_rebounds

    headers: dict[str, str] = {}
    for part in re.split(r",(?=\s*\w+\s*=)", columns or ""):
        name, _, header = part.partition("=")
        if columns and not (name.strip() and header.strip()):
            raise ValueError(f"--columns must be 'v=HEADER,e=HEADER', got {columns!r}")
        headers[name.strip()] = header.strip()
    stated = {name: value for name in _SPREADS if (value := options.pop(name)) is not None}
    measured = read_rebounds(data, columns=headers if columns else None, **options)
    warn(measured.notes)
    for name, text in stated.items():
        if getattr(measured, name) is not None:
            column = name.replace("size_scatter", "sigma_d")
            raise ValueError(f"{column} stands in the file; leave out {_SPREADS[name]}")
        measured = replace(measured, **{name: _spread(name, text, measured)})
    return measured


def _spread(name: str, text: str | float, measured: Rebounds) -> Any:
    """Spread (n,) by an option: a number, a share of the speeds, or of the diameters "free"."""
    if name == "size_scatter" and text == "free":
        return text
    number, percent, rest = str(text).partition("%")
    try:
        value = float(number + rest) * (0.01 if percent else 1.0)
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or (name == "size_scatter" and not percent):
        allowed = "'7%' or 'free'" if name == "size_scatter" else "'1.5%' or a number in m/s"
        raise ValueError(f"{_SPREADS[name]} must be as {allowed}, got {text!r}")
    return value * (measured.v if name == "sigma_v" and percent else np.ones(measured.v.shape))


def _range(values: Any, best: Any) -> dict[str, float]:
    low, middle, high = quantiles(values)
    return {"best": float(best), "median": middle, "low": low, "high": high}
