"""Fig. 17: impulse ratio for Coulomb friction in the rigid body model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import IMPULSE_RATIO, OVER_ANGLE, Remark, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves, ResultTables

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


def slides_then_rolls(y: Curves) -> Stated:
    """Without spin the ratio is f, then falls to zero; with spin it does not end at zero."""
    slides = all(y(f, "friction").iloc[0] == float(f) for f in ("0.05", "0.1", "0.15", "0.2"))
    ends = {spin: abs(y(spin, "spin").iloc[-1]) for spin in ("-0.4", "-0.2", "0", "0.2", "0.4")}
    return stated(slides and ends.pop("0") < 1e-9 and min(ends.values()) > 0.01)


@figure(
    "fig17",
    "Impulse ratio for Coulomb friction in the rigid body model",
    """
        Impulse ratio against the angle of incidence at e = [[restitution:.2f]], rigid body
        model. (a) Without spin, for several friction coefficients f: sliding spheres have the
        ratio f, rolling ones follow one curve. (b) With an initial spin at f =
        [[spin_friction:.2f]]; r omega / v is positive in the sense of rolling.
    """,
    {
        "friction": "no initial spin, friction coefficient $f$",
        "spin": "initial spin, $f$ = [[spin_friction:.2f]]",
    },
    data=("fig17",),
    equations="4, 12, 13",
    article="""
        The impulse ratio that the rigid body model gives for Coulomb friction, against the
        angle of incidence.
    """,
    finding="""
        A sphere without spin slides at shallow angles and rolls at steep ones; spin shifts
        the rolling line, so that friction does not vanish at 90°.
    """,
    holds=slides_then_rolls,
    agreement=AGREEMENT,
    height_mm=74.0,
)
def draw_fig17(sheet: Sheet) -> None:
    """Impulse ratio by friction coefficient, and by spin before impact."""
    rows = sheet.tables["fig17"].query("panel == 'friction' and evidence == 'computed'")
    names = rows["series"].unique()
    coefficients = {
        f: Series(f"$f$ = {float(f):.2f}", number, beside=10) for number, f in enumerate(names)
    }
    # The name of the uppermost curve stands above it.
    limits = -0.2, 1.25 * max(map(float, names))
    friction, spin = sheet.panels(**OVER_ANGLE, ylim=limits, ylabel=IMPULSE_RATIO)
    for ax in (friction, spin):
        sheet.level(ax, 0.0)
    coefficients["impulse_ratio_normal_incidence_no_spin"] = Series(r"$\mu$ = 0 at 90°", 6)
    sheet.draw(friction, coefficients)
    sheet.legend(friction, "lower left")
    spins = {
        "-0.4": Series("$-$0.4", 0, line="dashed"),
        "-0.2": Series("$-$0.2", 5, line="dotted"),
        "0": Series("0", 2),
        "0.2": Series("0.2", 4, line="dashdot"),
        "0.4": Series("0.4", 1, line="dashdot", beside=45, side="left"),
    }
    sheet.draw(spin, spins)
    sheet.legend(spin, "lower left", r"$r\omega/v$ before impact")
    sheet.keys()
