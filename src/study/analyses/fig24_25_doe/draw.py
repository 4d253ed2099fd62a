"""Figs. 24, 25: effects of five factors on the capture velocity."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from study.figures.declaration import TWO_STAGES, Remark, Series, figure, stated

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves, ResultTables

DRAWN = {"variation": "realistic", "design": "fraction"}
CASES = "steel-silicon, n = 0", "steel-silicon, n = 1"

# By response: words and marks.
NORMAL = {
    "v_c": Series("$v_c$, exact", 0),
    "v_c by Eq. 34": Series("$v_c$ by a fit of Eq. 34", 1, mark="triangle", open=True),
}
HALF_NORMAL = {
    "v_c": Series("$v_c$, exact", 0),
    "ln v_c": Series(r"$\ln v_c$, exact", 2, mark="square", open=True),
}
MARGINS = {
    "margin": Series("Lenth's margin", line="dashed"),
    "simultaneous margin": Series("simultaneous margin", line="dotted"),
}
MARGIN_COLOUR = "0.45"
LEGEND = (
    r"A stiffness $K$,  B work of adhesion $w_A$,  C radius $r$,  D damping of adhesion "
    r"$\zeta_A$,  E damping of the material $\zeta_H$;  two letters: interaction;  all computed"
)
FACTORS = tuple("ABCDE")
# Effects that the article names, which are labelled however small.
NAMED = ("A", "B", "C", "D", "BD")
LABEL_SIZE = 7.5
LABEL_GAP = 4.5
# Least distance of two labels, as a part of the height of a panel.
LABEL_HEIGHT = 0.045


def _effect(y: Curves, response: str, name: str) -> float:
    """Return an effect in % of the mean; interactions may stand for an alias as well."""
    return float(y(f"{response}: {name}", "normal").index[0])


def exponent_decides_who_leads(tables: ResultTables) -> Stated:
    """With n = 0 C and D lead B clearly; with n = 1 the three are within a tenth."""
    (b0, c0, d0), (b1, c1, d1) = (
        [
            tables("doe_effects")(
                "effect_percent", case=case, response="v_c", effect=factor, **DRAWN
            )
            for factor in "BCD"
        ]
        for case in CASES
    )
    sizes = [abs(effect) for effect in (b1, c1, d1)]
    holds = min(abs(c0), d0) > 1.3 * b0 and max(sizes) < 1.1 * min(sizes)
    return stated(holds, b0=b0, c0=c0, d0=d0, low=min(sizes), high=max(sizes))


def fit_changes_little(tables: ResultTables) -> Stated:
    """No effect by the fit differs by more than a twentieth of the largest one."""
    exact, fitted = (
        tables("doe_effects").all("effect_percent", case=CASES[0], response=response, **DRAWN)
        for response in ("v_c", "v_c by Eq. 34")
    )
    most = max(abs(a - b) for a, b in zip(exact, fitted, strict=True))
    largest = max(map(abs, exact))
    return stated(0.0 < most < 0.05 * largest, most=most, largest=largest)


DISAGREEMENT = (
    Remark(
        "Which two factors stand out depends on the rate exponent of the adhesion damping. With "
        "n = 0 they are C, {c0:.0f} %, and D, {d0:.0f} %, not B, {b0:.0f} %; with n = 1 the "
        "three differ little in size, {low:.0f} to {high:.0f} %. The article has C and B.",
        exponent_decides_who_leads,
    ),
)
AGREEMENT = (
    Remark(
        "The article takes capture velocities from fits of Eq. 34. That changes no effect by "
        "more than {most:.1f} % of the mean, where the largest is {largest:.0f} %.",
        fit_changes_little,
    ),
)


def nearly_a_power_law(y: Curves) -> Stated:
    """C and D lead; interactions are small for the logarithm."""
    size = {name: abs(_effect(y, "v_c", name)) for name in FACTORS}
    leading = sorted(size, key=size.__getitem__)[-2:]
    pairs = ["".join(pair) for pair in combinations(FACTORS, 2)]
    largest = max(abs(_effect(y, "ln v_c", pair)) for pair in pairs)
    share = largest / abs(_effect(y, "ln v_c", "C"))
    return stated(leading == ["D", "C"] and share < 0.2, share=100.0 * share)


@figure(
    "fig24",
    "Effects of five factors on the capture velocity, realistic levels",
    """
        Effects of stiffness (A), work of adhesion (B), radius (C), damping of adhesion (D) and
        of the material (E), and of their interactions, on the capture velocity, exact and by a
        fit of Eq. 34. Levels: the uncertainty of each factor. (a) Normal plot. (b) Half-normal
        plot; green: effects on ln v_c.
    """,
    {"normal": "normal plot of effects", "half_normal": "half-normal plot"},
    data=("fig24",),
    equations="23, 24, 25, 34",
    article="""
        Effects of the factors and of their interactions on the capture velocity, with realistic
        variations of each.
    """,
    finding="""
        Radius and the damping of adhesion have the largest effects; the capture velocity is
        nearly a power law: no interaction of its logarithm exceeds {share:.0f} % of the
        effect of the radius.
    """,
    holds=nearly_a_power_law,
    disagreement=DISAGREEMENT,
    agreement=AGREEMENT,
    method="""
        Fraction [[generator]] of a two-level design about [[drawn_case]]. Labelled are A to D and
        BD, which the article names, and, where there is room, all effects beyond Lenth's margin;
        of a sum of effects, as A+BD, the fraction does not tell the parts. The responses are
        without noise, so Lenth's margins are a guide to size, not a test; the simultaneous margin
        allows for all effects at once. Margins are for the exact capture velocity.
    """,
    as_shipped="""
        The interactions nearly vanish for the logarithm. D exceeds B here; the article names C
        and B.
    """,
    contact=TWO_STAGES,
    tables={
        "doe_levels": "Low and high level of every factor of the designs.",
        "doe_effects": "Every effect of both designs on the capture velocity, its aliases and its "
        "margin of error.",
        "doe_elasticities": "Relative change of the capture velocity for a relative change of each "
        "factor.",
        "doe_bd_aliasing": "The interaction BD and the main effect it is mixed with in the "
        "fraction.",
        "doe_design": "Every run of the full design, its levels and its capture velocity, exact "
        "and by a fit of Eq. 34.",
    },
    height_mm=98.0,
)
def draw_fig24(sheet: Sheet) -> None:
    """Effects reach beyond the mean."""
    _draw_effects(sheet, (-150.0, 150.0), (-5.0, 150.0))


def only_the_ratio_acts(y: Curves) -> Stated:
    """Effects of B and C, and of their interactions with another factor, are opposite."""
    effects = [[_effect(y, "v_c", name) for name in names] for names in (("B", "BD"), ("C", "CD"))]
    opposite = np.allclose(effects[0], np.negative(effects[1]), rtol=0.01)
    return stated(opposite, effect=effects[0][0], other=effects[1][0])


@figure(
    "fig25",
    "Effects of five factors on the capture velocity, uniform levels",
    """
        Effects of stiffness (A), work of adhesion (B), radius (C), damping of adhesion (D) and
        of the material (E), and of their interactions, on the capture velocity, exact and by a
        fit of Eq. 34. Levels: equally far, in proportion, to either side of the nominal value
        of every factor. (a) Normal plot. (b) Half-normal plot; green: effects on ln v_c. The effects of work of adhesion (B) and radius (C) differ only in sign,
        and so do their interactions with any other factor.
    """,
    {"normal": "normal plot of effects", "half_normal": "half-normal plot"},
    data=("fig25",),
    equations="23, 24, 25, 34",
    article="The same with an equal variation of five percent of every factor.",
    finding="""
        With equal relative levels, work of adhesion and radius act through their ratio
        alone: their effects are {effect:+.1f} and {other:+.1f} %.
    """,
    holds=only_the_ratio_acts,
    method="Levels are in the table doe_levels.",
    contact=TWO_STAGES,
    height_mm=98.0,
)
def draw_fig25(sheet: Sheet) -> None:
    """Effects of a few percent."""
    _draw_effects(sheet, (-17.5, 17.5), (-0.7, 20.0))


def _draw_effects(sheet: Sheet, effects: tuple[float, float], sizes: tuple[float, float]) -> None:
    """Draw a normal plot of effects, and a half-normal one; ends of the abscissae in %.

    A series is called ``response: effect``, with what cannot be told from it, or as one of the
    margins.
    """
    from study.figures import style
    from study.tables import POINTS

    normal, half_normal = sheet.panels()
    normal.set(
        xlim=effects, ylim=(-2.2, 2.2), xlabel="Effect (% of mean)", ylabel="Normal quantile"
    )
    half_normal.set(
        xlim=sizes, ylim=(-0.1, 2.4), xlabel="Size of effect (%)", ylabel="Half-normal quantile"
    )
    (table,) = sheet.tables.values()
    parts = table["series"].str.split(": ", n=1, expand=True)
    word = parts[1].str.split(r"[+-]", regex=True).str[0]
    table = table.assign(response=parts[0], word=word, label=parts[1])
    panels = {normal: NORMAL, half_normal: HALF_NORMAL}
    for ax, looks in panels.items():
        rows = table[table["panel"] == ax.get_label()]
        if rows.empty:
            raise ValueError(f"figure data: no rows for panel {ax.get_label()!r}")
        _draw_panel(ax, rows, looks, half=ax is half_normal)
    least, greatest = half_normal.get_xlim()
    half_normal.set_xticks([t for t in half_normal.get_xticks() if 0.0 <= t <= greatest])
    half_normal.set_xticks([], minor=True)
    half_normal.set_xlim(least, greatest)
    style.legend_above(sheet.figure, panels, title=LEGEND, loc="outside lower center")
    points = table[table["evidence"].isin(POINTS)]
    names = list(points["series"].unique())
    for ax, looks in panels.items():
        sheet.overlay(ax, points[points["panel"] == ax.get_label()], looks, names)
    if names:
        sheet.evidence_key(loc="outside upper center")


def _draw_panel(ax: Axes, rows: pd.DataFrame, looks: Mapping[str, Series], *, half: bool) -> None:
    """Draw the effects on each response; the margins belong to the first."""
    from study.figures import style

    x, y = rows.columns[3:5]
    shown = rows[rows["response"].isin(looks)]
    is_margin = shown["word"].isin(MARGINS)
    if not half:
        ax.axhline(0.0, color="0.85", linewidth=0.6, zorder=0)
        ax.axvline(0.0, color="0.85", linewidth=0.6, zorder=0)
    ax.set_xlim(style.widened(ax.get_xlim(), shown[x].to_numpy(float)))
    ax.set_ylim(style.widened(ax.get_ylim(), shown[y].to_numpy(float)))
    main = next(iter(looks))
    margins = shown[is_margin & (shown["response"] == main)]
    for word, margin in MARGINS.items():
        label: str | None = margin.label
        for end in margins.loc[margins["word"] == word, x]:
            ax.axvline(end, color=MARGIN_COLOUR, linestyle=margin.line, linewidth=0.9, label=label)
            label = None
    limit = float(margins.loc[margins["word"] == "margin", x].max())
    for response, look in looks.items():
        points = shown[~is_margin & (shown["response"] == response)]
        colour, marker = f"C{look.colour}", style.MARKS[look.mark]
        face = "none" if look.open else "full"
        pen: dict[str, Any] = {"marker": marker, "fillstyle": face, "color": colour}
        ax.plot(points[x], points[y], label=look.label, linestyle="none", zorder=3, **pen)
        if response == main:
            worth = points["word"].isin(NAMED) | (points[x].abs() >= limit)
            # Away from the middle, or to the right of both responses.
            outer = shown[~is_margin].groupby(y)[x].transform("max")[points.index]
            at = points.assign(at=outer if half else points[x])
            _label(ax, at[worth], (x, y), colour, wide=half)


def _label(
    ax: Axes,
    points: pd.DataFrame,
    columns: tuple[str, str],
    colour: str,
    *,
    wide: bool,
) -> None:
    """Write the effects beside column ``at``, those below zero to the left.

    Those that the article names come first, then the larger ones; one whose label would touch
    another has none.
    """
    x, y = columns
    gap = LABEL_GAP + 1.5 * wide
    low, high = ax.get_ylim()
    taken: list[float] = []
    points = points.assign(
        named=points["word"].isin(NAMED), size=points[x].abs(), left=points[x] < 0.0
    )
    points = points.sort_values(["named", "size"], ascending=False)
    for label, at, height, left in points[["label", "at", y, "left"]].itertuples(index=False):
        if any(abs(height - other) < LABEL_HEIGHT * (high - low) for other in taken):
            continue
        taken.append(height)
        ax.annotate(
            label,
            (at, height),
            xytext=(-gap if left else gap, 0.0),
            textcoords="offset points",
            ha="right" if left else "left",
            va="center",
            fontsize=LABEL_SIZE,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
            zorder=2.5,
        )
