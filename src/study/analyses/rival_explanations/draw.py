"""Figure rival_restitution: restitution that falls by adhesion, and by a probe alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import NORMAL_SPEED, RESTITUTION, TWO_STAGES, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def probe_looks_like_adhesion(y: Curves) -> Stated:
    """Rebounds in the probe begin among the capture velocities of both sizes."""
    cases = [f"steel-silicon, n = {n}, {d} um" for n in (0, 1) for d in (49, 75)]
    starts = [curve[curve > 0.0].index[0] for curve in map(y, cases)]
    probe = y("probe alone").index[0]
    return stated(0.8 * min(starts) < probe < max(starts), probe=probe)


@figure(
    "rival_restitution",
    "Restitution that falls by adhesion, and by a probe above the surface",
    """
        Restitution against the normal impact speed: calibrated contacts of [[cases.pair]], for
        the mean spheres of two size classes; and spheres of constant restitution
        [[restitution:.2f]] without adhesion, seen by a probe [[probe_height_mm:g]] mm above the
        surface with no correction for its height.
    """,
    {"restitution": ""},
    data=("rival_restitution",),
    equations="2.1 incident, 2.1 rebound, 25",
    finding="""
        A probe that misses slow rebounds produces an apparent capture velocity of
        {probe:.2f} m/s, as adhesion does, but one that is the same for all sizes.
    """,
    holds=probe_looks_like_adhesion,
    as_shipped="""
        Diamond: printed for oblique impact. Shaded: speeds at which the article saw pile-up.
    """,
    contact=TWO_STAGES,
    tables={
        "rival_explanations": "Printed observations by both explanations, and which of them tell the two apart.",
        "capture_evidence": "What piles, slow rebounds and energies say of the capture velocity.",
        "rival_forces": "Strength that other forces would need to hold or slow a sphere, and the reason that excludes them.",
    },
    width="single",
)
def draw_rival_restitution(sheet: Sheet) -> None:
    """Curves of both explanations."""
    (ax,) = sheet.panels(xlim=(0.0, 2.0), ylim=(0.0, 1.0), xlabel=NORMAL_SPEED, ylabel=RESTITUTION)
    explanations = {
        "steel-silicon, n = 0, 75 um": Series(
            "adhesion, 75 µm, $n$ = 0", 0, line="dashed", beside=1.1
        ),
        "steel-silicon, n = 1, 75 um": Series("adhesion, 75 µm, $n$ = 1", 1, line="dashed"),
        "steel-silicon, n = 1, 49 um": Series("adhesion, 49 µm, $n$ = 1", 1),
        "steel-silicon, n = 0, 49 um": Series(
            "adhesion, 49 µm, $n$ = 0", 0, beside=1.5, side="below"
        ),
        "probe alone": Series("probe alone, any size", 3, line="dotted"),
        "printed, oblique impact": Series("printed for oblique impact", 6),
    }
    sheet.piled_up(ax)
    sheet.draw(ax, explanations)
    sheet.legend(ax, "lower right")
    sheet.keys()
