"""Commands about measurements: the capture velocity in them, the contacts that they admit."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from microimpact.cli.options import Pair, contact_options, flags, quantiles
from microimpact.cli.output import (
    Command,
    echo,
    number,
    option,
    patience,
    print_json,
    print_table,
    warn,
)
from microimpact.core.files import require_writable, write_file
from microimpact.core.plausible import implausible
from microimpact.model.choices import CALIBRATED
from microimpact.model.contact_laws import RING_FORCE

if TYPE_CHECKING:
    from microimpact.measured.rebounds import Rebounds
    from microimpact.model.contact import Contact
    from microimpact.model.empirical.classes import Classes
    from microimpact.model.empirical.comparison import Comparison

SYMBOLS = dict(zip(("w_A", "c_H", "c_A", "n"), CALIBRATED[:4], strict=True))
# First values of what a calibration finds.
DAMPING = dict.fromkeys(("hertz_damping", "adhesion_damping"), 0.1)
BY_DATA = DAMPING | {"work_of_adhesion": 0.1, "adhesion_rate_exponent": 0.0}

TABLE = {
    "--unit": "Of speeds, where the table states none; default m/s.",
    "--size-unit": "Of lengths, where the table states none: um, mm, ...; default m, of x, y px.",
    "--columns": "Headers by the names above: 'v=Impact speed [cm/s],V=Rebound'.",
    "--delimiter": "Between cells: comma, semicolon, tab, bar or space.",
    "--decimal": "Of numbers: '.' or ','.",
    "--skip-bad-rows": "Leave out rows with a wrong number, and name them.",
}
RECORDS = {
    "--fps": "Of tracks: frames per second.",
    "--um-per-px": "Size of a pixel, um.",
    "--wall": "Its direction: degrees from the horizontal, two points 'x1,y1,x2,y2', or find.",
    "--tilt": "Standard deviation of this direction, degrees; default 0.",
    "--gravity": "down (default), or none, as of beams.",
    "--y": "Direction in which y grows: down (default) or up.",
    "--drag": "Of heights in air: density of the sphere, kg/m3; default vacuum.",
    "--sigma-h": "Standard deviation of heights, um.",
    "--sigma-t": "Standard deviation of the clock, us.",
}
SPREADS = {
    "--sigma": "Standard deviation of e, if no column gives it.",
    "--sigma-v": "Standard deviation of the speeds, if no column gives it: '1.5%' or in m/s.",
    "--size-scatter": "That of the diameters: '7%', or 'free': to be found.",
}
CLASSES = {
    "--classes": "v_c by class: a column ('batch', 'd'), or bins of d in its unit: 'd=20,40'."
}
FLOATS = ("--sigma", "--fps", "--um-per-px", "--tilt", "--drag", "--sigma-h", "--sigma-t")


def table_options(words: Mapping[str, str]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the options that say how a table is read, as ``reading``.

    Parameters
    ----------
    words
        Help by option.
    """
    types: dict[str, dict[str, Any]] = {
        **{flag: {"type": float} for flag in FLOATS},
        "--skip-bad-rows": {"is_flag": True},
    }

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def with_reading(**options: Any) -> None:
            names = [flag[2:].replace("-", "_") for flag in words]
            reading = {name: options.pop(name) for name in names}
            columns = _headers(reading["columns"])
            command(**options, reading=reading | {"columns": columns})

        wrapped: Callable[..., None] = with_reading
        for flag in reversed([*words]):
            wrapped = option("Data", flag, help=words[flag], **types.get(flag, {}))(wrapped)
        return wrapped

    return decorate


def _headers(columns: str | None) -> dict[str, str]:
    """Headers by the names of columns."""
    headers: dict[str, str] = {}
    for part in re.split(r",(?=\s*\w+\s*=)", columns) if columns else ():
        name, _, header = part.partition("=")
        if not (name.strip() and header.strip()):
            raise ValueError(f"--columns must be 'v=HEADER,e=HEADER', got {columns!r}")
        headers[name.strip()] = header.strip()
    return headers


@click.command("reduce", cls=Command, short_help="Rebounds from tracks, heights or bounce times.")
@click.argument("data")
@table_options({name: TABLE[name] for name in TABLE if name != "--unit"} | RECORDS)
@click.option("-o", "--output", help="CSV of the rebounds, for 'microimpact fit'; else printed.")
def reduce_command(data: str, reading: Mapping[str, Any], output: str | None) -> None:
    """Reduce records of cameras and clocks to rebounds, with the errors of e and v.

    DATA is a text file of tracks (columns frame or t, x, y, optionally track and d or radius), of
    heights (h0 and h1, of drop and rebound, optionally d) or of times (t alone, the bounces of one
    sphere). Files of TrackMate, Tracker, trackpy, DLTdv, MOSAIC and ImageJ are read as they are.
    A track that cannot be used has a row with the reason.
    """
    import csv
    import io

    from microimpact.measured.records import read_records

    if output:
        require_writable(output)
    records = read_records(data, **reading)
    warn(records.notes)
    columns = records.reduced.columns
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(columns)
    rows.writerows(zip(*([_cell(x) for x in column] for column in columns.values()), strict=True))
    if output:
        write_file(output, text.getvalue())
    echo(text.getvalue() if not output else f"{records.read}\nWritten: {output}", nl=bool(output))
    if not output:
        echo(records.read, err=True)
    if not np.any(records.reduced.used):
        raise ValueError(f"no impact can be used: {records.read}")


def _cell(value: Any) -> str:
    """Write a number in seven digits, nothing where there is none."""
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.7g}"
    return str(value)


@click.command("fit", cls=Command, short_help="Capture velocity from measured restitutions.")
@click.argument("data")
@table_options(TABLE | SPREADS | CLASSES)
@click.option("--confidence", type=float, default=0.95, show_default=True, help="Of intervals.")
@click.option("--model", "models", multiple=True, help="Fit only this model; may be repeated.")
@click.option("--tails", help="Of the scatter of e: degrees of freedom of Student's t, or 'free'.")
@click.option("--plot", help="Draw data, models and interval: a .png, .svg or .pdf file.")
@click.option("--report", help="Folder of a page with data, models, picture and warnings.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON in SI units.")
def fit_command(
    data: str,
    reading: Mapping[str, Any],
    confidence: float,
    models: tuple[str, ...],
    tails: str | None,
    plot: str | None,
    report: str | None,
    as_json: bool,
) -> None:
    """Find the capture velocity from measured restitutions, by several models.

    DATA is a text file with the columns v, and e or V (normal speeds before and after impact), and
    optionally sigma (of e), sigma_v, d (diameter) or radius, sigma_d, captured (yes or no) and
    angle (degrees from the surface; v is then the total speed). A header may have a unit: v (cm/s),
    sigma_v (%). Comments begin with # or %. Other columns are not used.
    """
    options: dict[str, Any] = {"confidence": confidence, "models": models or None}
    options["tails"] = _tails(tails)
    _require_outputs(plot, report)
    measured = _measured(data, reading)
    if plot and measured.classes is not None:
        raise ValueError("--classes makes several fits: leave out --plot; --report draws each")
    fit = _fitted(measured, options)
    if plot:
        from microimpact.measured.picture import draw

        draw(measured, fit, plot)
    if report:
        from microimpact.measured.report import write_report

        write_report(report, measured, fit, shlex.join(["microimpact", *sys.argv[1:]]))
    if as_json:
        numbers = _numbers(fit) if measured.classes is None else _numbers_by_class(fit)
        print_json({"read": measured.read, **numbers})
        return
    echo(f"{measured.read}\n{fit.summary()}")
    if report:
        echo(f"Written: {report}")
    warn(fit.warnings)


def _require_outputs(plot: str | None, report: str | None) -> None:
    """Refuse outputs that cannot be written, or lack a package, before the fit."""
    if plot:
        from microimpact.measured.picture import require_format

        require_format(plot)
        require_writable(plot)
    if report:
        from microimpact.measured.report import PAGE

        require_writable(Path(report) / PAGE)


def _fitted(measured: Rebounds, options: Mapping[str, Any]) -> Any:
    """Models of all data, or of each class."""
    from microimpact.model.empirical.classes import compare_classes
    from microimpact.model.empirical.comparison import compare_models

    with patience(f"fitting {measured.v.size} points"):
        if measured.classes is not None:
            return compare_classes(measured.classes, **measured, **options)
        comparison = compare_models(**measured, **options)
    warn(implausible({"capture_velocity": comparison.v_c}))
    return comparison


def _tails(text: str | None) -> float | str | None:
    """Degrees of freedom, or ``"free"``."""
    try:
        return text if text in {None, "free"} else float(text)
    except ValueError:
        raise ValueError(
            f"--tails must be degrees of freedom, 1 or more, or free, got {text!r}"
        ) from None


def _numbers_by_class(fit: Classes) -> dict[str, Any]:
    """Numbers of all classes, as JSON has them."""
    by_class = {
        name: {"not_computed": str(each)} if isinstance(each, ValueError) else _numbers(each)
        for name, each in fit.compared.items()
    }
    laws = {name: {"exponent": n, "mean_weight": w} for name, (n, w) in fit.laws.items()}
    exponent = {"exponent": fit.exponent, "exponent_interval": fit.exponent_interval}
    return {"classes": by_class, **exponent, "laws": laws}


def _numbers(comparison: Comparison) -> dict[str, Any]:
    """Numbers of a comparison, as JSON has them."""
    numbers = ("free", "v_c", "interval", "chi_square", "criterion", "weight", "size_exponent")
    return {
        "v_c": comparison.v_c,
        "v_c_interval": list(comparison.v_c_interval),
        "confidence": comparison.confidence,
        "sigma": comparison.sigma,
        "scatter_over_sigma": comparison.scatter,
        "tails": comparison.tails,
        "speeds_and_sizes_exact": comparison.exact,
        "diameter": comparison.diameter,
        "size_scatter": comparison.size_scatter,
        "warnings": list(comparison.warnings),
        "models": {
            model.name: {name: getattr(model, name) for name in numbers}
            for model in comparison.models
        },
    }


@click.command("calibrate", cls=Command, short_help="Contacts that measured restitutions admit.")
@click.argument("data", required=False)
@table_options(TABLE | SPREADS)
@click.option("--draws", type=int, default=400, show_default=True, help="Contacts to be drawn.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--laws", help="Only these, parted by commas; 'edge JKR' is not among all.")
@click.option("--restitution", type=float, help="Without DATA: e at --at-speed.")
@click.option("--at-speed", type=float, help="m/s.")
@click.option("--capture-velocity", type=float, help="Without DATA: v_c, m/s.")
@click.option("-o", "--output", help="File of the contacts, for --contact of other commands.")
@contact_options
def calibrate_command(
    data: str | None,
    reading: Mapping[str, Any],
    draws: int,
    seed: int,
    laws: str | None,
    restitution: float | None,
    at_speed: float | None,
    capture_velocity: float | None,
    output: str | None,
    as_json: bool,
    pair: Pair,
) -> None:
    """Find contacts from measured restitutions, or c_H and c_A from two numbers.

    DATA is a file as of 'microimpact fit'. The result is a sample of contacts that agree with
    the data, by several laws of contact and with their weights; predictions from it ('microimpact
    simulate --contact FILE') have a range.
    """
    from microimpact.measured.contacts import write_contacts
    from microimpact.model.calibration import two_stage
    from microimpact.model.posterior import calibrate_laws

    targets = {"--at-speed": at_speed, "--restitution": restitution}
    targets["--capture-velocity"] = capture_velocity
    values = [value for value in targets.values() if value is not None]
    missing = [name for name, value in targets.items() if value is None]
    if (data is None) == (not values):
        raise ValueError(f"give either DATA, or {', '.join(targets)}")
    if data is None and missing:
        raise ValueError(f"without DATA give {', '.join(missing)}, too")
    if output:
        require_writable(output)
    if data is None:
        contact = two_stage(pair.contact(DAMPING).best, *values).contact
        contacts = bests = {RING_FORCE: contact}
        _print_contacts(contacts, bests, {RING_FORCE: 1.0}, "", as_json=as_json, file=output)
    else:
        measured = _measured(data, reading)
        start = _bodies(pair)
        options: dict[str, Any] = {"draws": draws, "seed": seed}
        options |= {"laws": [law.strip() for law in laws.split(",")]} if laws else {}
        with patience("fitting every law, then drawing contacts") as say:
            drawn = calibrate_laws(start, **measured, **options, progress=say)
        contacts, bests = dict(drawn.contacts), dict(drawn.best)
        weights = {model.name: model.weight for model in drawn.comparison.models}
        _print_contacts(contacts, bests, weights, measured.read, as_json=as_json, file=output)
        if not as_json:
            echo(drawn.summary())
        warn((*implausible({"capture_velocity": drawn.comparison.v_c}), *drawn.warnings))
    if output:
        write_contacts(output, contacts, bests)
        if not as_json:
            echo(f"Written: {output}")


def _bodies(pair: Pair) -> Contact:
    """Contact without the numbers that data decide; raises ValueError if options have them."""
    excess = [name for name in (*BY_DATA, "ring_force") if name in pair.numbers]
    excess += ["law"] if pair.law else []
    if excess and pair.file is None:
        raise ValueError(f"DATA find adhesion, damping and law; leave out {flags(excess)}")
    return pair.contact(BY_DATA).best


def _print_contacts(
    contacts: Mapping[str, Contact],
    bests: Mapping[str, Contact],
    weights: Mapping[str, float],
    read: str,
    *,
    as_json: bool,
    file: str | None,
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
        numbers = {"v_c (m/s)": v_c, "laws": laws, "draws": draws, "file": file}
        print_json({"read": read, **numbers} if read else numbers)
        return
    if read:
        echo(read)
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


def _measured(data: str, reading: Mapping[str, Any]) -> Rebounds:
    """Read measurements, and warn of doubtful ones."""
    from microimpact.measured.rebounds import read_rebounds

    measured = read_rebounds(data, **reading)
    warn(measured.notes)
    return measured


def _range(values: Any, best: Any) -> dict[str, float]:
    low, middle, high = quantiles(values)
    return {"best": float(best), "median": middle, "low": low, "high": high}
