"""Figures of campaign."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import ANGLE, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet


@Figure(
    "campaign_map",
    "All experiments of the campaign",
    """
        The virtual experiments of the campaign by particles and surface, angle of incidence
        and nominal speed (colour). At 90° the phase Doppler analyser observes, at other
        angles the imaging system. Open marks: fewer than [[stop.fewest_events]] events
        although all particles allowed were dropped.
    """,
    {"all": ""},
    data=("campaign_map",),
    finding="""
        Nearly all experiments that cannot be completed are at shallow angles and low
        speeds, where the spheres are captured.
    """,
    method="""
        The article counts its experiments and their levels (Section 2) and does not list
        them; this selection is declared. Experiments fail because nearly all spheres are
        captured or arrive outside the light sheet.
    """,
    tables={
        "campaign": "Every experiment of the campaign.",
    },
    height_mm=110.0,
)
def draw_campaign_map(sheet: Sheet) -> None:
    """Draw it (was study.figures.experiments.campaign.draw)."""
    (ax,) = sheet.panels(
        xlim=(0.0, 1.0), ylim=(0.0, 1.0), xlabel=ANGLE, ylabel="Particles and surface"
    )
    looks_ax = {
        "too few events": Series("fewer than [[stop.fewest_events]] events"),
    }
    sheet.draw(ax, looks_ax)
    sheet.keys()
