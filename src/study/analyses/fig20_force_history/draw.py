"""Fig. 20: normal force during an impact, and its terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Remark, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves, ResultTables

# Height of the enlarged panel over the deepest dip.
ENLARGED = 1.4


def small_forces_take_energy(tables: ResultTables) -> Stated:
    """Damping is below a tenth of the Hertz force, but takes over a fifth of the energy."""
    adhesion, damping, e = (
        tables("force_ratios")("value", quantity=name)
        for name in (
            "peak_adhesion_over_peak_hertz",
            "peak_adhesion_dissipation_over_adhesion",
            "coefficient_of_restitution",
        )
    )
    share, loss = adhesion * damping, 1.0 - e**2
    return stated(share < 0.1 and loss > 0.2, share=share, loss=loss)


AGREEMENT = (
    Remark(
        "The dissipative force is small, as the article notes: at most {share:.0%} of the "
        "largest Hertz force. It nevertheless takes {loss:.0%} of the energy.",
        small_forces_take_energy,
    ),
)


def attracts_at_both_ends(y: Curves) -> Stated:
    """The net force is negative before and after the peak; damping acts after it alone."""
    net, damping = y("total"), y("adhesion damping")
    peak = y("hertz").idxmax()
    attracts = net[:peak].min() < 0.0 and net[peak:].min() < 0.0
    return stated(attracts and damping[:peak].abs().max() < 0.01 * damping.abs().max())


@figure(
    "fig20",
    "Normal force during an impact, and its terms",
    """
        Normal force against time for a sphere of [[diameter_um:g]] µm of [[case.pair]] at
        [[speed_m_per_s:g]] m/s, and its four terms; compression is positive. (a) The whole
        contact. (b) Enlarged: the force is attractive near the beginning and, more strongly,
        near the end.
    """,
    {"force": "whole contact", "dips": "enlarged: attraction near both ends"},
    data=("fig20",),
    views={"dips": "force"},
    equations="19, 25, 30",
    article="""
        The simulated normal force and its terms against time, for ammonium fluorescein of 4.9
        µm on molybdenum at 5.2 m/s with a ring force of 8.90 N/m.
    """,
    finding="""
        The net force is attractive at both ends of the contact; adhesion dissipates only
        during the rebound.
    """,
    holds=attracts_at_both_ends,
    agreement=AGREEMENT,
    method="Contact [[case]].",
    as_shipped="""
        The adhesion damping is calibrated to the printed ratio of dissipative to total adhesion
        (1/5); the damping of the Hertz force is zero by choice.
    """,
    tables={"force_ratios": "Ratios of the largest forces, beside the printed ones."},
)
def draw_fig20(sheet: Sheet) -> None:
    """Force against time: the whole contact, and its attraction enlarged."""
    force, dips = sheet.panels(xlim=(0.0, 55.0), xlabel="Time $t$ (ns)", ylabel="Normal force (µN)")
    force.set(ylim=(-40.0, 80.0))
    rows = sheet.tables["fig20"]
    height = ENLARGED * abs(rows.loc[rows["series"] == "total", "y_uN"].min())
    dips.set(ylim=(-height, height))
    terms = {
        "total": Series("net force", 6),
        "hertz": Series("Hertz force", 0, line="dashed"),
        "adhesion": Series("adhesion", 1, line="dashdot"),
        "adhesion damping": Series("damping of adhesion", 3, line="dotted"),
        "hertz damping": Series("damping of Hertz force", 2, thin=True),
    }
    for ax in (force, dips):
        sheet.level(ax, 0.0)
        sheet.draw(ax, terms, fixed=ax is dips)
    dips.set(xlim=force.get_xlim())
    sheet.keys()
