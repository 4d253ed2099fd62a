"""Figures of size_law."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import CAPTURE_VELOCITY, TWO_STAGES, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet


@Figure(
    "capture_by_size",
    "Capture velocity against the diameter, by law of contact, and the rebounds that decide",
    """
        (a) Capture velocity of [[steel-silicon, n = 0.pair]] against the diameter over
        posterior contacts, median and 5 to 95 %, by law; black: the single contacts of the
        other figures. (b) Rebounds per sieve after which the exponents of two laws differ
        by [[standard_errors:g]] standard errors.
    """,
    {"size": "capture velocity", "impacts": "rebounds per sieve that decide"},
    data=("size_law_curves", "size_law_impacts"),
    equations="25",
    finding="""
        Rebounds from two sieves tell a constant coefficient from one that falls with the
        speed, if they are seen down to little above capture.
    """,
    method="""
        The published power of the diameter is for other particles. The smaller sieve has
        [[smaller_um:g]] µm. Rebounds are spread evenly over the logarithm of the speed, up
        to [[highest_speed_in_v_c:g]] capture velocities, each with an error of
        [[noise_of_e:g]] in e; sizes within a sieve scatter by [[scatter_of_size:.0%]]. The
        error of the capture velocity is that of the Fisher information, with the plateau
        unknown and the shape of e(v) known. Of two laws the one that needs more rebounds is
        true.
    """,
    contact=TWO_STAGES,
    tables={
        "size_law_exponents": "Exponent of the diameter by law of contact, and the published one.",
        "size_law_design": "Rebounds per sieve for every pair of laws, larger sieve and lowest speed.",
    },
    height_mm=105.0,
    columns=2,
)
def draw_capture_by_size(sheet: Sheet) -> None:
    """Draw it (was study.figures.models.curves.draw)."""
    size, impacts = sheet.panels(yscale="log", xscale="log")
    size.set(xlim=(20.0, 200.0), ylim=(0.01, 1.5), xlabel="Diameter (µm)", ylabel=CAPTURE_VELOCITY)
    impacts.set(
        xlim=(50.0, 200.0),
        ylim=(10.0, 100000.0),
        xlabel="Mean diameter of the larger sieve (µm)",
        ylabel="Rebounds per sieve",
    )
    for ax in (size, impacts):
        sheet.steps(ax.xaxis, 1.0, 2.0, 5.0)
    sheet.steps(size.yaxis, 1.0, 3.0)
    sheet.steps(impacts.yaxis, 1.0)
    looks_size = {
        "ring force, n free": Series("ring force, $n$ from 0 to 2", 0),
        "ring force, n = 0": Series("ring force, $n$ = 0", 2, line="dashed"),
        "JKR, viscous": Series("JKR, viscous", 1, line="dashdot"),
        "steel-silicon, n = 0": Series("two stages, $n$ = 0", 6, line="dotted"),
        "steel-silicon, n = 1": Series("two stages, $n$ = 1", 6, line="loose dashed"),
        "published power": Series("published power", 3, line="long dashed"),
    }
    sheet.draw(size, looks_size)
    looks_impacts = {
        "ring force, n free against ring force, n = 0, from 1.2 v_c": Series(
            "$n$ free against $n$ = 0, from 1.2 $v_c$", 0
        ),
        "ring force, n free against ring force, n = 0, from 2 v_c": Series(
            "$n$ free against $n$ = 0, from 2 $v_c$", 0, line="dashed"
        ),
        "ring force, n free against JKR, viscous, from 1.2 v_c": Series(
            "$n$ free against JKR, from 1.2 $v_c$", 1, line="dashdot"
        ),
        "ring force, n free against JKR, viscous, from 2 v_c": Series(
            "$n$ free against JKR, from 2 $v_c$", 1, line="dotted"
        ),
        "ring force, n = 0 against JKR, viscous, from 1.2 v_c": Series(
            "$n$ = 0 against JKR, from 1.2 $v_c$", 2, line="long dashed"
        ),
        "ring force, n = 0 against JKR, viscous, from 2 v_c": Series(
            "$n$ = 0 against JKR, from 2 $v_c$", 2, line="loose dashed"
        ),
    }
    sheet.draw(impacts, looks_impacts)
    sheet.keys()
