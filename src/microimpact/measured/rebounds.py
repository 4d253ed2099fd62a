"""Measured rebounds from text files, data frames and mappings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from microimpact.core.arrays import FloatArray
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
    Row,
    Table,
    read_table,
)
from microimpact.model.choices import NOISE

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
    "angle": Column(units=ANGLE_UNITS),
}
# Restitutions of a code, by the cases of `microimpact.model.reference`; above `MOST` none is e.
CASES = {"case": Column(), "v": BEFORE, "e": RESTITUTION}
MOST = 2.0
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
    read: str = ""
    notes: tuple[str, ...] = ()

    def keys(self) -> tuple[str, ...]:
        """Return the names of known arguments, for ``compare_models(**rebounds)``."""
        return tuple(name for name in _ARGUMENTS if getattr(self, name) is not None)

    def __getitem__(self, name: str) -> Any:
        if name not in _ARGUMENTS:
            raise KeyError(name)
        return getattr(self, name)

    @property
    def warnings(self) -> tuple[str, ...]:
        """The notes, which are printed as warnings."""
        return self.notes

    def summary(self) -> str:
        """Rows, units and ranges of the table, in a line."""
        return self.read


def read_rebounds(
    source: Path | str | Mapping[str, Any],
    unit: str | None = None,
    *,
    size_unit: str | None = None,
    columns: Mapping[str, str] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    encoding: str | None = None,
    sigma: float | None = None,
    sigma_v: float | str | None = None,
    size_scatter: float | str | None = None,
    skip_bad_rows: bool = False,
) -> Rebounds:
    """Read measured rebounds: a text file, a data frame, or a mapping of arrays.

    Parameters
    ----------
    source
        The file, or the table, with the columns `COLUMNS`, of which v and e or V are needed; others
        are left out. Lines that begin with ``#`` or ``%`` are comments, rows without their numbers
        are skipped; ``notes`` says so. A captured sphere has ``captured`` yes, or e (or V) 0, and
        needs no ``sigma``: it takes the median one of the others.
    unit, size_unit
        Units of speeds and of sizes, where the table states none; None: SI units.
    columns
        Headers in the file by the names of `COLUMNS`: ``{"v": "Impact speed [cm/s]"}``.
    delimiter
        Between cells, a character or a name of `microimpact.measured.table.SEPARATORS`; None: the
        one that parts the header into most cells.
    decimal
        ``"."`` or ``","``; None: as the numbers are written.
    encoding
        Of the file; None: UTF-8, and Latin-1 where it is not.
    sigma, sigma_v, size_scatter
        Standard deviation of e, of v (m/s, or ``"1.5%"``) and of d (``0.07``, ``"7%"`` or
        ``"free"``) where no column has them. Where e is V/v, sigma is that at an exact v, and the
        error of v is added to it.
    skip_bad_rows
        Whether rows with a wrong number are left out, and named in ``notes``.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        With file, line, column, value and the allowed values; all bad rows are named.
    """
    table = read_table(
        source,
        COLUMNS,
        units={SPEEDS: unit, SIZES: size_unit},
        columns=columns,
        delimiter=delimiter,
        decimal=decimal,
        encoding=encoding,
    )
    _require_columns(table)
    sign = _sign(table)
    spreads = {
        "sigma": sigma,
        "sigma_v": _share("sigma_v", sigma_v),
        "size_scatter": _share("size_scatter", size_scatter),
    }
    for column, name in {"sigma": "sigma", "sigma_v": "sigma_v", "sigma_d": "size_scatter"}.items():
        if column in table.columns and spreads[name] is not None:
            raise ValueError(f"{column} stands in the file; leave out {_flag(name)}")
    impacts = _Impacts(table, sign, spreads)
    rows, notes = table.kept(impacts.of, skip_bad_rows=skip_bad_rows)
    if table.ignored:
        unused = ", ".join(map(repr, table.ignored))
        notes.insert(0, f"{table.name}: columns not used: {unused}")
    if sign < 0.0:
        notes.append(f"{table.name}: all speeds v are negative; their amounts are taken")
    arrays: dict[str, Any] = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    if size_scatter == "free":
        arrays["size_scatter"] = size_scatter
    if "sigma" in arrays:
        arrays["sigma"] = _completed(arrays["sigma"])
        if impacts.after == "V" and "sigma_v" in arrays and arrays["sigma"] is not None:
            arrays["sigma"] = _of_ratio(**arrays)
    total = arrays.pop("total")
    notes += implausible({"normal_speed": arrays["v"], "diameter": arrays.get("d")})
    if "angle" in arrays:
        notes += implausible({"angle": arrays.pop("angle").max()})
    return Rebounds(**arrays, read=_words(table, arrays, total), notes=tuple(notes))


def _require_columns(table: Table) -> None:
    """Raise ValueError if a column is missing, or two have the same thing."""
    has = table.columns
    if "v" not in has or ("e" in has) == ("V" in has):
        raise ValueError(
            f"{table.name}: the columns v and either e or V are needed, got "
            f"{', '.join(map(repr, [*has, *table.ignored]))}; other names go by "
            "--columns v=NAME,e=NAME"
        )
    if "d" in has and "radius" in has:
        raise ValueError(f"{table.name}: either d or radius must be given, got both")
    if table.units.get("sigma_d", "%") != "%" and not {"d", "radius"} & {*has}:
        raise ValueError(f"{table.name}: sigma_d needs the column d, or is in %: 'sigma_d (%)'")


def _sign(table: Table) -> float:
    """-1 if all speeds before impact are negative, as trackers write them."""
    speeds = [row.numbers["v"] for row in table.rows if "v" in row.numbers]
    return -1.0 if speeds and max(speeds) < 0.0 else 1.0


def _flag(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _share(name: str, text: float | str | None) -> tuple[float, bool] | None:
    """Spread by an option, and whether it is a share of the whole; None: to be found, or not given.

    Raises ValueError if it is neither.
    """
    if text is None or (text == "free" and name == "size_scatter"):
        return None
    number, percent, rest = str(text).partition("%")
    try:
        value = float(number + rest) * (0.01 if percent else 1.0)
    except ValueError:
        value = np.nan
    share = bool(percent) or name == "size_scatter"
    # "7" would be 700 %.
    if not 0.0 <= value < (0.5 if share else np.inf):
        allowed = "'1.5%' or a number in m/s" if name == "sigma_v" else "'7%' or 'free'"
        raise ValueError(f"{_flag(name)} must be as {allowed}, below 50 %, got {text!r}")
    return value, share


@dataclass(frozen=True, slots=True)
class _Impacts:
    """Rows of a table as impacts."""

    table: Table
    sign: float
    spreads: Mapping[str, Any]

    @property
    def after(self) -> str:
        """Column of the measurement after impact."""
        return "e" if "e" in self.table.units else "V"

    def of(self, row: Row) -> dict[str, float] | None:
        """Numbers of an impact, in SI units; None if one is missing.

        Raises ValueError if one is out of range.
        """
        said = row.cells.get("captured", "").lower()
        captured = said in _YES or row.numbers.get(self.after) == 0.0
        needless = {self.after, "sigma"} if captured else set()
        if any(name not in row.numbers for name in {*self.table.units} - needless):
            return None
        if said not in _YES | _NO | MISSING:
            raise ValueError(f"captured must be yes or no, got {row.cells['captured']!r}")
        total, v = self._speeds(row)
        built = {"v": v, "total": total}
        built |= {name: row.numbers[name] for name in ("angle",) if name in row.numbers}
        relative = self._relative("v", "sigma_v", row, total, self.spreads["sigma_v"])
        if relative is not None:
            built["sigma_v"] = relative * v
        built |= self._restitution(row, v, captured=captured)
        size = self._size(row)
        if size is not None:
            built["d"] = size
        option = self.spreads["size_scatter"]
        scatter = self._relative("d", "sigma_d", row, size or 1.0, option)
        return built if scatter is None else built | {"size_scatter": scatter}

    def _speeds(self, row: Row) -> tuple[float, float]:
        """Speed before impact, and its normal part, m/s."""
        total = self.sign * row.numbers["v"]
        if total <= 0.0:
            raise ValueError(f"v must be positive, got {row.cells['v']}")
        angle = row.numbers.get("angle", 90.0)
        if not 0.0 < angle <= 90.0:
            raise ValueError(
                f"angle must be above 0 and at most 90 degrees, got {row.cells['angle']}"
            )
        return total, total * float(np.sin(np.radians(angle)))

    def _restitution(self, row: Row, v: float, *, captured: bool) -> dict[str, float]:
        """Restitution and its sigma; nan where a captured sphere has none."""
        cell = row.cells[self.after]
        amount = row.numbers.get(self.after, 0.0)
        e = amount if self.after == "e" else abs(amount) / v
        if captured:
            if e > 0.0:
                raise ValueError(f"captured, but {self.after} is {cell}; it must be 0 or empty")
            sigma = row.numbers.get("sigma", self.spreads["sigma"]) or None
            has = sigma is not None or "sigma" in self.table.units
        else:
            sigma = row.numbers.get("sigma", self.spreads["sigma"])
            has = sigma is not None
        if sigma is not None and not 0.0 < sigma < 1.0:
            got = row.cells.get("sigma", sigma)
            raise ValueError(f"sigma must be above 0 and below 1, got {got}")
        if not 0.0 <= e <= 1.0 + NOISE * (sigma or 0.0):
            got = cell + _percent(e) if self.after == "e" else f"V/v = {e:.3g}"
            noise = f", or above by at most {NOISE:g} sigma" if has else ""
            raise ValueError(f"e must be from 0 to 1{noise}, got {got}")
        return {"e": e} | ({"sigma": np.nan if sigma is None else sigma} if has else {})

    def _size(self, row: Row) -> float | None:
        """Diameter, m; raises ValueError if it can hardly be meant."""
        name = next((name for name in ("d", "radius") if name in row.numbers), None)
        if name is None:
            return None
        size = row.numbers[name] * (2.0 if name == "radius" else 1.0)
        if size <= 0.0:
            raise ValueError(f"{name} must be positive, got {row.cells[name]}")
        if name not in self.table.stated and [*implausible({"diameter": size})]:
            low, high, *_ = PLAUSIBLE["diameter"]
            raise ValueError(
                f"{name} must be from {low:g} to {high:g} m where no unit is stated, got "
                f"{row.cells[name]}; give --size-unit"
            )
        return size

    def _relative(
        self, whole: str, name: str, row: Row, amount: float, option: tuple[float, bool] | None
    ) -> float | None:
        """Standard deviation over the whole, by its column or by an option."""
        if name in row.numbers:
            value, share = row.numbers[name], self.table.units[name] == "%"
        elif option is not None:
            value, share = option
        else:
            return None
        relative = value / (1.0 if share else amount)
        if not 0.0 <= relative < 0.5:
            got = row.cells.get(name, f"{relative:.3g} of it")
            raise ValueError(f"{name} must be from 0 to half of {whole}, got {got}")
        return relative


def _percent(e: float) -> str:
    return "; are these percent? Then the header is 'e (%)'" if 2.0 < e <= 100.0 else ""


def _completed(sigma: FloatArray) -> FloatArray | None:
    """Standard deviations, where a captured sphere has none the median one."""
    known = np.isfinite(sigma)
    return np.where(known, sigma, np.median(sigma[known])) if np.any(known) else None


def _of_ratio(
    v: FloatArray, e: FloatArray, sigma: FloatArray, sigma_v: FloatArray, **_: Any
) -> FloatArray:
    """Standard deviation of e = V/v with the error of v in it, for a fit that knows sigma_v.

    An error of v moves V/v off the curve at v by (e + v de/dv)/v of it, of which the fit has the
    second part alone. With the covariance e^2 + v d(e^2)/dv is left, here for a loss of energy that
    does not depend on the speed: the latter is then 2 (e_max^2 - e^2).
    """
    missing = np.where(e > 0.0, 2.0 * np.max(e) ** 2 - e**2, 0.0)
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
    if lacking := [name for name in CASES if name not in table.columns]:
        raise ValueError(
            f"{table.name}: the columns {', '.join(CASES)} are needed, got "
            f"{', '.join(map(repr, [*table.columns, *table.ignored]))}; no {', '.join(lacking)}"
        )

    def built(row: Row) -> tuple[str, float, float] | None:
        if {*row.numbers} < {"v", "e"}:
            return None
        (v, e), case = (row.numbers[name] for name in ("v", "e")), row.cells["case"]
        if not case:
            raise ValueError("case must be a name, got none")
        if v <= 0.0:
            raise ValueError(f"v must be positive, got {row.cells['v']}")
        if not 0.0 <= e < MOST:
            raise ValueError(f"e must be from 0 to {MOST:g}, got {row.cells['e']}{_percent(e)}")
        return case, v, e

    rows, notes = table.kept(built, skip_bad_rows=skip_bad_rows)
    cases: dict[str, list[tuple[float, float]]] = {}
    for case, v, e in rows:
        cases.setdefault(case, []).append((v, e))
    arrays = {case: np.array(pairs).T for case, pairs in cases.items()}
    return {case: (v, e) for case, (v, e) in arrays.items()}, notes
