"""Fig. 17: where the results agree with the article's description, and where they do not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Remark, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.tables import ResultTables

FRICTIONS = "0.1", "0.15", "0.2"


def end_of_rolling(tables: ResultTables, friction: str) -> float:
    """Return the largest angle at which the impulse ratio is the friction coefficient."""
    ends = float(friction) - 1e-9, float(friction) + 1e-9
    return max(tables("fig17").all("x_deg", panel="friction", series=friction, y_1=ends))


def rolls_down_to_fifty(tables: ResultTables) -> Stated:
    """Rolling ends near the printed 50° for f = 0.15, but not for the next coefficients."""
    low, middle, high = (end_of_rolling(tables, friction) for friction in FRICTIONS)
    near = abs(middle - 50.0) < 5.0 < min(abs(low - 50.0), abs(high - 50.0))
    return stated(near, low=low, middle=middle, high=high)


AGREEMENT = (
    Remark(
        "Without spin, rolling ends near the printed 50° only for a friction coefficient near "
        "the printed 0.15: at {middle:.0f}°, against {low:.0f}° for 0.10 and {high:.0f}° for "
        "0.20. Two printed numbers thus agree.",
        rolls_down_to_fifty,
    ),
)
