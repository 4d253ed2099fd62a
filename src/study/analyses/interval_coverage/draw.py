"""Figures of interval_coverage."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import NOMINAL_SPEED, TWO_STAGES, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet


@Figure(
    "coverage_of_means",
    "How often a [[level:.0%]] interval contains the mean restitution",
    """
        Share of [[experiments]] repeated virtual experiments of [[events]] events whose
        [[level:.0%]] interval contains the mean restitution: of the events that can be
        measured, and of all rebounds. Bars: 95 % intervals of the shares; line: the nominal
        level. (a) Normal incidence, phase Doppler analyser. (b) Oblique incidence, imaging.
    """,
    {"speed": "normal incidence", "angle": "oblique incidence"},
    data=("coverage_by_speed", "coverage_by_angle"),
    equations="1, 25",
    finding="""
        Where many rebounds cannot be seen, the 95 % interval of the mean misses the mean of
        all rebounds.
    """,
    method="""
        The interval contains sampling, and the error of the probe's height or of the
        target's angle. The table adds the mean over all impacts, in which captured
        particles count as zero. (a) [[case.pair]]. (b) At [[cases.smooth,
        oblique.speeds_m_per_s.0:.2f]] m/s, a smooth and a rough surface, and at
        [[cases.slow, oblique.speeds_m_per_s.0:.2f]] m/s, a smooth surface.
    """,
    as_shipped="""
        At low speed the height of the probe decides which rebounds can be seen, but the
        interval contains its error only as an error of the correction. The imaging rejects
        most slow rebounds at steep angles.
    """,
    contact=TWO_STAGES,
    height_mm=75.0,
)
def draw_coverage_of_means(sheet: Sheet) -> None:
    """Draw it (was study.figures.models.curves.draw)."""
    speed, angle = sheet.panels(ylim=(0.0, 102.0), ylabel="Intervals that contain the mean (%)")
    sheet.over_angle(angle)
    speed.set(xlim=(0.2, 1.4), xlabel=NOMINAL_SPEED)
    looks_speed = {
        "smooth, normal: events that can be measured": Series("of measurable events", 0),
        "smooth, normal: all rebounds": Series("of all rebounds", 0, open=True),
        "nominal": Series("nominal level", 6, line="dotted"),
    }
    sheet.draw(speed, looks_speed, joined=True)
    sheet.legend(speed, "center right")
    looks_angle = {
        "smooth, oblique: events that can be measured": Series("smooth, of measurable events", 0),
        "smooth, oblique: all rebounds": Series("smooth, of all rebounds", 0, open=True),
        "rough, oblique: events that can be measured": Series(
            "rough, of measurable events", 1, mark="square"
        ),
        "rough, oblique: all rebounds": Series(
            "rough, of all rebounds", 1, mark="square", open=True
        ),
        "slow, oblique: events that can be measured": Series(
            "[[cases.slow, oblique.speeds_m_per_s.0:.2f]] m/s, of measurable events",
            2,
            mark="triangle",
        ),
        "slow, oblique: all rebounds": Series(
            "[[cases.slow, oblique.speeds_m_per_s.0:.2f]] m/s, of all rebounds",
            2,
            mark="triangle",
            open=True,
        ),
        "nominal": Series("nominal level", 6, line="dotted"),
    }
    sheet.draw(angle, looks_angle, joined=True)
    sheet.legend(angle, "lower center")
    sheet.keys()
