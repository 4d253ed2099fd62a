"""Sobol' indices of the capture velocity beside the effects of the designed experiments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from study.figures.declaration import TWO_STAGES, figure, stated

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

FACTORS = ("$K$", "$w_A$", "$r$", r"$\zeta_A$", r"$\zeta_H$")
INDICES: dict[str, dict[str, Any]] = {
    "total index": {"marker": "o", "color": "C0"},
    "first-order index": {"marker": "o", "fillstyle": "none", "color": "C2"},
    "share of squared effects": {"marker": "D", "fillstyle": "none", "color": "C1"},
}
# Of the factors whose convergence is shown.
CONVERGENCE: dict[str, dict[str, Any]] = {
    "A": {"marker": "o", "color": "C0"},
    "B": {"marker": "s", "color": "C1"},
    "C": {"marker": "^", "color": "C2"},
    "D": {"marker": "D", "color": "C3"},
    "E": {"marker": "v", "color": "C6"},
}
# Distance of marks of the same factor.
APART = 0.2


def radius_leads(y: Curves) -> Stated:
    """The total index is largest for the radius and smallest for the damping of the material."""
    shares = [y("total index", f"realistic, steel-silicon, n = {n}") for n in (0, 1)]
    leads = all(share.idxmax() == FACTORS.index("$r$") for share in shares)
    least = max(share.iloc[-1] for share in shares)
    return stated(leads and least < 0.01)


@figure(
    "sobol",
    "Sobol' indices of the capture velocity, and effects of the designed experiments",
    """
        Shares of the variance of the capture velocity of [[cases.pair]], with
        [[confidence:.0%]] bootstrap intervals. (a-d) Total and first-order indices over the
        levels of Figs. 24 and 25, with shares of the squared effects. (e) Convergence for
        [[drawn_case]], realistic levels.
    """,
    {
        "realistic, steel-silicon, n = 0": "realistic, $n$ = 0",
        "realistic, steel-silicon, n = 1": "realistic, $n$ = 1",
        "uniform, steel-silicon, n = 0": "uniform, $n$ = 0",
        "uniform, steel-silicon, n = 1": "uniform, $n$ = 1",
        "convergence": "convergence",
    },
    data=("sobol",),
    equations="23, 24, 25",
    finding="""
        Over realistic ranges the radius has the largest share of the variance, damping of
        the material less than 1 %.
    """,
    holds=radius_leads,
    method="""
        The five factors are drawn independently: between realistic levels from lognormal
        distributions, between those of the small variation from uniform ones. n is the rate
        exponent of the adhesion damping, whose coefficient falls with the impact speed as v^-n.
        Draws without a finite capture velocity have no variance and would be left out; the
        tables count them.
    """,
    contact=TWO_STAGES,
    tables={
        "sensitivity_indices": "First and total indices of every factor, and the effects of the designed experiments.",
        "sensitivity_convergence": "Sobol' indices from fewer samples.",
    },
    height_mm=125.0,
    columns=3,
)
def draw_sobol(sheet: Sheet) -> None:
    """The abscissa counts factors, or samples in the last panel."""
    from matplotlib.ticker import LogLocator, NullLocator

    from study.figures.style import legend_above, plain_numbers

    *panels, convergence = sheet.panels()
    for ax in panels:  # none of a case that a changed run leaves out
        ax.set_visible(not sheet.take(ax, "total index").empty)
    panels = [ax for ax in panels if ax.get_visible()]
    for ax in panels:
        ax.set(xlim=(-0.5, 4.5), ylim=(-0.04, 1.0), xlabel="Factor", ylabel="Share of variance")
        for number, (name, look) in enumerate(INDICES.items()):
            rows = sheet.take(ax, name)
            _marks(ax, rows, name, {"linestyle": "none", **look}, APART * (number - 1))
        ax.set_xticks(np.arange(len(FACTORS)), FACTORS)
        ax.xaxis.set_minor_locator(NullLocator())
        ax.tick_params(axis="x", length=0)
    convergence.set(xlim=(24, 1365), ylim=(-0.04, 1.5), xlabel="Base samples", ylabel="Total index")
    convergence.set_xscale("log", base=2)
    for letter, name in zip(CONVERGENCE, FACTORS, strict=True):
        look = {"linestyle": "solid", "markersize": 3.0, "linewidth": 0.9, **CONVERGENCE[letter]}
        _marks(convergence, sheet.take(convergence, letter), name, look)
    convergence.xaxis.set_major_locator(LogLocator(base=2, subs=(1.0,)))
    plain_numbers(convergence.xaxis)
    convergence.xaxis.set_minor_locator(NullLocator())
    convergence.legend(loc="upper right", ncols=3)
    legend_above(sheet.figure, panels[:1], title="all computed")


def _marks(
    ax: Axes, rows: pd.DataFrame, label: str, look: Mapping[str, Any], shift: float = 0.0
) -> None:
    """Draw indices with their intervals; the axes grow to show them."""
    from study.figures.style import widened

    x, y = (rows.iloc[:, column].to_numpy(float) for column in (3, 4))
    bounds = rows[["y_low", "y_high"]].to_numpy(float).T
    error = None if np.isnan(bounds).any() else np.maximum(np.array([[-1], [1]]) * (bounds - y), 0)
    ax.errorbar(x + shift, y, yerr=error, label=label, clip_on=False, zorder=3, **look)
    ax.set_ylim(widened(ax.get_ylim(), rows.iloc[:, [4, 5, 6]].to_numpy(float)))
