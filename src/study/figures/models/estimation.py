"""Figures of estimated parameters: the family of steel on silicon, and fitted restitution."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec, SeriesSpec
from study.tables import Tables

# Series of the capture velocity that a fit finds.
FOUND = ", v_c of the fit"
# Name of a member of the family, as the study gives it.
_MEMBER = re.compile(r"(?P<family>n = [\d.]+), w = (?P<work>[\d.]+) J/m2")


@style.context()
def draw_ridge(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw how flat e is over the family against work of adhesion, and the members drawn."""
    panels = spec.panels | {"curves": _named_members(spec.panels, tables["ridge_curves"])}
    members = tables["ridge"][tables["ridge"]["evidence"] == "calibrated"]
    look: dict[str, Any] = {"markersize": 3.0, "zorder": 4, "label": "members computed"}

    def prepare(ax: Axes, name: str) -> None:
        if name == "ridge":
            ax.plot(members.iloc[:, 3], members.iloc[:, 4], "k.", **look)

    return style.line_figure(tables, replace(spec, panels=panels), prepare=prepare)[0]


def _named_members(panels: Mapping[str, PanelSpec], curves: pd.DataFrame) -> PanelSpec:
    """Return the panel of the curves with each member in the colour and line of its family."""
    families = panels["ridge"].series
    members = {}
    for name in curves["series"].unique():
        match = _MEMBER.fullmatch(str(name))
        if match:
            label = f"$n$ = {match['family'][4:]}, $w_A$ = {match['work']} J/m$^2$"
            family = families.get(match["family"], SeriesSpec(label=label))
            members[str(name)] = replace(family, label=label)
    return replace(panels["curves"], series=members | panels["curves"].series)


@style.context()
def draw_fits(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw simulated restitution with its fits, and the printed capture velocities.

    The legend says of each fit which capture velocity it finds: where its curve begins.
    """
    (table,) = tables.values()
    is_found = table["series"].str.endswith(FOUND)
    limits = dict(zip(table["series"].str.removesuffix(FOUND), table.iloc[:, 3], strict=True))
    panels = {
        name: replace(
            panel,
            series={
                series: replace(entry, label=f"{entry.label}: $v_c$ = {limits[fitted]:.3g} m/s")
                if (fitted := series.removesuffix(", fit")) != series and fitted in limits
                else entry
                for series, entry in panel.series.items()
            },
        )
        for name, panel in spec.panels.items()
    }
    drawn = dict.fromkeys(tables, table[~is_found])
    return style.line_figure(drawn, replace(spec, panels=panels))[0]
