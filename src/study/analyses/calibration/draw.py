"""Figure ridge: contacts that meet the two numbers printed for steel on silicon."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from study.figures.declaration import (
    NORMAL_SPEED,
    RESTITUTION,
    TWO_STAGES,
    WORK_OF_ADHESION,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def two_numbers_leave_a_range(y: Curves) -> Stated:
    """For every exponent, several works of adhesion meet both numbers."""
    works = [y(f"n = {n}").index for n in ("0", "0.5", "1")]
    least, greatest = min(w.min() for w in works), max(w.max() for w in works)
    wide = all(w.max() > 1.2 * w.min() for w in works)
    return stated(wide and greatest > 2.0 * least, least=least, greatest=greatest)


@figure(
    "ridge",
    "What two numbers leave open for [[two_stage.members.pair]]",
    """
        Contacts of [[two_stage.members.pair]] that meet e = [[two_stage.restitution:.2f]] at
        [[two_stage.speed_m_per_s:.2f]] m/s and a capture velocity of
        [[two_stage.capture_velocity_m_per_s:.2f]] m/s. (a) Largest deviation of e from its
        plateau against the work of adhesion; below the criterion e counts as constant. (b) The
        members used in the figures.
    """,
    {"ridge": "deviation from the plateau", "curves": "the members used in the figures"},
    data=("ridge", "ridge_curves"),
    equations="25",
    finding="""
        Two printed numbers do not fix a contact: works of adhesion from {least:g} to
        {greatest:g} J/m² meet both, each with a rate exponent of its own.
    """,
    holds=two_numbers_leave_a_range,
    method="""
        n is the rate exponent of the adhesion damping, whose coefficient falls with the impact
        speed as v^-n. The plateau is above [[two_stage.flat_from_m_per_s:.2f]] m/s. Curves
        begin where a solution exists. The target of e is printed for oblique impact and taken
        for normal impact.
    """,
    contact=TWO_STAGES,
    tables={
        "calibration": "Parameters of every calibrated contact, its targets and how well it meets them.",
        "calibration_family": "All contacts that meet both printed numbers, over work of adhesion and rate exponent.",
        "molybdenum_capture": "Capture velocities consistent with both printed force ratios, by diameter.",
    },
    height_mm=78.0,
)
def draw_ridge(sheet: Sheet) -> None:
    """Deviation from the plateau by work of adhesion, and two contacts that deviate little."""
    ridge, curves = sheet.panels()
    largest = sheet.fill("Largest $|e - [[two_stage.restitution:.2f]]|$")
    ridge.set(xscale="log", xlim=(0.04, 6.0), xlabel=WORK_OF_ADHESION)
    ridge.set(ylim=(0.0, 0.15), ylabel=largest)
    sheet.ticks(ridge.xaxis, (1,), decades=True)
    for name, marker, colour in (
        ("n = 0", "o", "C0"),
        ("n = 0.5", "^", "C2"),
        ("n = 1", "s", "C1"),
    ):
        rows = sheet.take(ridge, name)
        look: dict[str, Any] = {"marker": marker, "color": colour, "linewidth": 0.6}
        ridge.plot(rows.iloc[:, 3], rows.iloc[:, 4], label=sheet.fill(name), **look)
    sheet.draw(ridge, {"criterion": Series("criterion", 6, line="dotted")})
    sheet.legend(ridge, "upper right")
    curves.set(xlim=(0.0, 3.2), ylim=(0.0, 1.0), xlabel=NORMAL_SPEED, ylabel=RESTITUTION)
    members = {
        "steel-silicon, n = 0": Series("n = 0", 0),
        "steel-silicon, n = 1": Series("n = 1", 1, line="dashed"),
        "targets": Series("_targets", 6),
    }
    sheet.draw(curves, members)
    sheet.legend(curves, "lower right")
    sheet.keys()
