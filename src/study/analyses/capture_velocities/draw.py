"""Figure capture_laws: capture velocity against the diameter by competing laws."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from study.figures.declaration import CAPTURE_VELOCITY, TWO_STAGES, Series, figure, stated

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

LAWS = {
    "model": Series("this model", 0),
    "jkr": Series("JKR, quasi-static", 2, line="dashed"),
    "dahneke_1971": Series("Dahneke 1971", 3, line="dashdot"),
    "brach_dunn_1992": Series("Brach and Dunn 1992 (deposition codes)", 1, line="dotted"),
    "thornton_ning_yield": Series("onset of yield, where a strength is declared", 6, thin=True),
    "printed": Series("printed capture velocity", 6),
}

PAIRS = {
    "steel-silicon, n = 0": "[[steel-silicon, n = 0.pair]], $n$ = 0",
    "steel-silicon, n = 1": "[[steel-silicon, n = 1.pair]], $n$ = 1",
    "fluorescein-molybdenum, nominal": "[[fluorescein-molybdenum, nominal.pair]]",
    "ammonium-fluorescein-mica": "[[ammonium-fluorescein-mica.pair]]",
    "polystyrene-latex-fused-silica": "[[polystyrene-latex-fused-silica.pair]]",
}


def criterion_misses(y: Curves) -> Stated:
    """The criterion is off by more than a factor of ten for some pair."""
    (table,) = y.tables.values()
    printed = table[table["series"] == "printed"]
    factors = []
    for panel, diameter, velocity in zip(*(printed.iloc[:, k] for k in (0, 3, 4)), strict=True):
        law = y("brach_dunn_1992", panel)
        at = np.interp(np.log(diameter), np.log(law.index), np.log(law))
        factors.append(np.exp(abs(at - np.log(velocity))))
    return stated(max(factors) > 10.0, most=max(factors))


@figure(
    "capture_laws",
    "Capture velocity against diameter by competing laws",
    """
        Capture velocity at normal incidence against the diameter, for constant work of adhesion
        and damping of each pair. Laws: this model; quasi-static JKR; Dahneke 1971; Brach and
        Dunn 1992 as deposition codes use it. Diamonds: printed capture velocities, at the
        diameter assumed for the pair where none is stated.
    """,
    PAIRS,
    data=("capture_law_curves",),
    equations="25",
    finding="""
        The stick criterion of deposition codes has no energy of adhesion: its capture
        velocities differ from the printed ones by factors of up to {most:.0f}.
    """,
    holds=criterion_misses,
    method="""
        This model's curve ends where spheres are captured at every speed. JKR loses only the
        energy of the snap-off. Dahneke's law has this model's energy of adhesion and its
        restitution at ten capture velocities. The law of Brach and Dunn is in El-Batsh's form:
        its constant of 0.51 has a dimension, and the pair enters only through stiffness and
        density. Where a yield strength is declared, the speed at the onset of yield is drawn:
        faster impacts are no longer elastic by this estimate. n is the rate exponent of the
        adhesion damping, whose coefficient falls with the impact speed as v^-n.
    """,
    contact=TWO_STAGES,
    tables={
        "contact_properties": "Stiffness, adhesion, damping and capture velocity of every declared contact.",
        "capture_laws": "Capture velocity of every pair by every law, and the printed one.",
    },
    height_mm=157.5,
    columns=2,
)
def draw_capture_laws(sheet: Sheet) -> None:
    """A panel per pair of the data, also of one that a changed study adds."""
    (table,) = sheet.tables.values()
    titles = {pair: PAIRS.get(pair, pair) for pair in dict.fromkeys(table["panel"])}
    # The height is declared for the rows of the shipped pairs.
    rows, usual = (-(-len(pairs) // 2) for pairs in (titles, PAIRS))
    sheet.figure.set_figheight(sheet.figure.get_figheight() * (rows / usual))
    diameter = r"Diameter $d$ ($\mu$m)"
    axes = sheet.panels(
        titles, xscale="log", yscale="log", xlabel=diameter, ylabel=CAPTURE_VELOCITY
    )
    for ax in axes:
        ax.set(xlim=(1.0, 125.0), ylim=(0.0001, 50.0))
        sheet.draw(ax, LAWS)
        _say_captured(ax, table)
    sheet.keys()


def _say_captured(ax: Axes, table: pd.DataFrame) -> None:
    """Write beside the end of this model's curve that smaller spheres never rebound."""
    rows = table[(table["panel"] == ax.get_label()) & (table["series"] == "model")]
    end, low = rows.iloc[:, 3].min(), ax.get_xlim()[0]
    if end > 3.0 * low:
        look: dict[str, Any] = {"ha": "right", "va": "center", "fontsize": "small"}
        ax.text(0.9 * end, 16.0, "captured at any speed", **look)
