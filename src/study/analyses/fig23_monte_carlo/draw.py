"""Fig. 23: Monte Carlo means of restitution and impulse ratio on a rough surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import (
    IMPULSE_RATIO,
    OVER_ANGLE,
    TWO_STAGES,
    Remark,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves, ResultTables

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


def slopes_raise_the_mean(y: Curves) -> Stated:
    """At the shallowest angle the rough mean lies above its reference, the smooth one below."""
    rough, smooth = y("equal weights", "restitution"), y("smooth", "restitution")
    angle, rise = rough.index[0], rough.iloc[0]
    return stated(rise > 0.1 and smooth[angle] < 0.0, angle=angle, rise=rise)


@figure(
    "fig23",
    "Monte Carlo analysis of impacts on a rough surface",
    """
        Monte Carlo means on a rough surface, rigid body model: (a) restitution less its value
        at [[reference_angle_deg:.0f]]°, (b) impulse ratio. Dashed: smooth surface. Solid:
        facets equally likely. Dash-dotted: facets weighted by projected area. Band: 95 % of the
        means of [[events_measured]] events. Marks: virtual experiments of Fig. 12.
    """,
    {
        "restitution": "restitution, less its value at [[reference_angle_deg:.0f]]°",
        "impulse_ratio": "impulse ratio",
    },
    data=("fig23", "fig23_points"),
    equations="12, 13, 35, 36",
    article="""
        Monte Carlo results of the rigid body model with random slopes and diameters (solid),
        and measured points with error bars and the result without randomness (dashed).
    """,
    finding="""
        Random slopes alone raise the mean restitution at {angle:.0f}° by {rise:.1f} above
        that at [[reference_angle_deg:.0f]]°; on a smooth surface it falls.
    """,
    holds=slopes_raise_the_mean,
    disagreement=DISAGREEMENT,
    method="""
        Unless their distribution is declared, slopes are normal and as wide as each weighting
        needs for the printed e = [[slope_inference.restitution:g]] at
        [[slope_inference.angle_deg:.0f]]° (table slope_inference); (a) is then calibrated at
        that angle, and (b) predicted. Only spheres that rebound from the nominal surface count.
        Off-scale means are given at the top. Standard errors of the curves are in the table
        monte_carlo.
    """,
    as_shipped="Diameter, speed and slope are drawn independently.",
    contact=TWO_STAGES,
    tables={
        "monte_carlo": "Means and standard deviations of the coefficients at every angle, by the way facets are weighted.",
        "slope_inference": "The slope that the printed restitution needs, and its uncertainty.",
    },
)
def draw_fig23(sheet: Sheet) -> None:
    """Means against the angle, on a smooth surface and on rough ones."""
    restitution, impulse_ratio = sheet.panels(**OVER_ANGLE)
    relative = sheet.fill("Relative restitution $e - e([[reference_angle_deg:.0f]]°)$")
    restitution.set(ylim=(-0.6, 1.8), ylabel=relative)
    impulse_ratio.set(ylim=(-0.1, 0.4), ylabel=IMPULSE_RATIO)
    surfaces = {
        "smooth": Series("smooth surface", 6, line="dashed"),
        "equal weights": Series("rough, facets equally likely", 0),
        "facets by area seen": Series("rough, weighted by projected area", 1, line="dashdot"),
        "measured means": Series("95 % of means of [[events_measured]] events", 0, band=True),
        "steel on Formica": Series("virtual experiments of Fig. 12", 6, open=True),
    }
    for ax in (restitution, impulse_ratio):
        sheet.draw(ax, surfaces, fixed=ax is restitution)
    sheet.keys()
