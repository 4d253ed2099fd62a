"""Fig. 23: where the results agree with the article's description, and where they do not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Remark, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.tables import ResultTables

VARIANT = "equal weights"


def exceeds_unity(tables: ResultTables) -> Stated:
    """The relative restitution is above one at 10°, and more so at 8°."""
    ten, eight = (
        tables("monte_carlo")("relative_restitution", variant=VARIANT, angle_deg=angle)
        for angle in (10, 8)
    )
    return stated(eight > ten > 1.0, ten=ten, eight=eight)


def facets_face_away(tables: ResultTables) -> Stated:
    """Many slopes drawn at 10° turn the facet away from the sphere, none at 45°."""
    ten, steep = (
        tables("monte_carlo")("facing_away_share", variant=VARIANT, angle_deg=angle)
        for angle in (10, 45)
    )
    return stated(ten > 0.05 and steep < 0.001, ten=ten)


DISAGREEMENT = (
    Remark(
        "The article says that the relative restitution increases toward unity. With facets "
        "equally likely it goes beyond, to {ten:.2f} at 10° and {eight:.2f} at 8°.",
        exceeds_unity,
    ),
    Remark(
        "The article adds a random slope to each angle of incidence. At 10°, {ten:.0%} of the "
        "slopes so drawn turn the facet away from the sphere, which cannot hit it; the article "
        "does not say what became of these.",
        facets_face_away,
    ),
)
