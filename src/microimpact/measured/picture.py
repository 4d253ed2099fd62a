"""Measured rebounds with the models that were fitted to them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from microimpact.core.files import write_file
from microimpact.measured.rebounds import Rebounds
from microimpact.model.empirical.comparison import LIGHT, Comparison

FORMATS = (".png", ".svg", ".pdf")
# Okabe and Ito, as in the figures of the study: colours that colour-blind readers tell apart.
COLOURS = ("#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#0072B2")
LINES = ("solid", "dashed", "dashdot", "dotted", (0, (1, 3)), (0, (8, 2)), (0, (5, 1, 1, 1, 1, 1)))
WIDTH_INCH, HEIGHT_INCH, POINTS = 6.9, 4.1, 400


def require_format(path: Path | str) -> None:
    """Raise ValueError if a picture is to have another ending than one of `FORMATS`."""
    if Path(path).suffix not in FORMATS:
        raise ValueError(f"plot must end in {', '.join(FORMATS)}, got {str(path)!r}")


def draw(data: Rebounds, comparison: Comparison, path: Path | str) -> None:
    """Write `picture` into a file.

    Parameters
    ----------
    data, comparison
        As of `picture`.
    path
        File to be written, of one of `FORMATS`.

    Raises
    ------
    ValueError
        If the file has another ending.
    OSError
        If it cannot be written.
    """
    require_format(path)
    write_file(path, picture(data, comparison, Path(path).suffix[1:]))


@rc_context(
    {
        "font.family": "STIXGeneral",
        "font.size": 8.5,
        "mathtext.fontset": "stix",
        "legend.frameon": False,
        "lines.linewidth": 1.2,
        "lines.markersize": 4.5,
        "figure.constrained_layout.use": True,
        "savefig.dpi": 300,
        "svg.hashsalt": "microimpact",
    }
)
def picture(data: Rebounds, comparison: Comparison, form: str) -> bytes:
    """Draw data, models, interval of v_c, and residuals of the best model.

    Parameters
    ----------
    data, comparison
        The measurements, and the models fitted to them.
    form
        One of `FORMATS`, without the point.
    """
    figure = Figure(figsize=(WIDTH_INCH, HEIGHT_INCH))
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    low, high = comparison.v_c_interval
    above.axvspan(low, high, color="0.85", label=f"$v_c$, {100 * comparison.confidence:g} %")
    above.axvline(comparison.v_c, color="0.4", linewidth=0.8)
    v = np.geomspace(max(0.8 * min(data.v.min(), comparison.v_c), 1e-9), 1.1 * data.v.max(), POINTS)
    heavy = [model for model in comparison.models if model.weight >= LIGHT][: len(LINES)]
    for model, line, colour in zip(heavy, LINES, COLOURS, strict=False):
        label = f"{model.name} (weight {model.weight:.2f})"
        above.plot(v, model.law(v), linestyle=line, color=colour, label=label)
    captured = data.e == 0.0
    points = {"linestyle": "none", "color": "#0072B2", "capsize": 2.0, "zorder": 3}
    for chosen, marker, label in ((~captured, "o", "rebounds"), (captured, "v", "captured")):
        if np.any(chosen):
            error, across = (
                None if sd is None else sd[chosen] for sd in (data.sigma, data.sigma_v)
            )
            mark = points | {"marker": marker, "label": label, "markerfacecolor": "white"}
            above.errorbar(data.v[chosen], data.e[chosen], yerr=error, xerr=across, **mark)
    missed = data.e - heavy[0].law(data.v)
    below.errorbar(data.v, missed, yerr=data.sigma, marker="o", **points)
    below.axhline(0.0, color="black", linewidth=0.8)
    above.set(
        ylabel="coefficient of restitution e",
        ylim=(-0.03, max(1.03, data.e.max() + 0.03)),
        xscale="log",
    )
    below.set(xlabel="normal speed before impact v (m/s)", ylabel="e less model")
    for write in (below.xaxis.set_major_formatter, below.xaxis.set_minor_formatter):
        write(FuncFormatter(lambda x, _: f"{x:g}"))
    above.legend(loc="lower right")
    target = io.BytesIO()
    figure.savefig(target, format=form)
    return target.getvalue()
