"""Figs. 18, 21: where the results agree with the article's description, and where they do not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Remark, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.tables import ResultTables


def rise_ends_in_capture(tables: ResultTables) -> Stated:
    """The ratio rises above the rigid body, and ends at the angle of capture."""
    rows = tables("fig18")
    angle = rows("x_deg", panel="adhesion", series="capture")
    most, rigid = (
        max(rows.all("y_1", panel="adhesion", series=name)) for name in ("simulation", "rigid body")
    )
    return stated(angle > 1.0 and most > 1.1 * rigid, angle=angle, most=most)


def rise_needs_compression(tables: ResultTables) -> Stated:
    """Only without the attraction in Coulomb's law does the ratio rise at shallow angles."""
    net, compressive, hertz = (
        max(tables("fig18").all("y_1", panel="basis", series=name))
        for name in ("net", "compressive", "hertz")
    )
    rises = net < 0.9 * compressive < 0.8 * hertz
    return stated(rises, net=net, compressive=compressive, hertz=hertz)


def spin_takes_most_near_fifty(tables: ResultTables) -> Stated:
    """The two losses differ most within 5° of the printed 50°, and hardly at 85°."""
    rows = tables("fig21")
    angles = rows.all("x_deg", series="total")
    totals, moved = (rows.all("y_1", series=name) for name in ("total", "translational"))
    gaps = [high - low for low, high in zip(totals, moved, strict=True)]
    angle, most = max(zip(angles, gaps, strict=True), key=lambda pair: pair[1])
    steep = max(gap for at, gap in zip(angles, gaps, strict=True) if at >= 85.0)
    near = abs(angle - 50.0) < 5.0 and most > 10.0 * steep
    return stated(near, angle=angle, most=most, steep=steep)


FIG18_DISAGREEMENT = (
    Remark(
        "The article has the ratio grow as the angle goes to zero. The simulated sphere is "
        "captured at {angle:.1f}° and less, and the rise ends there, at {most:.2f}.",
        rise_ends_in_capture,
    ),
)
FIG18_AGREEMENT = (
    Remark(
        "The article explains the rise by the compressive stress that adhesion adds. It does "
        "depend on that: the largest ratio is {compressive:.2f} by the compressive part of the "
        "force and {hertz:.2f} by the Hertz force, but {net:.2f} by the net force.",
        rise_needs_compression,
    ),
)
FIG21_AGREEMENT = (
    Remark(
        "The two losses differ most at {angle:.0f}°, by {most:.2f}, near the 50° for which the "
        "article prints the final spin; from 85° up they differ by less than {steep:.3f}.",
        spin_takes_most_near_fifty,
    ),
)
