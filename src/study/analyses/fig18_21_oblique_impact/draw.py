"""Figures of fig18_21_oblique_impact."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import ENERGY_LOSS, IMPULSE_RATIO, TWO_STAGES, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet


@Figure(
    "fig18",
    "Impulse ratio against the angle, rigid body model and simulation",
    """
        Impulse ratio against the angle of incidence for [[case.pair]], [[diameter_um:g]]
        µm, f = [[friction:g]], [[speed_m_per_s:.2f]] m/s. (a) Rigid body model and dynamic
        simulation, in which adhesion adds to the force that friction acts on. (b) The
        simulation with each of three normal forces in Coulomb's law: compressive part,
        Hertz force alone, and net force (Eq. 27).
    """,
    {"adhesion": "rigid body model and simulation", "basis": "normal force in Coulomb's law"},
    data=("fig18",),
    equations="4, 12, 13, 25, 27",
    article="""
        Measured impulse ratio of steel on silicon against the angle, with a curve of the
        rigid body model (dashed) and one of the simulation (solid).
    """,
    finding="Adhesion raises the impulse ratio above the friction coefficient at shallow angles.",
    method="The rigid body model has the restitution of the normal impact. Contact [[case]].",
    as_shipped="""
        Shaded: 5 to 95 % of the posterior contacts (figure evidence), each with its own
        friction coefficient and normal force in Coulomb's law, as far as they rebound.
        Circles: the virtual experiments of Fig. 6 on the smooth front; their agreement is
        by construction.
    """,
    contact=TWO_STAGES,
    height_mm=74.0,
)
def draw_fig18(sheet: Sheet) -> None:
    """Curves against the angle; shaded where the sphere is captured."""
    adhesion, basis = sheet.panels(ylabel=IMPULSE_RATIO)
    sheet.over_angle(adhesion, basis)
    adhesion.set(ylim=(0.0, 0.4))
    basis.set(ylim=(0.0, 0.6))
    looks_adhesion = {
        "simulation": Series("dynamic simulation", 0),
        "rigid body": Series("rigid body model", 1, line="dashed"),
        "virtual experiment": Series("virtual experiment", 6),
        "printed plateau": Series("ends of the printed plateau", 6),
        "posterior": Series("drawn contacts, 5 to 95 %", 0, band=True),
    }
    sheet.draw(adhesion, looks_adhesion, omit="capture")
    sheet.legend(adhesion, "upper right")
    looks_basis = {
        "compressive": Series("compressive part of the normal force", 0),
        "hertz": Series("Hertz force alone", 2, line="dashdot"),
        "net": Series("net normal force", 3, line="dotted"),
    }
    sheet.draw(basis, looks_basis, omit="capture")
    sheet.legend(basis, "upper right")
    sheet.keys()
    for ax in (adhesion, basis):
        sheet.captured(ax, sheet.abscissae(ax, "capture").max())


@Figure(
    "fig21",
    "Energy loss against the angle, with and without the energy of the spin",
    """
        Energy loss, as a fraction of the initial translational energy, against the angle of
        incidence for [[case.pair]], [[diameter_um:g]] µm, f = [[friction:g]],
        [[speed_m_per_s:.2f]] m/s. Solid: loss of all kinetic energy. Dashed: loss of
        translational energy alone (T_L of Eq. 3). Grey: the energy of the spin after
        impact.
    """,
    {"loss": ""},
    data=("fig21",),
    equations="3, 14 total, 25, 27, 29",
    article="""
        Measured energy loss of steel on silicon against the angle, with two curves of the
        simulation: of the whole loss (solid) and without the energy of the final spin
        (dashed).
    """,
    finding="""
        A measurement of velocities overstates the loss, because the energy of the final
        spin is counted as lost.
    """,
    method="Dynamic simulation, contact [[case]].",
    as_shipped="""
        Dotted: 5 to 95 % of the translational losses of the posterior contacts that rebound
        (figure evidence). Circles: the virtual experiments of Fig. 6 on the smooth front,
        whose loss is the translational one; their agreement is by construction.
    """,
    contact=TWO_STAGES,
    width="single",
    height_mm=65.0,
)
def draw_fig21(sheet: Sheet) -> None:
    """Losses against the angle; between the two, shaded, is the energy of spin."""
    (ax,) = sheet.panels(ylim=(0.0, 0.6), ylabel=ENERGY_LOSS)
    sheet.over_angle(ax)
    looks = {
        "total": Series("all kinetic energy", 0),
        "translational": Series("translational energy alone", 1, line="dashed"),
        "virtual experiment": Series("virtual experiment", 6),
        "posterior": Series("drawn contacts, 5 to 95 %", 1, line="dotted", band=True),
    }
    sheet.draw(ax, looks, omit="capture")
    sheet.legend(ax, "lower right")
    sheet.keys()
    sheet.captured(ax, sheet.abscissae(ax, "capture").max())
    rows = sheet.tables["fig21"]
    total, moved = (rows[rows["series"] == name] for name in ("total", "translational"))
    ends = total.iloc[:, 4].to_numpy(), moved.iloc[:, 4].to_numpy()
    spin = "energy of the final spin"
    ax.fill_between(total.iloc[:, 3], *ends, label=spin, color="0.85", linewidth=0, zorder=0)
    ax.legend(loc="lower right")
