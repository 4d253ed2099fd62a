"""Figure pile_up_onset: spheres that end on the target by one impact, and by many."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import TWO_STAGES, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def bounces_pile_up(y: Curves) -> Stated:
    """By repeated bounces half of the spheres stay at twice the speed, at least."""
    shares = y("printed, first impact"), y("printed, in the end")
    first, end = (share[share >= 0.5].index.max() for share in shares)
    return stated(end > 2.0 * first, first=first, end=end)


@figure(
    "pile_up_onset",
    "Spheres that end on the target, by one impact and by repeated bounces",
    """
        Share of spheres (contact [[case]]) that rest on a target of [[drawn_radius_mm:.0f]] mm
        radius with slopes of [[drawn_slope_deg:.0f]]°, against the nominal speed: captured at
        their first impact, and at rest in the end, for three contacts with the same restitution
        at high speed. Shaded: speeds at which the article saw spheres pile up.
    """,
    {"all": ""},
    data=("pile_up_onset",),
    equations="25",
    finding="""
        Half of the spheres end on the target up to {end:.2f} m/s by repeated bounces, but
        only up to {first:.2f} m/s by their first impact: a pile does not show the capture
        velocity.
    """,
    holds=bounces_pile_up,
    method="""
        Spheres that rebound lose speed at every bounce and are captured on the target unless
        they leave it before.
    """,
    contact=TWO_STAGES,
    tables={
        "pile_up": "Share of spheres that end on the target, by speed, slope and radius of the target.",
        "pile_up_onsets": "Speeds below which given shares of the spheres stay on the target.",
    },
    width="single",
    height_mm=75.0,
)
def draw_pile_up_onset(sheet: Sheet) -> None:
    """Shares in the end as marks, at the first impact as curves."""
    (ax,) = sheet.panels(xlim=(0.0, 2.1), xlabel="Nominal drop speed (m/s)")
    ax.set(ylim=(0.0, 1.05), ylabel="Share of spheres on the target")
    lower = "[[other_capture_velocity_m_per_s:g]] m/s"
    contacts = {
        "printed, in the end": Series("printed, in the end", 0),
        "printed, first impact": Series("printed, at first impact", 0),
        "posterior, in the end": Series("posterior, in the end", 1, mark="square", open=True),
        "posterior, first impact": Series("posterior, at first impact", 1, line="dotted"),
        "lower, in the end": Series(f"{lower}, in the end", 2, mark="triangle", open=True),
        "lower, first impact": Series(f"{lower}, at first impact", 2, line="dashed"),
    }
    sheet.piled_up(ax)
    sheet.draw(ax, contacts)
    sheet.legend(ax, "upper right", "capture velocity, and which share")
    sheet.keys()
