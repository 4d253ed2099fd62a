"""Figures of fig24_25_doe."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import TWO_STAGES, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet

LOOKS_FIG24_NORMAL = {
    "v_c": Series("$v_c$, exact", 0),
    "v_c by Eq. 34": Series("$v_c$ by a fit of Eq. 34", 1),
    "margin": Series("Lenth's margin"),
    "simultaneous margin": Series("simultaneous margin"),
}
LOOKS_FIG24_HALF_NORMAL = {
    "v_c": Series("$v_c$, exact", 0),
    "ln v_c": Series(r"$\ln v_c$, exact", 2),
    "margin": Series("Lenth's margin"),
    "simultaneous margin": Series("simultaneous margin"),
}


@Figure(
    "fig24",
    "Effects of five factors on the capture velocity, realistic levels",
    """
        Effects of stiffness (A), work of adhesion (B), radius (C), damping of adhesion (D)
        and of the material (E), and of their interactions, on the capture velocity, exact
        and by a fit of Eq. 34. Levels: the uncertainty of each factor. (a) Normal plot. (b)
        Half-normal plot; green: effects on ln v_c.
    """,
    {"normal": "normal plot of effects", "half_normal": "half-normal plot"},
    data=("fig24",),
    equations="23, 24, 25, 34",
    article="""
        Effects of the factors and of their interactions on the capture velocity, with
        realistic variations of each.
    """,
    finding="""
        Radius and the damping of adhesion have the largest effects; the capture velocity is
        nearly a power law of all factors.
    """,
    method="""
        Fraction [[generator]] of a two-level design about [[drawn_case]]. Labelled in (a)
        are the factors, the interactions as large as one of A to D, and all beyond Lenth's
        margin. The responses are deterministic: Lenth's margins only separate large effects
        from small ones; the simultaneous margin is the one for all effects at once. Margins
        are for the exact capture velocity.
    """,
    as_shipped="""
        The interactions nearly vanish for the logarithm. D exceeds B here; the article
        names C and B.
    """,
    contact=TWO_STAGES,
    tables={
        "doe_levels": "Low and high level of every factor of the designs.",
        "doe_effects": "Every effect of both designs on the capture velocity, its aliases and its margin of error.",
        "doe_elasticities": "Relative change of the capture velocity for a relative change of each factor.",
        "doe_bd_aliasing": "The interaction BD and the main effect it is mixed with in the fraction.",
        "doe_design": "Every run of the full design, its levels and its capture velocity, exact and by a fit of Eq. 34.",
    },
    height_mm=98.0,
)
def draw_fig24(sheet: Sheet) -> None:
    """Draw it (was study.figures.analyses.effects.draw)."""
    normal, half_normal = sheet.panels()
    normal.set(
        xlim=(-150.0, 150.0),
        ylim=(-2.2, 2.2),
        xlabel="Effect (% of mean)",
        ylabel="Normal quantile",
    )
    half_normal.set(
        xlim=(-15.0, 150.0),
        ylim=(-0.1, 2.4),
        xlabel="Size of effect (%)",
        ylabel="Half-normal quantile",
    )
    sheet.draw(normal, LOOKS_FIG24_NORMAL)
    # legend title 'A stiffness $K$,  B work of adhesion $w_A$,  C radius $r$,  D damping of adhesion $\\zeta_A$,  E damping of the material $\\zeta_H$;  two letters: interaction;  all computed'
    sheet.draw(half_normal, LOOKS_FIG24_HALF_NORMAL)
    sheet.keys()


@Figure(
    "fig25",
    "Effects of five factors on the capture velocity, uniform levels",
    """
        As Fig. 24, with levels equally far, in proportion, to either side of the nominal
        value of every factor. The effects of work of adhesion (B) and radius (C) differ
        only in sign, and so do their interactions with any other factor.
    """,
    {"normal": "normal plot of effects", "half_normal": "half-normal plot"},
    data=("fig25",),
    equations="23, 24, 25, 34",
    article="The same with an equal variation of five percent of every factor.",
    finding="""
        With equal relative levels, work of adhesion and radius act through their ratio
        alone.
    """,
    method="Levels are in the table doe_levels.",
    contact=TWO_STAGES,
    height_mm=98.0,
)
def draw_fig25(sheet: Sheet) -> None:
    """Draw it (was study.figures.analyses.effects.draw)."""
    normal, half_normal = sheet.panels()
    normal.set(
        xlim=(-17.5, 17.5), ylim=(-2.2, 2.2), xlabel="Effect (% of mean)", ylabel="Normal quantile"
    )
    half_normal.set(
        xlim=(-2.5, 20.0),
        ylim=(-0.1, 2.4),
        xlabel="Size of effect (%)",
        ylabel="Half-normal quantile",
    )
    sheet.draw(normal, LOOKS_FIG24_NORMAL)
    # legend title 'A stiffness $K$,  B work of adhesion $w_A$,  C radius $r$,  D damping of adhesion $\\zeta_A$,  E damping of the material $\\zeta_H$;  two letters: interaction;  all computed'
    sheet.draw(half_normal, LOOKS_FIG24_HALF_NORMAL)
    sheet.keys()
