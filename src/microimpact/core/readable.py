"""Records that print as a small table of their fields, with units."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from typing import Any, ClassVar

import numpy as np

from microimpact.core.arrays import UNIT_OF

# Arrays up to this size are printed whole.
FEW = 3


def table(rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """Return rows of cells as text, each column as wide as its widest cell.

    Parameters
    ----------
    rows
        Cells of each row.
    header
        Names of the columns, which are underlined.
    """
    lines = [tuple(row) for row in ((header, *rows) if header else rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    if header:
        lines.insert(1, tuple("-" * width for width in widths))
    return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in lines)


def precise(value: float, width: float) -> str:
    """Format a number in four digits, or in as many as show two of an interval's width."""
    if not (value and 0.0 < width < np.inf):
        return f"{value:.4g}"
    digits = int(np.floor(np.log10(abs(value))) - np.floor(np.log10(width))) + 2
    return f"{value:.{max(digits, 4)}g}"


class Readable:
    """Base of dataclasses that print as a table, and in a notebook, too.

    Fields without ``repr`` are left out, and those that are as by default.
    """

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Any]]

    def shown(self) -> dict[str, Any]:
        """Return the values of the fields that are printed."""
        values = {f.name: (getattr(self, f.name), f.default) for f in fields(self) if f.repr}
        return {
            name: value
            for name, (value, default) in values.items()
            if value is not default and (np.ndim(value) or value != default)
        }

    def summary(self) -> str:
        """Values of the fields with their units, as a table."""
        return table(_rows(self))

    def __str__(self) -> str:
        doubts = (f"Warning: {doubt}." for doubt in getattr(self, "warnings", ()))
        return "\n".join([self.summary(), *doubts])

    def __repr__(self) -> str:
        values = (f"{name}={_short(value)}" for name, value in self.shown().items())
        return f"{type(self).__name__}({', '.join(values)})"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"


def _rows(record: Readable, above: str = "") -> Iterator[tuple[str, str, str]]:
    """Names, values and units of the fields of a record and of those in it."""
    for name, value in record.shown().items():
        if isinstance(value, Readable):
            if isinstance(kind := getattr(type(value), "name", None), str):
                yield f"{above}{name}", kind, ""
            yield from _rows(value, f"{above}{name}.")
        else:
            unit = UNIT_OF.get(name, UNIT_OF.get(f"law.{name}", ""))
            yield f"{above}{name}", _words(value), unit.replace("**", "")


def _words(value: Any) -> str:
    """Value in six digits; of a long array the least and the greatest, or how many are true."""
    if isinstance(value, np.ndarray) and value.size > FEW:
        if value.dtype == bool:
            return f"yes in {np.count_nonzero(value)} of {value.size}"
        shape = " x ".join(map(str, value.shape))
        return f"{_words(value.min())} to {_words(value.max())} ({shape})"
    plain = value.tolist() if isinstance(value, np.generic | np.ndarray) else value
    if isinstance(plain, list):
        return ", ".join(map(_words, value))
    if isinstance(plain, bool):
        return "yes" if plain else "no"
    return f"{plain + 0.0:.6g}" if isinstance(plain, float) else str(plain)


def _short(value: Any) -> str:
    """Value in one word, or the shape of an array."""
    if isinstance(value, np.ndarray) and value.ndim:
        return f"<array {value.shape}>"
    if isinstance(value, np.generic | np.ndarray):
        return repr(value.item())
    if is_dataclass(value) and not isinstance(value, Readable):
        return f"<{type(value).__name__}>"
    return repr(value)
