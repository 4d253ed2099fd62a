"""Figs. 18, 21: impulse ratio and energy loss of the simulation against the angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import (
    ENERGY_LOSS,
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


def adhesion_raises_friction(y: Curves) -> Stated:
    """The simulation begins above the rigid body, which has the friction coefficient there."""
    ratio, rigid = y("simulation"), y("rigid body")
    return stated(ratio.iloc[0] > 1.05 * rigid.max(), most=ratio.max())


@figure(
    "fig18",
    "Impulse ratio against the angle, rigid body model and simulation",
    """
        Impulse ratio against the angle of incidence for [[case.pair]], [[diameter_um:g]] µm, f
        = [[friction:g]], [[speed_m_per_s:.2f]] m/s. (a) Rigid body model and dynamic
        simulation, in which adhesion adds to the force that friction acts on. (b) The
        simulation with each of the normal forces that Coulomb's law may mean (Eq. 27).
    """,
    {"adhesion": "rigid body model and simulation", "basis": "normal force in Coulomb's law"},
    data=("fig18",),
    equations="4, 12, 13, 25, 27",
    article="""
        Measured impulse ratio of steel on silicon against the angle, with a curve of the rigid
        body model (dashed) and one of the simulation (solid).
    """,
    finding="""
        Adhesion raises the impulse ratio at shallow angles above the friction coefficient,
        from [[friction:g]] up to {most:.2f}.
    """,
    holds=adhesion_raises_friction,
    disagreement=FIG18_DISAGREEMENT,
    agreement=FIG18_AGREEMENT,
    method="The rigid body model has the restitution of the normal impact. Contact [[case]].",
    as_shipped="""
        Shaded: 95 % of the posterior contacts (figure evidence), each with its own
        friction coefficient and normal force in Coulomb's law, as far as they rebound. Circles:
        the virtual experiments of Fig. 6 on the smooth front; their agreement is by
        construction.
    """,
    contact=TWO_STAGES,
    height_mm=74.0,
)
def draw_fig18(sheet: Sheet) -> None:
    """Curves against the angle; shaded where the sphere is captured."""
    models = {
        "simulation": Series("dynamic simulation", 0),
        "rigid body": Series("rigid body model", 1, line="dashed"),
        "virtual experiment": Series("virtual experiment", 6),
        "printed plateau": Series("ends of the printed plateau", 6),
        "posterior": Series("95 % of posterior contacts,\n[[posterior.law]]", 0, band=True),
    }
    forces = {
        "compressive": Series("compressive part of the normal force", 0),
        "hertz": Series("Hertz force alone", 2, line="dashdot"),
        "net": Series("net normal force", 3, line="dotted"),
    }
    axes = sheet.panels(**OVER_ANGLE, ylabel=IMPULSE_RATIO)
    for ax, series, highest in zip(axes, (models, forces), (0.4, 0.6), strict=True):
        ax.set_ylim(0.0, highest)
        sheet.captured(ax, "capture")
        sheet.draw(ax, series)
        sheet.legend(ax, "upper right")
    sheet.keys()


def spin_is_counted_as_lost(y: Curves) -> Stated:
    """The translational loss is nowhere the smaller one."""
    excess = y("translational") - y("total")
    return stated(excess.min() > -1e-9 and excess.max() > 0.01, most=excess.max())


@figure(
    "fig21",
    "Energy loss against the angle, with and without the energy of the spin",
    """
        Energy loss, as a fraction of the initial translational energy, against the angle of
        incidence for [[case.pair]], [[diameter_um:g]] µm, f = [[friction:g]],
        [[speed_m_per_s:.2f]] m/s. Solid: loss of all kinetic energy. Dashed: loss of
        translational energy alone (T_L of Eq. 3). Grey: the energy of the spin after impact.
    """,
    {"loss": ""},
    data=("fig21",),
    equations="3, 14, 25, 27, 29",
    article="""
        Measured energy loss of steel on silicon against the angle, with two curves of the
        simulation: of the whole loss (solid) and without the energy of the final spin (dashed).
    """,
    finding="""
        A measurement of velocities overstates the loss by up to {most:.2f} of the energy,
        because that of the final spin is counted as lost.
    """,
    holds=spin_is_counted_as_lost,
    agreement=FIG21_AGREEMENT,
    method="Dynamic simulation, contact [[case]].",
    as_shipped="""
        Dotted: 95 % of the translational losses of the posterior contacts that rebound
        (figure evidence). Circles: the virtual experiments of Fig. 6 on the smooth front, whose
        loss is the translational one; their agreement is by construction.
    """,
    contact=TWO_STAGES,
    width="single",
    height_mm=65.0,
)
def draw_fig21(sheet: Sheet) -> None:
    """Losses against the angle; between the two, shaded, is the energy of spin."""
    (ax,) = sheet.panels(**OVER_ANGLE, ylim=(0.0, 0.6), ylabel=ENERGY_LOSS)
    losses = {
        "total": Series("all kinetic energy", 0),
        "translational": Series("translational energy alone", 1, line="dashed"),
        "virtual experiment": Series("virtual experiment", 6),
        "posterior": Series(
            "95 % of posterior contacts,\n[[posterior.law]]", 1, line="dotted", band=True
        ),
    }
    sheet.captured(ax, "capture")
    sheet.draw(ax, losses)
    rows = sheet.tables["fig21"]
    angle, total = rows[rows["series"] == "total"].iloc[:, 3:5].to_numpy(float).T
    moved = rows.loc[rows["series"] == "translational"].iloc[:, 4]
    spin = "energy of the final spin"
    ax.fill_between(angle, total, moved, label=spin, color="0.85", linewidth=0, zorder=0)
    sheet.legend(ax, "best")
    sheet.keys()
