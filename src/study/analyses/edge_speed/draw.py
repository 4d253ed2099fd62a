"""Figure plateau_by_edge: restitution of contacts whose edge opens by its own speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import (
    CAPTURE_VELOCITY,
    NORMAL_SPEED,
    RESTITUTION,
    TWO_STAGES,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

EDGES = {
    "m = 0.1": Series("$m$ = 0.1", 0),
    "m = 0.25": Series("$m$ = 0.25", 1, line="dashed"),
    "m = 0.5": Series("$m$ = 0.5", 2, line="dashdot"),
    "m = 0.75": Series("$m$ = 0.75", 3, line="dotted"),
    "m = 0.96": Series("$m$ = 0.96", 4, thin=True),
    "m = 1.25": Series("$m$ = 1.25", 5, line="dashed", thin=True),
    "as printed": Series("as printed", 6),
    "roughly constant": Series("roughly constant below", 6, line="dashed", beside=0.017),
}


def no_plateau_at_the_printed_velocity(y: Curves) -> Stated:
    """At the printed capture velocity every exponent has a fall larger than passes for none."""
    falls = [y(name, "plateau").iloc[-1] for name in EDGES if name.startswith("m = ")]
    allowed = y("roughly constant", "plateau").iloc[-1]
    return stated(min(falls) > allowed, least=min(falls), most=max(falls))


@figure(
    "plateau_by_edge",
    "Plateau and capture velocity of a contact whose edge opens by its own speed",
    """
        (a) Fall of the restitution of [[case.pair]] from [[speed_m_per_s:g]] to
        [[plateau_from_m_per_s:g]] m/s against the capture velocity, by exponent m of the work of
        separation over the speed of the edge, which is [[work_of_adhesion_J_per_m2:g]] J/m² at
        rest. Below the level line it is roughly constant. (b) Restitution against the normal
        speed with the printed capture velocity; diamonds: both ends of the printed plateau.
    """,
    {"plateau": "fall of the restitution", "restitution": "restitution, $v_c$ as printed"},
    data=("edge_speed_plateau", "edge_speed_curves"),
    finding="""
        With the printed capture velocity no exponent of the edge has the flat restitution: it
        falls by {least:.2f} to {most:.2f}.
    """,
    holds=no_plateau_at_the_printed_velocity,
    method="""
        The edge's speed c and the relaxation time of the bulk are solved for, so that the capture
        velocity and a restitution of [[restitution:g]] at [[speed_m_per_s:g]] m/s hold; where the
        edge alone loses more, the bulk loses nothing. With m = 0.96 and no loss in the bulk the
        capture velocity goes as d to the power of −1.6.
    """,
    contact=TWO_STAGES,
    tables={
        "edge_speed": "Edge, bulk, exponent of the diameter and plateau, at the printed capture velocity and at the greatest with a plateau.",
    },
    height_mm=90.0,
)
def draw_plateau_by_edge(sheet: Sheet) -> None:
    """Fall of the restitution against the capture velocity, and restitution against the speed."""
    plateau, restitution = sheet.panels(xscale="log")
    plateau.set(xlim=(0.01, 0.2), ylim=(-0.05, 0.2), xlabel=CAPTURE_VELOCITY)
    plateau.set_ylabel("Fall of restitution")
    sheet.ticks(plateau.xaxis, (1, 2, 5), decades=True)
    restitution.set(xlim=(0.1, 3.0), ylim=(0.0, 1.0), xlabel=NORMAL_SPEED, ylabel=RESTITUTION)
    sheet.ticks(restitution.xaxis, (1, 3), decades=True)
    for ax in (plateau, restitution):
        sheet.draw(ax, EDGES)
    sheet.keys()
