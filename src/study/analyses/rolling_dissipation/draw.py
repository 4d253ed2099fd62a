"""Figure rolling: rolling resistance that the models of an impact neglect."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from study.figures.declaration import OVER_ANGLE, TWO_STAGES, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


# Estimates by panel of the data: words, colour and look.
ESTIMATES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "bound": ("bound by statics", "C1", {"alpha": 0.4, "linewidth": 0}),
    "damping": ("damping of the model", "C0", {"alpha": 0.4, "linewidth": 0}),
    "impact": ("hysteresis", "C2", {"facecolor": "none", "hatch": "//////", "linewidth": 0.6}),
}


def rolling_is_negligible(y: Curves) -> Stated:
    """Both estimates of an impact stay below the limit, the bound above."""
    curves = {
        panel: [
            y(f"steel-silicon, n = {n}, {v} m/s", panel)
            for n in (0, 1)
            for v in ("0.5", "1.66", "5")
        ]
        for panel in ("bound", "impact", "damping")
    }
    limit = y("negligible", "bound").iloc[0]
    most = max(curve.max() for curve in (*curves["impact"], *curves["damping"]))
    return stated(most < limit < min(map(min, curves["bound"])), most=100.0 * most)


@figure(
    "rolling",
    "Rolling resistance neglected in an impact",
    """
        Impulse of the rolling moment that the models neglect over that of friction, against the
        angle of incidence, for [[cases.pair]], [[drawn_diameter_um:g]] µm: a bound by statics;
        hysteresis where one part of the contact closes while another opens; the model's own
        damping. Bands: all contacts and speeds. Below the dashed line: negligible.
    """,
    {"all": ""},
    data=("rolling",),
    equations="25, 27, 29",
    finding="""
        Within one impact rolling resistance is below {most:.1f} % of friction; only a bound
        by statics makes it matter.
    """,
    holds=rolling_is_negligible,
    method="""
        Statics: all pressure at the leading edge of the contact, all adhesion on its trailing
        half. Hysteresis: of the whole loss of the impact and of the whole adhesion. Damping: at
        each point of the contact. Contacts [[cases]]; speeds of [[drawn_speeds_m_per_s]] m/s,
        above capture (table rolling_dissipation).
    """,
    contact=TWO_STAGES,
    tables={
        "rolling_dissipation": "Moments of rolling over that of friction, by diameter, speed and angle.",
    },
    width="single",
    height_mm=75.0,
)
def draw_rolling(sheet: Sheet) -> None:
    """Moment of rolling, relative to friction: range over contacts and speeds."""
    (ax,) = sheet.panels(**OVER_ANGLE, yscale="log", ylim=(0.0002, 20.0))
    ax.set_ylabel("Moment of rolling over that of friction")
    (table,) = sheet.tables.values()
    x, y = table.columns[3:5]
    limit = table.loc[table["series"] == "negligible", y].iloc[0]
    for panel, (words, colour, look) in ESTIMATES.items():
        rows = table[(table["panel"] == panel) & (table["series"] != "negligible")]
        ends = rows.groupby(x)[y].agg(["min", "max"])
        ax.fill_between(ends.index, *ends.to_numpy().T, color=colour, **look)
        is_below = "hatch" in look
        at = 40.0, float(np.interp(40.0, ends.index, ends["min" if is_below else "max"]))
        gap, va = ((0, -4), "top") if is_below else ((0, 4), "bottom")
        style: dict[str, Any] = {"textcoords": "offset points", "ha": "center", "va": va}
        ax.annotate(words, at, gap, color=colour, **style)
    ax.axhline(limit, color="black", linestyle="dashed")
    ax.annotate("negligible below", (5.0, limit), (0, 3), textcoords="offset points")
