"""Figs. 4, 5: restitution and energy loss at normal incidence, by sieve class."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from study.analyses.fig04_05_normal_experiments import remarks
from study.figures.declaration import (
    ENERGY_LOSS,
    NORMAL_SPEED,
    RESTITUTION,
    TWO_STAGES,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

# The marks of the analyser, then all spheres that rebound, without it.
CLASSES = {
    "SST65": Series("SST65, virtual experiment", 0),
    "SST125": Series("SST125, virtual experiment", 1, open=True),
    "SST65 sieve": Series("SST65, all that rebound, [[case]]", 0),
    "SST125 sieve": Series("SST125, all that rebound, [[case]]", 1, line="dashed"),
}
# At the curves, of which two more are of the other end of the contacts.
NAMED = CLASSES | {
    "SST65 sieve": Series("SST65, [[case]]", 0, beside=1.7, side="right"),
    "SST125 sieve": Series("SST125, [[case]]", 1, line="dashed", beside=1.7, side="right"),
    "SST65 sieve, other end": Series(
        "SST65, [[other_case]]", 0, line="dotted", beside=1.4, side="below"
    ),
    "SST125 sieve, other end": Series("SST125, [[other_case]]", 1, line="dotted", beside=1.2),
}


def larger_keep_theirs(y: Curves) -> Stated:
    """The larger rebound from lower speeds; the slowest marks lie above their curves."""
    small, large = y("SST65 sieve"), y("SST125 sieve")
    overstated = [
        y(name).iloc[0] > np.interp(y(name).index[0], curve.index, curve)
        for name, curve in (("SST65", small), ("SST125", large))
    ]
    return stated(large.index[0] < small.index[0] and all(overstated))


@figure(
    "fig04",
    "Restitution at normal incidence, as a PDPA would measure it",
    """
        Restitution against the normal impact speed for [[populations]] of
        [[case.particle]] on smooth [[case.surface]]. Marks: virtual experiments with 95 %
        intervals. Curves: all spheres that rebound, without the instrument. Above about 0.5 m/s
        marks and the curves of their contact agree by construction.
    """,
    {"all": ""},
    data=("fig04",),
    equations="1, 2.1 incident, 2.1 rebound, 25",
    article="""
        Measured restitution of steel spheres of two mean diameters, 49 and 75 µm, on smooth
        silicon at normal incidence, with error bars.
    """,
    finding="""
        Larger spheres keep their restitution to lower speeds, and a probe above the surface
        overstates the slowest.
    """,
    disagreement=remarks.FIG04_DISAGREEMENT,
    agreement=remarks.FIG04_AGREEMENT,
    holds=larger_keep_theirs,
    method="""
        Particles are dropped, recorded by a virtual phase Doppler particle analyser
        [[instrument.probe_height_mm:g]] mm above the surface, paired, corrected, and averaged
        over [[stop.events]] events, or at least [[stop.fewest_events]] where rebounds are rare.
        The contact is [[case]].
    """,
    as_shipped="""
        In its name, n is the rate exponent of the adhesion damping, whose coefficient falls with
        the impact speed as v^-n.
        SST65 are the spheres of [[populations.SST65.diameter_um.low:.0f]] to
        [[populations.SST65.diameter_um.high:.0f]] µm (shaded marks), SST125 those of
        [[populations.SST125.diameter_um.low:.0f]] to
        [[populations.SST125.diameter_um.high:.0f]] µm (open marks). The slowest marks lie above
        the curves because slow rebounds do not reach the probe again. The article prints no
        level for these impacts. Grey: the speeds at which it saw particles pile up.
    """,
    contact=TWO_STAGES,
    tables={
        "normal_experiments": "Every experiment of Figs. 4 and 5, with the fates of the particles that were dropped.",
        "size_effects": "Speeds of capture, and of the fall of restitution, by size class.",
    },
    height_mm=95.0,
)
def draw_fig04(sheet: Sheet) -> None:
    """Restitution against the normal speed."""
    (ax,) = sheet.panels(xlim=(0.0, 2.1), ylim=(0.0, 1.0), xlabel=NORMAL_SPEED, ylabel=RESTITUTION)
    sheet.piled_up(ax)
    sheet.draw(ax, NAMED, fixed=True)
    sheet.legend(ax, "lower right")
    sheet.keys()


def smaller_lose_more(y: Curves) -> Stated:
    """The curve of the smaller class lies above the curve of the larger."""
    small, large = y("SST65 sieve"), y("SST125 sieve")
    more = small > np.interp(small.index, large.index, large)
    return stated(more.all() and small.max() > 0.9, most=100.0 * small.max())


@figure(
    "fig05",
    "Energy loss at normal incidence, as a PDPA would measure it",
    """
        Fraction of the kinetic energy lost, from the events of Fig. 4: [[populations]] of
        [[case.particle]] on smooth [[case.surface]]. Curves: 1 - e^2 of the mean restitution of
        the spheres that rebound, for the contact [[case]]. Agreement away from capture is by
        construction.
    """,
    {"all": ""},
    data=("fig05",),
    equations="3, 2.1 incident, 2.1 rebound, 2.3.1 normal loss, 25",
    article="Measured energy loss of the same impacts as in Fig. 4.",
    finding="""
        Near capture {most:.0f} % of the energy is lost, and the smaller spheres lose more
        at every speed.
    """,
    disagreement=remarks.FIG05_DISAGREEMENT,
    agreement=remarks.FIG05_AGREEMENT,
    holds=smaller_lose_more,
    as_shipped="""
        Filled: SST65, the smaller spheres; open: SST125. Grey: the speeds at which the article
        saw particles pile up.
    """,
    contact=TWO_STAGES,
    height_mm=85.0,
)
def draw_fig05(sheet: Sheet) -> None:
    """Energy loss against the normal speed."""
    (ax,) = sheet.panels(xlim=(0.0, 1.8), ylim=(0.4, 1.0), xlabel=NORMAL_SPEED, ylabel=ENERGY_LOSS)
    sheet.piled_up(ax)
    sheet.draw(ax, CLASSES)
    sheet.legend(ax, "upper right")
    sheet.keys()
