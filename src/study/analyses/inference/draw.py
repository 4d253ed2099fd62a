"""Figures of the inference: capture velocities and contacts that the printed statements prefer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from study.figures.declaration import (
    CAPTURE_VELOCITY,
    NORMAL_SPEED,
    RESTITUTION,
    STEEL_LAWS,
    TWO_STAGES,
    WORK_OF_ADHESION,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves

# Distance of the laws of one line, and looks of those that are not a single law.
APART = 0.19
FEW = "few contacts"
BOLD: dict[str, Any] = {"linewidth": 1.6, "markersize": 4.0}
PRINTED: dict[str, Any] = {"color": "0.4", "linewidth": 0.8, "linestyle": "dotted", "zorder": 0}
GREY: dict[str, Any] = {"color": "0.7", "markerfacecolor": "white", "marker": "X"}
SYMBOLS = {"v_c": "$v_c$", "w_A": "$w_A$", "c_A": "$c_A$", "n to": "$n$ to", "J/m2": "J/m$^2$"}
SYMBOLS |= {" deg": "°", " um": " µm"}
# Height of a row over all laws, where one by each law has 1; of a head above its first row; and
# letters in a line of a name.
LOW, HEAD, LETTERS = 0.6, 0.8, 35
HEADS = {"scenario": "Scenarios", "without": "One statement less", "choice": "Other choices"}
LINE: dict[str, Any] = {"markersize": 2.8, "linewidth": 1.1, "linestyle": "none"}
# By law: words and looks; all of them together are bold.
LAWS: dict[str, tuple[str, dict[str, Any]]] = {
    "all laws": ("all laws, by evidence", {"marker": "o", "color": "black", **BOLD}),
    "ring force, n free": ("ring force, $n$ from 0 to 2", {"marker": "s", "color": "C0"}),
    "ring force, n = 0": ("ring force, $n$ = 0", {"marker": "^", "color": "C2"}),
    "JKR, viscous": ("JKR, viscous", {"marker": "D", "color": "C1"}),
    "Thornton and Ning": ("Thornton and Ning", {"marker": "v", "color": "C3"}),
    "hysteresis": ("hysteresis of adhesion", {"marker": "P", "color": "C4"}),
}
# Lines of the small picture, by what they show.
OVERVIEW = {
    "capture velocity of Fig. 16": "printed: Fig. 16, size not stated",
    "capture velocity of SST65": "printed: 0.2 to 0.3 m/s of 49 µm spheres",
    "with the printed v_c": "both, and the printed restitutions",
    "with v_c, van der Waals w_A": "the same, plausible adhesion",
    "without the printed v_c": "restitutions alone",
    "without v_c, van der Waals w_A": "the same, plausible adhesion",
}


# Logarithm of the likelihood ratio at which 95 % end.
LIKELY = -1.92
# Speed above which medians of the laws agree, m/s.
AGREE = 0.3


def ranges_of_printed_and_restitutions(y: Curves) -> Stated:
    """The printed velocities overlap, are narrowed with restitutions, and are unbounded without."""
    (table,) = y.tables.values()
    rows = table.set_index("series")
    ends = rows.loc[[*OVERVIEW], ["y_low", "y_high"]].to_numpy(float)
    fig16, sst65, both, _, alone, _ = ends
    agree = max(fig16[0], sst65[0]) < min(fig16[1], sst65[1])
    narrow = both[1] < 2.0 * both[0] and alone[0] == 0.0
    return stated(agree and narrow, low=both[0], high=both[1], bound=alone[1])


def likelihood_is_flat_towards_rest(y: Curves) -> Stated:
    """Velocities that differ by more than ten are as likely, with n free and nothing printed."""
    curve = y("ring force, n free", "without the printed v_c")
    likely = curve[curve > LIKELY].index
    return stated(likely[-1] > 10.0 * likely[0], low=likely[0], high=likely[-1])


def printed_velocities_fix_it(y: Curves) -> Stated:
    """The range over all laws is less than half as wide, as a factor, with the printed velocities."""
    table = next(table for table in y.tables.values() if "capture velocity" in set(table["panel"]))
    rows = table.set_index("series")
    names = [f"scenario; {words} the printed v_c; all laws" for words in ("with", "without")]
    low, high = rows.loc[names, ["y_low", "y_high"]].to_numpy(float).T
    both, alone = high / low
    return stated(2.0 * both < alone, both=both, alone=alone)


def laws_part_below(y: Curves) -> Stated:
    """Medians of the laws are near each other above a speed, and far at some lower one."""
    panel = "steel-silicon, without the printed v_c"
    laws = [y(law, panel) for law in ("ring force, n free", "ring force, n = 0", "JKR, viscous")]
    apart = np.max(laws, axis=0) - np.min(laws, axis=0)
    agree = apart[laws[0].index >= AGREE].max()
    return stated(2.0 * agree < apart.max(), within=agree, most=apart.max())


@figure(
    "capture_velocity_summary",
    "Capture velocity of steel on silicon: what is printed, and what follows",
    """
        Capture velocity at [[pairs.steel-silicon.diameter_um:g]] µm: printed, and the 95 % interval over
        all laws of contact. The velocity of the smaller spheres is carried to this size by the
        exponent of these laws. An arrow: an upper bound alone. Plausible adhesion: a work of
        adhesion of 0.02 to 0.3 J/m².
    """,
    {"all": ""},
    data=("capture_velocity_summary",),
    equations="25",
    finding="""
        The two printed capture velocities agree with each other. With the restitutions they give
        {low:.2f} to {high:.2f} m/s over all laws; the restitutions alone give an upper bound,
        {bound:.2f} m/s.
    """,
    holds=ranges_of_printed_and_restitutions,
    method="""
        By the statements of figure `evidence`. A bound stands where the profile likelihood does
        not fall towards rest (figure `capture_velocity_profile`); its end is that of 95 % by the
        likelihood ratio.
    """,
    width="double",
    height_mm=62.0,
)
def draw_capture_velocity_summary(sheet: Sheet) -> None:
    """A line each, with its numbers beside it."""
    from matplotlib.ticker import NullLocator

    (ax,) = sheet.panels(xlim=(0.0, 0.3), xlabel=CAPTURE_VELOCITY)
    table = next(iter(sheet.tables.values())).set_index("series")
    lines = [name for name in OVERVIEW if name in table.index]
    for y, name in enumerate(lines):
        row = table.loc[name]
        middle, low, high = row["y_m_per_s"], row["y_low"], row["y_high"]
        colour = "black" if row["evidence"] == "printed" else "C0"
        look: dict[str, Any] = {"color": colour, "linewidth": 2.0, "solid_capstyle": "butt"}
        if low > 0.0:
            mark: dict[str, Any] = {"marker": "D" if colour == "black" else "o", "markersize": 4.0}
            ax.plot([low, middle, high], [y, y, y], markevery=[1], **mark, **look)
            words = f"{low:.2g} to {high:.2g}" if high > 1.1 * low else f"{middle:.2g}"
        else:
            ax.annotate("", (0.0, y), (high, y), arrowprops={"arrowstyle": "->", "color": colour})
            ax.plot(high, y, marker="|", markersize=8.0, **look)
            words = f"at most {high:.2g}"
        offset: dict[str, Any] = {"textcoords": "offset points", "va": "center"}
        ax.annotate(words, (high, y), (4, 0), color=colour, **offset)
    ax.set_yticks(range(len(lines)), [OVERVIEW[name] for name in lines])
    ax.yaxis.set_minor_locator(NullLocator())
    ax.set_ylim(len(lines) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0)


@figure(
    "capture_velocity_profile",
    "Likelihood of the capture velocity of steel on silicon, by law of contact",
    """
        Greatest likelihood of all contacts with a capture velocity, over the greatest of any
        law: no prior is in it. (a) Restitutions and impulse ratios alone, (b) with the two
        printed capture velocities. Line: where 95 % end by the likelihood ratio.
    """,
    {
        "without the printed v_c": "without the printed $v_c$",
        "with the printed v_c": "with the printed $v_c$",
    },
    data=("capture_velocity_profile",),
    equations="25",
    finding="""
        Without the printed capture velocities the likelihood of the ring force with a free rate
        exponent does not tell {low:.3f} from {high:.2f} m/s: it gives an upper bound, and a
        median there is that of the prior.
    """,
    holds=likelihood_is_flat_towards_rest,
    method="""
        The greatest over contacts of the pool, in twenty classes a decade; open angles, sizes and
        normal forces in Coulomb's law are averaged over.
    """,
    height_mm=70.0,
)
def draw_capture_velocity_profile(sheet: Sheet) -> None:
    """Curves of the laws, without and with the printed capture velocities."""
    without, both = sheet.panels(xscale="log", ylim=(-6.0, 0.3), xlabel=CAPTURE_VELOCITY)
    without.set_xlim(0.002, 0.4)
    both.set_xlim(0.08, 0.3)
    for ax in (without, both):
        ax.set_ylabel(r"$\ln$ likelihood, over the greatest")
        sheet.level(ax, LIKELY)
        sheet.draw(ax, STEEL_LAWS)
    sheet.ticks(without.xaxis, (1, 3), decades=True)
    sheet.ticks(both.xaxis, (0.1, 0.15, 0.2, 0.3))
    sheet.keys()


@figure(
    "evidence",
    "Capture velocity and work of adhesion that the article's statements prefer, by law of contact",
    """
        Median and 95 % interval of (a) the capture velocity and (b) the work of adhesion, one
        row per set of statements: scenarios, by law of contact, then the first scenario with one
        statement less, or with another choice. Black: all laws, each with the weight of its
        evidence. Grey: from few contacts. Dotted: printed.
    """,
    {"capture velocity": "capture velocity", "work of adhesion": "work of adhesion"},
    data=("evidence_limits", "evidence_works"),
    equations="25",
    finding="""
        With the two printed capture velocities the range over all laws of contact is a factor of
        {both:.1f}; restitutions alone leave a factor of {alone:.0f}.
    """,
    holds=printed_velocities_fix_it,
    method="""
        At [[pairs.steel-silicon.diameter_um:g]] µm. Each law is weighed by the same statements
        (table evidence_statements) over broad ranges of its parameters (table
        evidence_summary). A law is left out if each of its contacts misses some statement by
        more than two standard errors, of its tails and of the normal about which velocities are
        measured. The article does not say for which size its capture velocity holds.
    """,
    tables={
        "evidence_summary": "Median and 95 % interval of every quantity by scenario and law, evidence "
        "of the law, its standing and what it misses.",
        "evidence_statements": "Interval of each statement, and the value that the contacts of "
        "each scenario and law have.",
        "posterior_contacts": "Contacts drawn from every posterior, with their parameters.",
    },
    height_mm=190.0,
)
def draw_evidence(sheet: Sheet) -> None:
    """A row per scenario, by law of contact; one per omission and choice, over all laws.

    The series are ``kind; name; law``, and `FEW` at the end of those from few contacts; the
    abscissa of the data counts the lines and runs downwards here.
    """
    from study.figures import style

    velocity, work = sheet.panels(xscale="log")
    velocity.set(xlim=(0.008, 0.4), xlabel=CAPTURE_VELOCITY)
    work.set(xlim=(0.002, 12.0), xlabel=WORK_OF_ADHESION)
    sheet.ticks(velocity.xaxis, (1, 3), decades=True)
    sheet.ticks(work.xaxis, (1,), decades=True)
    limits, works = sheet.tables.values()
    _draw_lines(velocity, limits, named=True)
    _draw_lines(work, works, named=False)
    style.legend_above(sheet.figure, (velocity, work))


def _draw_lines(ax: Axes, table: pd.DataFrame, *, named: bool) -> None:
    """Draw the intervals of one quantity; the lines are named at the left one only."""
    from matplotlib.ticker import NullLocator

    from study.figures import style

    is_printed = table["evidence"] == "printed"
    for value in table.loc[is_printed].iloc[:, 4]:
        ax.axvline(value, label="printed $v_c$", **PRINTED)
    names = table.loc[~is_printed, "series"].str.split("; ", expand=True)
    rows = table[~is_printed].assign(kind=names[0], line=names[1], law=names[2])
    # The laws differ by scenario, and hardly by what else is left out or chosen.
    is_all = rows["law"] == "all laws"
    rows = rows[is_all | (rows["kind"] == "scenario") | ~rows["x_1"].isin(rows.loc[is_all, "x_1"])]
    is_few = rows["series"].str.endswith(FEW)
    lines = rows.drop_duplicates("x_1").sort_values("x_1")
    # A head of its own opens each kind.
    kinds = list(dict.fromkeys(lines["kind"]))
    is_low = ~lines["x_1"].isin(rows.loc[rows["law"] != "all laws", "x_1"])
    heights = is_low.map({True: LOW, False: 1.0}).cumsum() + lines["kind"].map(kinds.index)
    height = dict(zip(lines["x_1"], heights, strict=True))
    laws = [law for law in LAWS if law in set(rows["law"])]
    for number, law in enumerate(laws):
        words, look = LAWS[law]
        shift = APART * (number - 0.5 * (len(laws) - 1))
        for grey, label in (({}, words), (GREY, "from few contacts")):
            part = rows[(rows["law"] == law) & (is_few == bool(grey))]
            middle, low, high = part.iloc[:, 4], part["y_low"], part["y_high"]
            by_law = ~part["x_1"].isin(lines.loc[is_low, "x_1"])
            y, error = part["x_1"].map(height) + shift * by_law, [middle - low, high - middle]
            if len(part):
                ax.errorbar(middle, y, xerr=error, capsize=0.0, label=label, **LINE | look | grey)
    ax.set_xlim(style.widened(ax.get_xlim(), rows.iloc[:, [4, 5, 6]].to_numpy(float), log=True))
    ax.set_ylim(max(heights) + 0.6, min(heights) - 1.6)
    heads = [float(heights[lines["kind"] == kind].min()) - HEAD for kind in kinds]
    for head in heads:
        ax.axhline(head, color="0.85", linewidth=0.6, zorder=0)
    names_of_lines = [
        ",\n".join(line.rsplit(", ", maxsplit=len(line) > LETTERS)) for line in lines["line"]
    ]
    words_of_lines = [*names_of_lines, *(HEADS[kind] for kind in kinds)] if named else []
    for name, symbol in SYMBOLS.items():
        words_of_lines = [words.replace(name, symbol) for words in words_of_lines]
    ax.set_yticks([*heights, *heads], words_of_lines)
    ax.yaxis.set_minor_locator(NullLocator())
    ax.tick_params(axis="y", length=0)
    for tick in ax.get_yticklabels():
        tick.set(verticalalignment="center", linespacing=1.0)
    for tick in ax.get_yticklabels()[len(heights) :]:
        tick.set_fontweight("bold")


@figure(
    "posterior_bands",
    "Restitution that the article's statements prefer, by law of contact",
    """
        Restitution against the normal speed over posterior contacts: median and 95 % interval,
        by law of contact, (a, c) without the printed capture velocities and (b, d) with them. Black
        lines: the single contacts of the other figures. Diamonds: printed for oblique impact,
        with their intervals; on the axis: printed capture velocities.
    """,
    {
        "steel-silicon, without the printed v_c": "steel on silicon, without the printed $v_c$",
        "steel-silicon, with the printed v_c": "steel on silicon, with both",
        "fluorescein-molybdenum, without the printed v_c": "fluorescein on molybdenum, without it",
        "fluorescein-molybdenum, with the printed v_c": "fluorescein on molybdenum, with it",
    },
    data=("posterior_bands",),
    equations="25",
    finding="""
        Above 0.3 m/s the laws agree within {within:.2f}; below, they part by up to {most:.2f}, and
        the printed restitutions do not reach there.
    """,
    holds=laws_part_below,
    method="""
        (a, b) [[pairs.steel-silicon.diameter_um:g]] µm; (c, d)
        [[pairs.fluorescein-molybdenum.diameter_um:g]] µm, of which no restitution is printed.
        The restitution of about 0.50 is of "about 10 deg or less": it is drawn at three angles
        from 10 to 5°. Excluded laws are left out. The single contacts of fluorescein are from
        the two force ratios of Fig. 20, with corners of the ranges (c_H = 0, n = 0) that the
        bands leave out.
    """,
    contact=TWO_STAGES,
    height_mm=150.0,
    columns=2,
)
def draw_posterior_bands(sheet: Sheet) -> None:
    """Bands of restitution of each law, without and with the printed capture velocity."""
    printed = {
        "printed for oblique impact": Series("printed for oblique impact", 6),
        "printed": Series("printed $v_c$", 6, open=True),
    }
    fluorescein = {
        "ring force": Series("ring force, $n$ from 0 to 2", 0),
        "fluorescein-molybdenum, least": Series("force ratios, least $v_c$", 6, line="dotted"),
        "fluorescein-molybdenum, nominal": Series("force ratios, nominal", 6, line="dashed"),
        "fluorescein-molybdenum, greatest": Series("force ratios, greatest $v_c$", 6, thin=True),
    }
    axes = sheet.panels(xscale="log", ylim=(0.0, 1.0), xlabel=NORMAL_SPEED, ylabel=RESTITUTION)
    for ax in axes[:2]:
        ax.set_xlim(0.02, 3.0)
        sheet.draw(ax, STEEL_LAWS | printed)
    for ax in axes[2:]:
        ax.set_xlim(0.3, 30.0)
        sheet.draw(ax, fluorescein | printed)
    for ax in axes:
        sheet.ticks(ax.xaxis, (1, 3), decades=True)
    sheet.keys()
