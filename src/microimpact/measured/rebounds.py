"""Measured rebounds from text files, data frames and mappings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray, ObjectArray, Range, checked
from microimpact.core.plausible import PLAUSIBLE, implausible
from microimpact.core.readable import Readable
from microimpact.measured.table import (
    ANGLE_UNITS,
    MISSING,
    SHARE_UNITS,
    SIZE_UNITS,
    SIZES,
    SPEED_UNITS,
    SPEEDS,
    Column,
    Table,
    read_table,
)
from microimpact.model.choices import NOISE
from microimpact.model.empirical.data import Places

BEFORE = Column(
    units=SPEED_UNITS,
    kind=SPEEDS,
    names=(
        *(
            "velocity",
            "speed",
            "U",
            "u",
            "v_in",
            "vin",
            "v_i",
            "vi",
            "v_n",
            "vn",
            "v_0",
            "v0",
            "u_in",
        ),
        *("v_impact", "u_impact", "impact_velocity", "impact_speed", "incident_velocity"),
        *("normal_speed", "normal_velocity", "v_incident", "incoming_velocity"),
    ),
)
RESTITUTION = Column(
    units=SHARE_UNITS,
    names=("cor", "restitution", "coefficient_of_restitution", "e_n", "en"),
)
# Normal speeds before and after impact; coefficient of restitution; standard deviations of e, of v
# and of the diameter d; angle of incidence from the surface, with which v is the total speed.
COLUMNS = {
    "v": BEFORE,
    "e": RESTITUTION,
    "V": Column(
        units=SPEED_UNITS,
        kind=SPEEDS,
        names=(
            *("v_out", "vout", "v_r", "v_rebound", "u_out", "u_rebound", "rebound_velocity"),
            *("rebound_speed", "outgoing_velocity", "v_reb"),
        ),
    ),
    "sigma": Column(units=SHARE_UNITS, names=("sigma_e", "e_sd", "sd_e", "e_std", "std_e")),
    "sigma_v": Column(units=SPEED_UNITS | {"%": 1e-2}, kind=SPEEDS, names=("sd_v", "std_v")),
    "d": Column(units=SIZE_UNITS, kind=SIZES, names=("D", "diameter", "d_p", "dp")),
    "radius": Column(units=SIZE_UNITS, kind=SIZES, names=("R", "r", "r_p", "rp")),
    "sigma_d": Column(units=SIZE_UNITS | {"%": 1e-2}, kind=SIZES, names=("sd_d", "std_d")),
    "captured": Column(),
    "class": Column(),
    "angle": Column(units=ANGLE_UNITS),
}
# Restitutions of a code, by the cases of `microimpact.model.reference`; above `MOST` none is e.
CASES = {"case": Column(), "v": BEFORE, "e": RESTITUTION}
MOST = 2.0
# V and e v agree to this share of v, that of rounded numbers.
AGREEING = 0.01
# A standard deviation is below this share of the whole.
HALF = 0.5
_YES, _NO = {"yes", "true", "1", "captured"}, {"no", "false", "0", "rebound"}
# What the functions of fits take.
_ARGUMENTS = ("v", "e", "sigma", "sigma_v", "d", "size_scatter")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Rebounds(Readable):
    """Measured normal impacts; a mapping of the arguments of fits.

    Attributes
    ----------
    v, e
        Normal speeds before impact, m/s, and coefficients of restitution, 0 where captured, (n,).
    sigma, sigma_v
        Standard deviations of e, and of v in m/s, (n,); None: not known.
    d
        Diameters, m, (n,); None: not known.
    size_scatter
        Relative standard deviations of the diameters (n,); ``"free"``: one for all, to be found.
    classes
        Names of the classes (n,); None: no classes were asked for.
    read
        What was read, in a line.
    notes
        What was left out of the file or is doubtful, a sentence each.

    Examples
    --------
    >>> data = read_rebounds("mine.csv")
    >>> compare_models(**data)
    """

    v: FloatArray
    e: FloatArray
    sigma: FloatArray | None = None
    sigma_v: FloatArray | None = None
    d: FloatArray | None = None
    size_scatter: FloatArray | Literal["free"] | None = None
    classes: ObjectArray | None = None
    read: str = ""
    notes: tuple[str, ...] = ()

    def keys(self) -> tuple[str, ...]:
        """Return the names of known arguments, for ``compare_models(**rebounds)``."""
        return tuple(name for name in _ARGUMENTS if getattr(self, name) is not None)

    def __getitem__(self, name: str) -> Any:
        if name not in _ARGUMENTS:
            raise KeyError(name)
        return getattr(self, name)

    def select(self, rows: Places) -> Rebounds:
        """Return some of the rows.

        Parameters
        ----------
        rows
            Their numbers, (m,).
        """
        arrays = {f.name: getattr(self, f.name) for f in fields(self)}
        parts: dict[str, Any] = {
            name: x[rows] for name, x in arrays.items() if isinstance(x, np.ndarray)
        }
        return replace(self, **parts)

    @property
    def warnings(self) -> tuple[str, ...]:
        """The notes, which are printed as warnings."""
        return self.notes

    def summary(self) -> str:
        """Rows, units and ranges of the table, in a line."""
        return self.read


# Numbers of rows that are left out may be any.
@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def read_rebounds(
    source: Path | str | Mapping[str, Any],
    unit: str | None = None,
    *,
    size_unit: str | None = None,
    columns: Mapping[str, str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    sigma: float | None = None,
    sigma_v: float | str | None = None,
    size_scatter: float | str | None = None,
    classes: str | None = None,
    skip_bad_rows: bool = False,
) -> Rebounds:
    """Read measured rebounds: a text file, a data frame, or a mapping of arrays.

    Parameters
    ----------
    source
        The file (UTF-8, UTF-16 or Latin-1), or the table, with the columns `COLUMNS`, of which v
        and e or V are needed (both must agree); others are left out. Lines that begin with ``#`` or
        ``%`` are comments, rows without their numbers are skipped; ``notes`` says so. A captured
        sphere has ``captured`` yes, or e (or V) 0, and needs no ``sigma``: it takes the median one
        of the others.
    unit, size_unit
        Units of speeds and of sizes, where the table states none; None: SI units.
    columns
        Headers in the file by the names of `COLUMNS`: ``{"v": "Impact speed [cm/s]"}``.
    delimiter
        Between cells, a character or a name of `microimpact.measured.table.SEPARATORS`; None: the
        one that parts the header into most cells.
    decimal
        ``"."`` or ``","``; None: as the numbers are written.
    sigma, sigma_v, size_scatter
        Standard deviation of e, of v (m/s, or ``"1.5%"``) and of d (``0.07``, ``"7%"`` or
        ``"free"``) where no column has them. With V alone sigma is that at an exact v, and the
        error of v is added to it; with e and V it has this error, and their covariance is added.
    classes
        Column whose values are the classes, or bins of d or radius in the unit of the column:
        ``"batch"``, ``"d"``, ``"d=20,40,80"``.
    skip_bad_rows
        Whether rows with a wrong number are left out, and named in ``notes``.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        With file, line, column, value and the allowed values; all bad rows are named.
    """
    by, _, bins = (classes or "").partition("=")
    sized = by in {"d", "radius"}
    table = read_table(
        source,
        {name: column for name, column in COLUMNS.items() if by or name != "class"},
        units={SPEEDS: unit, SIZES: size_unit},
        columns={**(columns or {}), **({"class": by} if by and not sized else {})},
        delimiter=delimiter,
        decimal=decimal,
    )
    _require_columns(table)
    options = {"sigma": sigma, "sigma_v": sigma_v, "sigma_d": size_scatter}
    for column, option in options.items():
        if option is not None and column in table.cells:
            name = column.replace("sigma_d", "size_scatter")
            raise ValueError(f"{column} stands in the file; leave out {_flag(name)}")
    notes = [*table.unused]
    total, v = _speeds(table, notes)
    after = "e" if "e" in table.cells else "V"
    captured = _captured(table, after)
    arrays: dict[str, Any] = {
        "v": v,
        "total": total,
        **_restitutions(table, v, after, captured, sigma),
    }
    if (relative := _relative(table, "v", total, "sigma_v", sigma_v)) is not None:
        arrays["sigma_v"] = v * relative
    size = _sizes(table)
    scatter = _relative(table, "d", size, "sigma_d", size_scatter)
    arrays |= {k: x for k, x in {"d": size, "size_scatter": scatter}.items() if x is not None}
    lacking = np.any([np.isnan(x) & ~captured for x in table.numbers.values()], axis=0)
    needed = [x for k, x in table.numbers.items() if k not in {"e", "V", "sigma"}]
    lacking |= np.any([np.isnan(x) for x in needed], axis=0)
    if classes:
        arrays["classes"] = names = _classes(table, by, bins)
        lacking |= names == ""
    rows, others = table.kept(lacking, skip_bad_rows=skip_bad_rows)
    kept: dict[str, Any] = {name: np.array(x[rows]) for name, x in arrays.items()}
    if "sigma" in kept:
        known = kept["sigma"][np.isfinite(kept["sigma"])]
        median = np.median(known) if known.size else 1.0  # no sphere rebounds
        kept["sigma"] = np.where(np.isfinite(kept["sigma"]), kept["sigma"], median)
        if "V" in table.cells and "sigma_v" in kept:
            kept["sigma"] = _of_ratio(**kept, exact=after == "V")
    total = kept.pop("total")
    notes += [*others, *implausible({"normal_speed": kept["v"], "diameter": kept.get("d")})]
    if "angle" in table.numbers:
        notes += implausible({"angle": table.numbers["angle"][rows].max()})
    if size_scatter == "free":
        kept["size_scatter"] = size_scatter
    return Rebounds(**kept, read=_words(table, kept, total), notes=tuple(notes))


def _require_columns(table: Table) -> None:
    """Raise ValueError if a column is missing, or two have the same thing."""
    has = table.cells
    if "v" not in has or not {"e", "V"} & {*has}:
        raise ValueError(
            f"{table.name}: the columns v and e or V are needed, got "
            f"{', '.join(map(repr, [*has, *table.ignored]))}; other names go by "
            "--columns v=NAME,e=NAME"
        )
    if "d" in has and "radius" in has:
        raise ValueError(f"{table.name}: either d or radius must be given, got both")
    if table.units.get("sigma_d", "%") != "%" and not {"d", "radius"} & {*has}:
        raise ValueError(f"{table.name}: sigma_d needs the column d, or is in %: 'sigma_d (%)'")


def _speeds(table: Table, notes: list[str]) -> tuple[FloatArray, FloatArray]:
    """Speeds before impact, and their normal parts, m/s, (n,)."""
    total, normal = table.numbers["v"], np.ones(len(table.where))
    if np.all(total[np.isfinite(total)] < 0.0):  # as trackers write them
        total = -total
        notes.append(f"{table.name}: all speeds v are negative; their amounts are taken")
    table.require("v", total > 0.0, "positive")
    if "angle" in table.numbers:
        angle = table.numbers["angle"]
        table.require("angle", (angle > 0.0) & (angle <= 90.0), "above 0 and at most 90 degrees")
        normal = np.sin(np.radians(angle))
    return total, total * normal


def _captured(table: Table, after: str) -> BoolArray:
    """Captured spheres (n,): said to be, or with e or V of 0."""
    captured: BoolArray = np.equal(table.numbers[after], 0.0)
    for i, cell in enumerate(table.cells.get("captured", ())):
        if cell.lower() in _YES:
            captured[i] = True
        elif cell.lower() not in _NO | MISSING:
            table.bad.setdefault(i, f"captured must be yes or no, got {cell!r}")
    table.require(
        after, ~captured | (table.numbers[after] == 0.0), "0 or empty for a captured sphere"
    )
    return captured


def _restitutions(
    table: Table, v: FloatArray, after: str, captured: BoolArray, option: float | None
) -> dict[str, FloatArray]:
    """Restitutions and their sigma (n,), nan where a captured sphere has none."""
    measured = table.numbers[after]
    e = np.where(captured, 0.0, measured if after == "e" else np.abs(measured) / v)
    sigma = table.numbers.get("sigma")
    if sigma is not None:
        sigma = np.where(captured & (sigma == 0.0), np.nan, sigma)
        good = np.isnan(sigma) | ((sigma > 0.0) & (sigma < 1.0))
        table.require("sigma", good, "above 0 and below 1")
    elif option is not None:
        number = float(checked("sigma", option, Range(lower=0.0, upper=1.0)))
        sigma = np.full(v.size, number)
    noise = np.zeros(v.size) if sigma is None else NOISE * np.nan_to_num(sigma)
    noisy = "" if sigma is None else f", or above by at most {NOISE:g} sigma"
    allowed, words = f"at most v{noisy}", [f"V/v = {x:.3g}" for x in e]
    if after == "e":
        allowed = f"from 0 to 1{noisy}"
        words = [cell + _percent(x) for cell, x in zip(table.cells["e"], e, strict=True)]
    good = np.isnan(e) | ((e >= 0.0) & (e <= 1.0 + noise))
    table.require(after, good, allowed, words)
    if after == "e" and "V" in table.cells:
        rebound = np.abs(table.numbers["V"])
        good = np.isnan(e) | (np.abs(rebound - e * v) <= AGREEING * v)
        table.require("V", good, "e times the normal speed")
    return {"e": e} if sigma is None else {"e": e, "sigma": sigma}


def _sizes(table: Table) -> FloatArray | None:
    """Diameters (n,), m; those that can hardly be meant are bad."""
    name = next((name for name in ("d", "radius") if name in table.numbers), None)
    if name is None:
        return None
    table.require(name, table.numbers[name] > 0.0, "positive")
    size = table.numbers[name] * (2.0 if name == "radius" else 1.0)
    if name not in table.stated:
        low, high, *_ = PLAUSIBLE["diameter"]
        allowed = f"from {low:g} to {high:g} m where no unit is stated"
        words = [f"{cell}; give --size-unit" for cell in table.cells[name]]
        table.require(name, (size >= low) & (size <= high), allowed, words)
    return size


def _classes(table: Table, by: str, bins: str) -> ObjectArray:
    """Names of the classes (n,); empty where a row is in none."""
    if "class" in table.cells:
        if bins:
            raise ValueError(f"--classes: bins are of d or radius, got {by}={bins}")
        return np.array(table.cells["class"], dtype=object)
    if by not in table.numbers:
        raise ValueError(f"{table.name}: --classes {by} needs the column {by}")
    unit = table.units[by]
    size = table.numbers[by] / SIZE_UNITS[unit]
    if not bins:
        return np.array(["" if np.isnan(x) else f"{x:.6g} {unit}" for x in size], dtype=object)
    try:
        edges = [float(edge) for edge in bins.split(",")]
    except ValueError:
        edges = []
    if len(edges) < 2 or not np.all(np.diff(edges) > 0.0):
        raise ValueError(f"--classes must be as d=20,40,80, in ascending order, got {by}={bins}")
    names = ["", *(f"{low:g} to {high:g} {unit}" for low, high in pairwise(edges)), ""]
    return np.array(names, dtype=object)[np.searchsorted(edges, size, side="right")]


def _relative(
    table: Table, whole: str, values: FloatArray | None, name: str, option: float | str | None
) -> FloatArray | None:
    """Standard deviations over the whole (n,), by their column or by an option."""
    allowed = f"from 0 to half of {whole}"
    if name in table.numbers:
        spread = table.numbers[name]
        relative = spread if table.units[name] == "%" or values is None else spread / values
        table.require(name, (relative >= 0.0) & (relative < HALF), allowed)
        return relative
    if option is None or (option == "free" and name == "sigma_d"):
        return None
    digits, percent, rest = str(option).partition("%")
    try:
        amount = float(digits + rest) * (0.01 if percent else 1.0)
    except ValueError:
        amount = np.nan
    share = bool(percent) or name == "sigma_d"
    if not 0.0 <= amount < (HALF if share else np.inf):
        flag = _flag(name.replace("sigma_d", "size_scatter"))
        form = "'1.5%' or a number in m/s" if name == "sigma_v" else "'7%' or 'free'"
        raise ValueError(f"{flag} must be as {form}, below 50 %, got {option!r}")
    if share or values is None:
        return np.full(len(table.where), amount)
    table.require(whole, amount / values < HALF, f"above twice {name}")
    return amount / values


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _percent(e: float) -> str:
    return "; are these percent? Then the header is 'e (%)'" if 2.0 < e <= 100.0 else ""


def _of_ratio(
    v: FloatArray, e: FloatArray, sigma: FloatArray, sigma_v: FloatArray, *, exact: bool, **_: Any
) -> FloatArray:
    """Standard deviation of e = V/v with its share of the error of v, for a fit that knows sigma_v.

    An error of v moves V/v off the curve at v by (e + v de/dv)/v of it, of which the fit has the
    second part alone. Where sigma is that at an ``exact`` v, e^2 is left, and the covariance
    v d(e^2)/dv in any case, here for a loss of energy that does not depend on the speed: it is
    then 2 (e_max^2 - e^2).
    """
    missing = 2.0 * (np.max(e) ** 2 - e**2) + (e**2 if exact else 0.0)
    missing = np.where(e > 0.0, missing, 0.0)
    return np.asarray(np.sqrt(sigma**2 + (sigma_v / v) ** 2 * missing))


def _words(table: Table, arrays: Mapping[str, Any], total: FloatArray) -> str:
    """Rows, units and ranges of the table, in a line."""
    v, e, d = arrays["v"], arrays["e"], arrays.get("d")
    unit = table.units["v"] + ("" if "v" in table.stated else ", which is not stated")
    angles = "v times the sine of the angle" if np.any(v != total) else "no angles"
    sizes = "no sizes" if d is None else f"diameters {1e6 * d.min():.4g} to {1e6 * d.max():.4g} um"
    return (
        f"{table.name}: {v.size} rows, {np.count_nonzero(e == 0.0)} captured; v in {unit}; "
        f"normal speeds {v.min():.4g} to {v.max():.4g} m/s ({angles}); {sizes}"
    )


def read_cases(
    source: Path | str | Mapping[str, Any],
    unit: str | None = None,
    *,
    skip_bad_rows: bool = False,
    **reading: Any,
) -> tuple[dict[str, tuple[FloatArray, FloatArray]], list[str]]:
    """Read restitutions that a code computed: a table with the columns `CASES`.

    Parameters
    ----------
    source, unit, skip_bad_rows, **reading
        As of `read_rebounds`.

    Returns
    -------
    cases
        Normal speeds in m/s and restitutions, (n,) each, by the name of the case.
    notes
        What was left out, a sentence each.

    Raises
    ------
    OSError, ValueError
        As of `read_rebounds`.
    """
    table = read_table(source, CASES, units={SPEEDS: unit}, **reading)
    if lacking := [name for name in CASES if name not in table.cells]:
        raise ValueError(
            f"{table.name}: the columns {', '.join(CASES)} are needed, got "
            f"{', '.join(map(repr, [*table.cells, *table.ignored]))}; no {', '.join(lacking)}"
        )
    v, e = (table.numbers[name] for name in ("v", "e"))
    table.require("v", v > 0.0, "positive")
    words = [cell + _percent(x) for cell, x in zip(table.cells["e"], e, strict=True)]
    table.require("e", (e >= 0.0) & (e < MOST), f"from 0 to {MOST:g}", words)
    names = np.array(table.cells["case"])
    rows, notes = table.kept(np.isnan(v) | np.isnan(e) | (names == ""), skip_bad_rows=skip_bad_rows)
    cases = {name: rows & (names == name) for name in dict.fromkeys(names[rows].tolist())}
    return {name: (v[which], e[which]) for name, which in cases.items()}, notes
