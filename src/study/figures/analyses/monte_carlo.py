"""Figure of the Monte Carlo analysis: coefficients of a rough surface against angle."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.figures import style
from study.figures.registry import FigureSpec, PanelSpec, SeriesSpec
from study.tables import Tables

# The series that is a band only; those of a curve are its standard error.
MEASURED = "measured means"
CURVES = ("computed", "calibrated")


@style.context()
def draw(tables: Tables, spec: FigureSpec) -> Figure:
    """Draw curves in bands of standard error, and a band in which means of a few events lie."""
    table = pd.concat([tables[name] for name in spec.data], ignore_index=True)
    is_curve = table["evidence"].isin(CURVES)

    def prepare(ax: Axes, name: str) -> None:
        _draw_bands(ax, table[is_curve & (table["panel"] == name)], spec.panels[name])

    # Bounds of curves would be drawn as error bars.
    bare = style.without_bounds(table, is_curve)
    bare = bare[bare["series"] != MEASURED]
    return style.line_figure({spec.name: bare}, spec, prepare=prepare)[0]


def _draw_bands(ax: Axes, table: pd.DataFrame, panel: PanelSpec) -> None:
    for series, rows in table[table["y_low"].notna()].groupby("series", sort=False):
        spec = panel.series.get(str(series), SeriesSpec(label=str(series)))
        wide = series == MEASURED
        ax.fill_between(
            rows.iloc[:, 3],
            rows["y_low"],
            rows["y_high"],
            color="0.5" if spec.colour is None else f"C{spec.colour}",
            alpha=0.15 if wide else 0.5,
            linewidth=0,
            label=spec.label if wide else None,
        )
