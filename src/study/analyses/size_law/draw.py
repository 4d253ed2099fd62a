"""Figure capture_by_size: capture velocity against the diameter, and rebounds that decide."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import (
    CAPTURE_VELOCITY,
    STEEL_LAWS,
    TWO_STAGES,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

# Two laws: how the rebounds that tell them apart are named, and where.
COMPARED = {
    "ring force, n free against ring force, n = 0": Series(
        "$n$ free, or $n$ = 0", 6, beside=100, side="left"
    ),
    "ring force, n free against JKR, viscous": Series(
        "$n$ free, or JKR", 6, line="dashed", beside=62, side="right"
    ),
    "ring force, n = 0 against JKR, viscous": Series(
        "$n$ = 0, or JKR", 6, line="dashdot", beside=67, side="right"
    ),
}


def rebounds_decide(y: Curves) -> Stated:
    """At the best size of the larger sieve the hardest pair of laws is separated."""
    import pandas as pd

    needed = pd.concat([y(laws) for laws in COMPARED], axis=1).max(axis=1)
    return stated(needed.min() < 1000.0, rebounds=needed.min(), larger=float(str(needed.idxmin())))


@figure(
    "capture_by_size",
    "Capture velocity against the diameter, by law of contact, and the rebounds that decide",
    """
        (a) Capture velocity of [[steel-silicon, n = 0.pair]] against the diameter over
        posterior contacts, median and 95 % interval, by law; black: the single contacts of the
        other figures. (b) Rebounds per sieve after which the exponents of two laws differ by
        [[standard_errors:g]] standard errors, measured down to 1.2 capture velocities.
    """,
    {"size": "capture velocity", "impacts": "rebounds per sieve that decide"},
    data=("size_law_curves", "size_law_impacts"),
    equations="25",
    finding="""
        About {rebounds:.0f} rebounds from each of two sieves, of [[smaller_um:g]] and
        {larger:.0f} µm, measured down to 1.2 capture velocities, decide between the three
        laws.
    """,
    holds=rebounds_decide,
    method="""
        The published power of the diameter is for other particles. The smaller sieve has
        [[smaller_um:g]] µm. Rebounds are spread evenly over the logarithm of the speed, up to
        [[highest_speed_in_v_c:g]] capture velocities, each with an error of [[noise_of_e:g]] in
        e; sizes within a sieve scatter by [[scatter_of_size:.0%]]. The error of the capture
        velocity is that of the Fisher information, with the plateau unknown and the shape of
        e(v) known. For each pair of laws the harder case is drawn, whichever law is true.
    """,
    as_shipped="Measured down to 2 capture velocities, 3 to 5 times as many are needed.",
    contact=TWO_STAGES,
    tables={
        "size_law_exponents": "Exponent of the diameter by law of contact, and the published one.",
        "size_law_design": "Rebounds per sieve for every pair of laws, larger sieve and lowest speed.",
    },
    height_mm=105.0,
    columns=2,
)
def draw_capture_by_size(sheet: Sheet) -> None:
    """Capture velocity of each law, and rebounds that tell two laws apart."""
    size, impacts = sheet.panels(yscale="log", xscale="log")
    size.set(xlim=(20.0, 200.0), ylim=(0.01, 1.5), xlabel="Diameter (µm)", ylabel=CAPTURE_VELOCITY)
    impacts.set(xlim=(50.0, 200.0), xlabel="Mean diameter of the larger sieve (µm)")
    impacts.set(ylim=(10.0, 100000.0), ylabel="Rebounds per sieve")
    for ax in (size, impacts):
        sheet.ticks(ax.xaxis, (1, 2, 5), decades=True)
    sheet.ticks(size.yaxis, (1, 3), decades=True)
    sheet.ticks(impacts.yaxis, (1,), decades=True)
    published = {
        "published power": Series("published power", 3, line="dotted", beside=170, side="left")
    }
    sheet.draw(size, STEEL_LAWS | published)
    sheet.draw(impacts, COMPARED, fixed=True)
    sheet.keys()
