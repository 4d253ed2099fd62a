"""Fig. 14: trends of the coefficients of restitution and adhesion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import NORMAL_SPEED, Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def restitution_has_a_maximum(y: Curves) -> Stated:
    """Restitution is largest at a speed between the ends, well above its last value."""
    e = y("overall restitution")
    speed, most = e.index.to_numpy(float)[e.argmax()], float(e.max())
    inside = e.index[0] < speed < e.index[-1] and most > e.iloc[-1] + 0.01
    return stated(inside, speed=speed, most=most)


@figure(
    "fig14",
    "Trends of the coefficients of restitution and adhesion",
    """
        Restitution without adhesion R, adhesion coefficient rho, and restitution e = R (1 -
        rho) against the normal impact speed, by Eqs. 32 to 34 with assumed constants. At the
        capture velocity rho is 1; slower spheres are captured.
    """,
    {"trends": ""},
    data=("fig14",),
    equations="32, 33, 34",
    article="""
        A sketch without scales of how the coefficients of restitution and adhesion run with the
        normal speed.
    """,
    finding="""
        Restitution is largest, {most:.2f}, at {speed:.1f} m/s: adhesion lowers it at smaller
        speeds, and the fall of R at greater ones.
    """,
    holds=restitution_has_a_maximum,
    width="single",
    height_mm=65.0,
)
def draw_fig14(sheet: Sheet) -> None:
    """R, rho and e; below the capture velocity, an upright line, spheres are captured."""
    (ax,) = sheet.panels(
        xlim=(0.0, 10.0), ylim=(0.0, 1.05), xlabel=NORMAL_SPEED, ylabel="Coefficient"
    )
    coefficients = {
        "body restitution": Series("$R$, without adhesion", line="dashed"),
        "adhesion": Series(r"$\rho$, adhesion", line="dashdot"),
        "overall restitution": Series(r"$e = R\,(1-\rho)$"),
        "capture velocity": Series("$v_c$, capture velocity", 6, line="dotted"),
    }
    sheet.draw(ax, coefficients)
    sheet.captured(ax, "capture velocity")  # after its line is drawn
    sheet.legend(ax, "center right")
    sheet.keys()
