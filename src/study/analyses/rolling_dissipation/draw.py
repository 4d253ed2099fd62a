"""Figure rolling: rolling resistance that the models of an impact neglect."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import OVER_ANGLE, TWO_STAGES, Figure, Series, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def rolling_is_negligible(y: Curves) -> Stated:
    """Both estimates of an impact stay below the limit, the bound above."""
    contacts = [f"steel-silicon, n = {n}, {v} m/s" for n in (0, 1) for v in ("0.5", "1.66", "5")]
    curves = {
        panel: [y(name, panel) for name in contacts] for panel in ("bound", "impact", "damping")
    }
    limit = y("negligible", "bound").iloc[0]
    most = max(curve.max() for curve in (*curves["impact"], *curves["damping"]))
    return stated(most < limit < min(map(min, curves["bound"])), most=100.0 * most)


@Figure(
    "rolling",
    "Rolling resistance neglected in an impact",
    """
        Impulse of the rolling moment that the models neglect over that of friction, against the
        angle of incidence, for [[cases.pair]], [[drawn_diameter_um:g]] µm. (a) Bound by
        statics. (b) Hysteresis only where one part of the contact closes while another opens.
        (c) The model's own damping. Below the black, dashed line: negligible.
    """,
    {
        "bound": "upper bound (statics)",
        "impact": "hysteresis in an impact",
        "damping": "damping of the model",
    },
    data=("rolling",),
    equations="25, 27, 29",
    finding="""
        Within one impact rolling resistance is below {most:.1f} % of friction; only a bound
        by statics makes it matter.
    """,
    holds=rolling_is_negligible,
    method="""
        (a) All pressure at the leading edge of the contact, all adhesion on its trailing half.
        (b) Hysteresis of the whole loss of the impact and of the whole adhesion. (c) At each
        point of the contact. n is the rate exponent of the adhesion damping, whose coefficient
        falls with the impact speed as v^-n. Curves begin above capture.
    """,
    contact=TWO_STAGES,
    tables={
        "rolling_dissipation": "Moments of rolling over that of friction, by diameter, speed and angle.",
    },
    height_mm=75.0,
)
def draw_rolling(sheet: Sheet) -> None:
    """Moment of rolling over moment of friction against the angle, by each estimate."""
    contacts = {
        "steel-silicon, n = 0, 0.5 m/s": Series("$n$ = 0, 0.5 m/s", 0, line="dotted"),
        "steel-silicon, n = 1, 0.5 m/s": Series("$n$ = 1, 0.5 m/s", 1, line="dashdotdot"),
        "steel-silicon, n = 0, 1.66 m/s": Series("$n$ = 0, 1.66 m/s", 0),
        "steel-silicon, n = 1, 1.66 m/s": Series("$n$ = 1, 1.66 m/s", 1, line="dashed"),
        "steel-silicon, n = 0, 5 m/s": Series("$n$ = 0, 5 m/s", 0, line="long dashed"),
        "steel-silicon, n = 1, 5 m/s": Series("$n$ = 1, 5 m/s", 1, line="dashdot"),
        "negligible": Series("negligible below", 6, line="loose dashed"),
    }
    for ax in sheet.panels(**OVER_ANGLE, yscale="log", ylabel="Rolling / friction moment"):
        ax.set(xticks=(0, 30, 60, 90), ylim=(0.0001, 20.0))
        sheet.draw(ax, contacts)
    sheet.keys()
