"""Figures of sensitivity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import TWO_STAGES, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet

LOOKS_SOBOL_REALISTIC_STEEL_SILICON_N_0 = {
    "total index": Series("total index", 0),
    "first-order index": Series("first-order index", 2),
    "share of squared effects": Series("share of squared effects", 1),
}


@Figure(
    "sobol",
    "Sobol' indices of the capture velocity, and effects of the designed experiments",
    """
        Shares of the variance of the capture velocity of [[cases.pair]], with
        [[confidence:.0%]] bootstrap intervals. (a, b, d, e) Total and first-order indices
        over the levels of Figs. 24 and 25, with shares of the squared effects. (c) Total
        indices with calibrated parameters and uncertain targets. (f) Convergence of (a).
    """,
    {
        "realistic, steel-silicon, n = 0": "realistic, $n$ = 0",
        "realistic, steel-silicon, n = 1": "realistic, $n$ = 1",
        "calibrated": "calibrated",
        "uniform, steel-silicon, n = 0": "uniform, $n$ = 0",
        "uniform, steel-silicon, n = 1": "uniform, $n$ = 1",
        "convergence": "convergence of (a)",
    },
    data=("sobol",),
    equations="23, 24, 25",
    finding="""
        Once parameters are calibrated they are correlated, and most of their separate
        influence disappears.
    """,
    method="""
        In (a, b, d, e) the five factors are drawn independently. In (c) the radius varies
        from sphere to sphere and the other parameters follow from calibrations whose
        targets are uncertain: stiffness K, restitution e, capture velocity at the nominal
        radius, and which of the contacts that meet the targets equally well is taken. n is
        the rate exponent of the adhesion damping, whose coefficient falls with the impact
        speed as v^-n. Draws without a finite capture velocity have no variance and would be
        left out; the tables count them.
    """,
    contact=TWO_STAGES,
    tables={
        "sensitivity_indices": "First and total indices of every factor, and the effects of the designed experiments.",
        "sensitivity_groups": "Indices of groups of factors: uncertain parameters against parameters that vary.",
        "sensitivity_convergence": "Sobol' indices from fewer samples.",
    },
    height_mm=125.0,
    columns=3,
)
def draw_sobol(sheet: Sheet) -> None:
    """Draw it (was study.figures.analyses.indices.draw)."""
    (
        realistic_steel_silicon_n_0,
        realistic_steel_silicon_n_1,
        calibrated,
        uniform_steel_silicon_n_0,
        uniform_steel_silicon_n_1,
        convergence,
    ) = sheet.panels()
    realistic_steel_silicon_n_0.set(
        xlim=(-0.5, 4.5), ylim=(-0.04, 1.0), xlabel="Factor", ylabel="Share of variance"
    )
    realistic_steel_silicon_n_1.set(
        xlim=(-0.5, 4.5), ylim=(-0.04, 1.0), xlabel="Factor", ylabel="Share of variance"
    )
    calibrated.set(xlim=(-0.5, 4.5), ylim=(-0.04, 1.3), xlabel="Input", ylabel="Total index")
    uniform_steel_silicon_n_0.set(
        xlim=(-0.5, 4.5), ylim=(-0.04, 1.0), xlabel="Factor", ylabel="Share of variance"
    )
    uniform_steel_silicon_n_1.set(
        xlim=(-0.5, 4.5), ylim=(-0.04, 1.0), xlabel="Factor", ylabel="Share of variance"
    )
    convergence.set(xlim=(24, 1365), ylim=(-0.04, 1.5), xlabel="Base samples", ylabel="Total index")
    sheet.draw(realistic_steel_silicon_n_0, LOOKS_SOBOL_REALISTIC_STEEL_SILICON_N_0)
    sheet.draw(realistic_steel_silicon_n_1, LOOKS_SOBOL_REALISTIC_STEEL_SILICON_N_0)
    looks_calibrated = {
        "steel-silicon, n = 0": Series("$n$ = 0", 0),
        "steel-silicon, n = 1": Series("$n$ = 1", 1),
    }
    sheet.draw(calibrated, looks_calibrated)
    sheet.legend(calibrated, "upper right")
    sheet.draw(uniform_steel_silicon_n_0, LOOKS_SOBOL_REALISTIC_STEEL_SILICON_N_0)
    sheet.draw(uniform_steel_silicon_n_1, LOOKS_SOBOL_REALISTIC_STEEL_SILICON_N_0)
    looks_convergence = {
        "A": Series("$K$", 0),
        "B": Series("$w_A$", 1),
        "C": Series("$r$", 2),
        "D": Series(r"$\zeta_A$", 3),
        "E": Series(r"$\zeta_H$", 6),
    }
    sheet.draw(convergence, looks_convergence)
    sheet.keys()
