"""Figure causes: mechanisms proposed for the measured means, each alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import ANGLE, OVER_ANGLE, TWO_STAGES, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def spin_and_slopes_alone_do(y: Curves) -> Stated:
    """The ratio reaches zero with a mean spin alone, restitution one with slopes alone."""
    others = [y(f"mean 0, sd {sd}", "spin") for sd in ("0", "0.25", "0.5", "1")]
    others += [
        y(f"{cause}, {speed}") for cause in ("adhesion", "slopes") for speed in ("fast", "slow")
    ]
    spun = min(y(f"mean {mean}, sd 0.1", "spin").min() for mean in ("0.25", "0.5", "0.9"))
    smooth = max(y(cause, "spore").max() for cause in ("none", "off centre, 0.2"))
    is_spin = min(map(min, others)) > 0.0 > spun
    return stated(is_spin and y("slopes", "spore").max() > 1.0 > smooth)


@figure(
    "causes",
    "Mechanisms proposed for the measured means, each alone",
    """
        Means of virtual impacts without errors of measurement. (a) Impulse ratio
        ([[drawn_case]]) at [[spin.dropped.speed_m_per_s:.2f]] m/s with several mean spins. (b)
        Restitution at [[slope.swept.speed_m_per_s:.2f]] m/s against the spread of slopes. (c)
        Restitution of [[spore.spore.case.pair]] by slopes, by points off the centre, and as
        imaged. (d) Impulse ratio by adhesion and by slopes.
    """,
    {
        "spin": "initial spin",
        "slope": "slope of the surface",
        "spore": "shape of the particle",
        "shallow": "adhesion or slopes",
    },
    data=("causes", "causes_slope", "causes_shallow"),
    equations="1, 2, 25, 27",
    finding="""
        Of the proposed mechanisms, only a mean spin brings the impulse ratio to zero, and only
        slopes bring restitution above one.
    """,
    holds=spin_and_slopes_alone_do,
    method="In (c) error bars are of [[events]] events. (d) shows two speeds.",
    as_shipped="""
        In (a), with mean zero the mean ratio cannot fall to zero; with a mean spin it is lowest
        at steep angles. In (d) the impulse ratio by adhesion follows the normal speed, by
        slopes it does not.
    """,
    contact=TWO_STAGES,
    tables={
        "adhesion_or_roughness": "How far means of both speeds lie apart at equal normal speed, by adhesion and by slopes.",
        "formica_mechanism": "Means of [[slope.formica_steel.case.particle]] and of [[slope.formica_spore.case.particle]] on [[slope.formica_steel.case.surface]], side by side.",
        "loss_resolution": "Differences of restitution and of energy loss, alone and in units of their error bars.",
        "loss_slopes": "Where the energy loss of the rigid body falls or rises with the angle.",
        "smooth_spore": "Rebounds of smooth [[spore.spore.case.particle]] by angle.",
        "spin_needed": "The mean initial spin that a measured impulse ratio needs.",
        "spin_or_tilt": "The initial spin, or the tilt of the target, that gives the same impulse ratio.",
        "spore_comparison": "Differences of the means of [[spore.steel.case.particle]] and of [[spore.spore.case.particle]] at each angle, alone and in units of the error bars.",
        "spore_trends": "Where the means of [[spore.spore.case.particle]] rise and fall, by each supposed cause.",
        "surface_pairs": "Means on both surfaces of a pair, and their differences in units of the error bars.",
        "spin_mechanism": "Means of restitution, impulse ratio and loss by initial spin.",
        "slope_mechanism": "Means of restitution, impulse ratio and loss by the slope of the surface.",
        "spore_mechanism": "Means of [[spore.spore.case.particle]] by each supposed cause.",
    },
    height_mm=140.0,
    columns=2,
)
def draw_causes(sheet: Sheet) -> None:
    """A panel per cause: spin, slopes of the surface, shape of the particle, adhesion."""
    spin, slope, spore, shallow = sheet.panels()
    spin.set(xlim=(15.0, 90.0), xticks=(15, 30, 45, 60, 75, 90), xlabel=ANGLE)
    slope.set(xlim=(0.0, 0.25), xlabel="Standard deviation of the slope (rad)")
    spore.set(**OVER_ANGLE)
    shallow.set(xlim=(0.0, 1.2), xlabel=r"Normal speed $v \sin\alpha$ (m/s)")
    for ax, ylim in ((spin, (-0.45, 0.25)), (shallow, (0.14, 0.22))):
        ax.set(ylim=ylim, ylabel=r"Mean impulse ratio $-\mu$")
    for ax, ylim in ((slope, (0.5, 1.6)), (spore, (0.2, 2.0))):
        ax.set(ylim=ylim, ylabel="Mean measured restitution $e_m$")
        sheet.level(ax, 1.0)
    sheet.level(spin, 0.0)

    spins = {
        "mean 0, sd 0": Series("none", 6),
        "mean 0, sd 0.5": Series("mean 0, sd 0.5", 1, line="dashed"),
        "mean 0, sd 1": Series("mean 0, sd 1", 1, line="dotted"),
        "mean 0.25, sd 0.1": Series("mean 0.25", 2, line="dashdot"),
        "mean 0.9, sd 0.1": Series("mean 0.9", 2, side="below", beside=60),
    }
    for between in ("mean 0, sd 0.25", "mean 0.5, sd 0.1"):  # In the table
        sheet.take(spin, between)
    sheet.draw(spin, spins)
    sheet.legend(spin, "lower left", r"spin $r\omega/v$")

    angles = {
        "15 deg": Series("15°", 3),
        "20 deg": Series("20°", 2, line="dashed"),
        "45 deg": Series("45°", 1, line="dashdot"),
        "85 deg": Series("85°", 0, line="dotted"),
    }
    sheet.draw(slope, angles)
    sheet.legend(slope, "upper left", "angle of incidence")

    steep = "slopes of [[spore.spore.particle_slope:g]] rad"
    shapes = {
        "none": Series("smooth", 6, line="dashdot"),
        "slopes": Series(steep, 2),
        "slopes of 0.06": Series("slopes of 0.06 rad", 2, line="dashed"),
        "off centre, 0.2": Series("contact off centre, 0.2 $r$", 1, line="dotted"),
        "slopes, seen by the camera": Series(f"{steep}, as imaged", 2),
        "printed": Series("printed", 6),
    }
    sheet.draw(spore, shapes, fixed=True)
    sheet.legend(spore, "upper right")

    slow, fast = (f"[[shallow.speeds_m_per_s.{number}:.2f]] m/s" for number in (0, 1))
    causes = {
        "adhesion, fast": Series(f"adhesion, {fast}", 0),
        "adhesion, slow": Series(f"adhesion, {slow}", 4, line="dashed"),
        "slopes, fast": Series(f"slopes, {fast}", 2, line="dashdot"),
        "slopes, slow": Series(f"slopes, {slow}", 3, line="dotted"),
    }
    sheet.draw(shallow, causes)
    sheet.legend(shallow, "upper right")
    sheet.keys()
