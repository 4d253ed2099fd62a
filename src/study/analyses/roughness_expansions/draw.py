"""Figure roughness: coefficients measured on a slope, exact and by the article's equations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from study.figures.declaration import (
    MEASURED_IMPULSE_RATIO,
    MEASURED_RESTITUTION,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

FORMS = {
    "exact": Series("exact", 6),
    "printed": Series("expansion as printed", 1, line="dashed"),
    "corrected": Series("expansion corrected", 0, line="dashdot"),
    "35 printed": Series("Eq. 35 as printed", 3, line="dotted"),
    "35 printed beyond": Series("Eq. 35 as printed", 3, line="dotted"),
    "39 printed": Series("Eq. 39 as printed", 2, line="dotted"),
    "energy bound": Series("bound by energy", 6, thin=True),
}
SLOPE = r"Slope $\phi$ (°)"
# Bars of the ranges of agreement: words, height as a share of the panel, colour.
BARS = {"corrected": ("corrected", 0.07, 0), "printed": ("as printed", 0.03, 1)}


def expansion_holds_on_gentle_slopes(y: Curves) -> Stated:
    """The range of agreement, to either side, is wider with the corrected signs."""
    printed, corrected = (
        np.abs(y(f"range {form}", "slope restitution").index.to_numpy(float)).min()
        for form in ("printed", "corrected")
    )
    return stated(printed < corrected, printed=printed, corrected=corrected)


@figure(
    "roughness",
    "Coefficients measured on a slope, exact and by the article's equations",
    """
        Restitution e_m and impulse ratio -mu_m measured about the nominal normal where the
        sphere strikes a slope phi: exact, by the article's expansions as printed, and
        corrected. Bars at the foot: where an expansion is within [[tolerance:g]]. (a) At
        [[drawn_angle_deg:.0f]]°. (b), (c) At normal incidence, (c) with spin.
    """,
    {
        "slope restitution": r"$\alpha$ = [[drawn_angle_deg:.0f]]°",
        "normal restitution": r"$\alpha$ = 90°, no spin",
        "normal impulse ratio": r"$\alpha$ = 90°, $r\omega/v$ = [[drawn_spin_ratio:g]]",
    },
    data=("roughness",),
    equations="35, 36, 37, 41, 4.1.2 restitution",
    finding="""
        At [[drawn_angle_deg:.0f]]° the article's expansion of the restitution holds on
        slopes of up to {printed:.1f}° as printed, and up to {corrected:.1f}° with its signs
        corrected.
    """,
    holds=expansion_holds_on_gentle_slopes,
    method="""
        e = [[restitution:.2f]] and f = [[friction:.2f]] about the local normal; Eqs. 37, 41
        and e - 9 phi^2/7. With its printed sign Eq. 35 never gives e_m above 1 on a slope that
        faces the sphere, and has a pole at phi = -alpha/2. The thin bound in (a) is the
        largest value that conservation of energy allows. In (b), (c) the sphere rolls at
        separation; in (c) the spin r omega/v is [[drawn_spin_ratio:g]]; Eq. 41 prints the wrong sign of its
        spin term.
    """,
    height_mm=75.0,
)
def draw_roughness(sheet: Sheet) -> None:
    """Curves, and bars at the foot of each panel for the ranges of agreement.

    A series ``range x`` holds the two ends of the range of series x.
    """
    axes = sheet.panels(xlabel=SLOPE)
    limits = ((-9.0, 20.0), (-1.5, 6.5)), ((-20.0, 20.0), (0.5, 0.72)), ((-20.0, 20.0), (-0.4, 0.4))
    *restitution, ratio = axes
    for ax, (xlim, ylim) in zip(axes, limits, strict=True):
        ax.set(xlim=xlim, ylim=ylim, ylabel=MEASURED_RESTITUTION)
    ratio.set_ylabel(MEASURED_IMPULSE_RATIO)
    for ax in axes:
        for form, (words, height, colour) in BARS.items():
            ends = sheet.take(ax, f"range {form}").iloc[:, 3]
            if len(ends):
                label = f"holds to the tolerance, {words}"
                look: dict[str, Any] = {"color": f"C{colour}", "label": label, "clip_on": False}
                across = ax.get_xaxis_transform()
                ax.plot(ends, [height] * len(ends), "|-", transform=across, **look)
        sheet.draw(ax, FORMS, fixed=ax in restitution)
    sheet.keys()
