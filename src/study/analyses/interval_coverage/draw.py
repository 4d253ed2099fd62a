"""Figure coverage_of_means: how often an interval contains the mean restitution."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import (
    NOMINAL_SPEED,
    OVER_ANGLE,
    TWO_STAGES,
    Mark,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def unseen_rebounds_bias_the_mean(y: Curves) -> Stated:
    """The intervals of some case miss the mean of all rebounds more often than not."""
    least = min(y(f"{case}: all rebounds").min() for case in ("smooth, normal", "slow, oblique"))
    return stated(least < 50.0, most=100.0 - least)


@figure(
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
        Where many rebounds cannot be seen, the [[level:.0%]] interval of the mean misses the
        mean of all rebounds in up to {most:.0f} % of the experiments.
    """,
    holds=unseen_rebounds_bias_the_mean,
    method="""
        The interval contains sampling, and the error of the probe's height or of the target's
        angle. The table adds the mean over all impacts, in which captured particles count as
        zero. (a) [[case.pair]]. (b) At [[cases.smooth, oblique.speeds_m_per_s.0:.2f]] m/s, a
        smooth and a rough surface, and at [[cases.slow, oblique.speeds_m_per_s.0:.2f]] m/s, a
        smooth surface.
    """,
    as_shipped="""
        At low speed the height of the probe decides which rebounds can be seen, but the
        interval contains its error only as an error of the correction. The imaging rejects most
        slow rebounds at steep angles.
    """,
    contact=TWO_STAGES,
    tables={
        "interval_coverage": "Share of the error bars that contain the true mean, by speed and angle.",
    },
    height_mm=75.0,
)
def draw_coverage_of_means(sheet: Sheet) -> None:
    """Coverage against the speed at normal incidence, and against the angle."""
    speed, angle = sheet.panels(ylim=(0.0, 102.0), ylabel="Intervals that contain the mean (%)")
    nominal = {"nominal": Series("nominal level", 6, line="dotted")}
    speed.set(xlim=(0.2, 1.4), xlabel=NOMINAL_SPEED)
    sheet.draw(speed, both_means("smooth, normal", "", 0) | nominal, joined=True)
    sheet.legend(speed, "center right")
    angle.set(**OVER_ANGLE)
    slow = "[[cases.slow, oblique.speeds_m_per_s.0:.2f]] m/s, "
    oblique = {
        **both_means("smooth, oblique", "smooth, ", 0),
        **both_means("rough, oblique", "rough, ", 1, "square"),
        **both_means("slow, oblique", slow, 2, "triangle"),
    }
    sheet.draw(angle, oblique | nominal, joined=True)
    sheet.legend(angle, "lower center")
    sheet.keys()


def both_means(case: str, words: str, colour: int, mark: Mark = "circle") -> dict[str, Series]:
    """Return the series of one case: the mean that can be measured, and the mean of all rebounds."""
    return {
        f"{case}: events that can be measured": Series(
            f"{words}of measurable events", colour, mark=mark
        ),
        f"{case}: all rebounds": Series(f"{words}of all rebounds", colour, mark=mark, open=True),
    }
