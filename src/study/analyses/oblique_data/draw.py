"""Figure oblique_rebounds: rebounds that others measured, and three laws of the contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from study.figures.declaration import OVER_ANGLE, TWO_STAGES, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def partial_slip_is_followed(y: Curves) -> Stated:
    """Below the slip that friction just stops, Mindlin is nearest by at least a factor of two."""
    import pandas as pd

    measured = pd.concat(
        [y(f"measured: Kharaz et al. 2001, reading {r}", "contact point") for r in "AB"]
    )
    sticks = measured[measured.index < 1.0]
    rms = {}
    for law in ("mindlin", "rigid", "spring"):
        curve = y(law, "contact point")
        rms[law] = float(
            np.sqrt(np.mean((sticks - np.interp(sticks.index, curve.index, curve)) ** 2))
        )
    others = min(rms["rigid"], rms["spring"])
    return stated(2.0 * rms["mindlin"] < others, mindlin=rms["mindlin"], others=others)


@figure(
    "oblique_rebounds",
    "Oblique rebounds that others measured, and three laws of the contact along the surface",
    """
        Spheres of aluminium oxide, [[diameter_um:.0f]] µm, on glass at [[speed_m_per_s:g]] m/s,
        measured by Kharaz et al. 2001 (two readings of their figure), and three laws. (a)
        Tangential velocity after over before impact. (b) Spin. (c) Velocity of the contact
        point, turned round, against the slip in units of what friction just stops; zero is
        rolling.
    """,
    {"velocity": "tangential velocity", "spin": "spin", "contact point": "contact point"},
    data=("oblique_velocity", "oblique_spin", "contact_point"),
    equations="27, 29",
    finding="""
        Measured rebounds follow Mindlin's partial slip where spheres stick, within
        {mindlin:.2f} of the slip; a rigid contact and a single spring miss by {others:.2f}.
    """,
    holds=partial_slip_is_followed,
    method="""
        We fit nothing, but friction [[friction:g]] and restitution [[restitution:g]] are
        literature values that may themselves have been fitted to these data; agreement in the
        sliding regime is therefore a weak test. Powder Technology 120, 2001; angles, given from
        the normal, are turned into those from the surface. The rigid contact is Eqs. 7, 8 and
        12. Diamond in (c): where the article's microspheres cease to slide, about
        [[microspheres.transition_deg:g]]° give or take
        [[microspheres.transition_within_deg:g]]°. There a rigid contact and the compliant one
        of [[microspheres.case]] (dotted) both pass: this angle cannot tell whether microspheres
        roll; steeper impacts could.
    """,
    contact=TWO_STAGES,
    tables={
        "oblique_comparison": "Every measured point of the oblique rebounds, and each law.",
        "oblique_residuals": "Root mean square of each law where a rigid sphere slides and where it sticks.",
    },
    evidence_labels={
        "printed": "angle printed in the article",
    },
)
def draw_oblique_rebounds(sheet: Sheet) -> None:
    """Velocity and spin against the angle, and the contact point against the slip."""
    velocity, spin, contact_point = axes = sheet.panels()
    velocity.set(**OVER_ANGLE, ylim=(0.5, 1.0), ylabel="$V_t/v_t$")
    spin.set(**OVER_ANGLE, ylim=(0.0, 700.0), ylabel="Spin (rad/s)")
    for ax in (velocity, spin):
        ax.set_xticks((0, 30, 60, 90))
    contact_point.set(xlim=(0.0, 2.0), xlabel="Slip / slip that friction just stops")
    contact_point.set(ylim=(-0.6, 0.6), ylabel=r"$-(V_t - r\Omega)/(v_t - r\omega)$")
    sheet.level(contact_point, 0.0)
    laws = {
        "rigid": Series("rigid", 0, line="dashdot"),
        "mindlin": Series("Mindlin", 1),
        "spring": Series("spring (DEM)", 2, line="dashed"),
        "Kharaz et al. 2001, reading A": Series("Kharaz et al. 2001, reading A", 6),
        "Kharaz et al. 2001, reading B": Series("Kharaz et al. 2001, reading B", 4),
        "microspheres": Series("Mindlin, [[microspheres.case]]", 6, line="dotted"),
        "article": Series("article, about [[microspheres.transition_deg:g]]°", 6),
    }
    for ax in axes:
        sheet.draw(ax, laws)
    sheet.keys()
