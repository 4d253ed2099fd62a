"""Figs. 6 to 12: rebounds at oblique incidence, by face, class of speed and particle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from study.analyses.fig06_12_oblique_experiments import remarks
from study.figures.declaration import (
    ENERGY_LOSS,
    IMPULSE_RATIO,
    OVER_ANGLE,
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

COEFFICIENTS = {"restitution": "", "impulse_ratio": "", "energy_loss": ""}
SMOOTH = {"computed": "computed (solid, dotted: mean size, smooth surfaces)"}
NO_SPIN = {"computed": "computed: mean size, no spin"}
# Methods of Figs. 6, 7, 11 and 12, and of Figs. 8 to 10.
MEASURED = """
    Particles are dropped on the tilted target, imaged by a virtual light sheet and
    camera (PTIS, a form of particle tracking velocimetry), measured and averaged over
    [[stop.events]] events.
"""
IMAGED = f"""
    {MEASURED} Smooth curves are of the mean size, without spread or
    instrument; front and back of one contact share their curve. Black, dashed: the rigid
    body model with Coulomb friction of the same coefficient. Off-scale means are given
    at the top. There is no mark at 90°, where both tracks coincide, and none where
    fewer than [[stop.fewest_events]] events could be measured. Where marks lie on a
    smooth curve, the agreement is by construction.
"""
SPINNING = f"""
    {MEASURED} Contact [[series.1.60 m/s.case]]. The initial spin r omega has a
    standard deviation of [[series.0.45 m/s.spin.sd:g]] v per axis and mean zero
    (assumed); one series has a mean spin of [[series.0.45 m/s, spun.spin.mean:g]] v
    about the tilt axis. There is no mark where fewer than [[stop.fewest_events]] events
    could be measured. Agreement of marks and curves of one contact is by construction.
"""

FAST, MIDDLE, SLOW = (
    f"class of {speed}, at [[series.{speed}.speed_m_per_s:.2f]]"
    for speed in ("1.60 m/s", "1.05 m/s", "0.45 m/s")
)
CLASSES = {
    "1.60 m/s": Series(FAST, 0),
    "1.05 m/s": Series(MIDDLE, 1, open=True),
    "0.45 m/s": Series(SLOW, 2, mark="square"),
    "0.45 m/s, spun": Series(
        f"{SLOW}, mean spin [[series.0.45 m/s, spun.spin.mean:g]] $v/r$",
        3,
        mark="triangle",
        open=True,
    ),
    "1.60 m/s, smooth": Series(FAST, 0),
    "1.05 m/s, smooth": Series(MIDDLE, 1, line="dotted"),
    "0.45 m/s, smooth": Series(SLOW, 2, line="dashdot"),
    "0.45 m/s, spun, smooth": Series(SLOW, 2, line="dashdot"),
    "0.45 m/s, all rebounds": Series(f"{SLOW}, all rebounds", 2, line="dashed"),
    "printed, 85 deg": Series("printed, fastest class", 0),
    "printed, 25 deg": Series("_printed", 0),
    "Coulomb friction": Series("Coulomb friction, no spin", 6, line="dashed"),
    "printed plateau": Series("ends of the printed plateau", 6),
}


def compared(filled: tuple[str, str, int], hollow: tuple[str, str, int]) -> dict[str, Series]:
    """Return the series of two experiments, each given as name, words and colour.

    Curves of the same contacts on smooth surfaces and of Coulomb friction are with them.
    """
    (first, words, colour), (second, second_words, second_colour) = filled, hollow
    return {
        first: Series(words, colour),
        second: Series(second_words, second_colour, open=True),
        f"{first}, smooth": Series(words, colour),
        f"{second}, smooth": Series(second_words, second_colour, line="dotted"),
        "Coulomb friction": Series("Coulomb friction", 6, line="dashed"),
        "printed plateau": Series("_printed", 6),
    }


def faces(surface: str) -> dict[str, Series]:
    """Return the series of the front and the rough back of a surface."""
    front, back = f"{surface} front", f"{surface} back"
    return {
        **compared(
            (front, "front", 0),
            (back, "back", 1),
        ),
        f"{back}, all rebounds": Series("back, all rebounds", 1, line="dashed"),
    }


def particles(spore: str, steel: str) -> dict[str, Series]:
    """Return the series of spores and of steel on one surface."""
    return compared(
        (spore, f"[[series.{spore}.case.particle]]", 1),
        (steel, f"[[series.{steel}.case.particle]]", 0),
    )


def draw_coefficients(
    sheet: Sheet,
    series: Mapping[str, Series],
    highest_ratio: float = 0.4,
    printed_range: str = "",
) -> None:
    """Draw restitution on a logarithmic axis, impulse ratio up to the highest, and energy loss."""
    limits = (0.3, 6.0), (-0.1, highest_ratio), (0.0, 0.8)
    words = RESTITUTION, IMPULSE_RATIO, ENERGY_LOSS
    axes = sheet.panels(**OVER_ANGLE)
    axes[0].set_yscale("log")
    sheet.ticks(axes[0].yaxis, (0.3, 0.5, 1.0, 2.0, 4.0))
    if printed_range:
        ends = sheet.take(axes[0], printed_range).iloc[:, 4]
        look: dict[str, Any] = {"color": "C0", "alpha": 0.12, "linewidth": 0, "zorder": 0}
        axes[0].axhspan(ends.min(), ends.max(), label="printed range, front", **look)
    for ax, ylim, ylabel in zip(axes, limits, words, strict=True):
        ax.set(ylim=ylim, ylabel=ylabel)
        sheet.draw(ax, series, fixed=True)
    sheet.keys()


def draw_classes(sheet: Sheet, words: str, ends: tuple[float, float]) -> None:
    """Draw one coefficient against the angle, by class of speed."""
    (ax,) = sheet.panels(**OVER_ANGLE, ylim=ends, ylabel=words)
    sheet.draw(ax, CLASSES, fixed=True)
    sheet.keys()


def roughness_alone_raises(y: Curves) -> Stated:
    """Both faces have one smooth curve, and the marks of the back rise above one."""
    front, back = (y(f"silicon {face}, smooth", "restitution") for face in ("front", "back"))
    most = y("silicon back", "restitution").max()
    return stated((front - back).abs().max() < 0.01 and most > 1.0, back=most)


@figure(
    "fig06",
    "Front and back of [[series.silicon front.case.surface]] at [[series.silicon front.speed_m_per_s:.2f]] m/s, as a PTIS would measure it",
    """
        Restitution, impulse ratio and loss of translational energy against the angle of
        incidence at [[series.silicon front.speed_m_per_s:.2f]] m/s, for the front (shaded) and
        the back (open) of [[series.silicon back.case.surface]]. Marks: virtual experiments with
        95 % intervals. Coloured curves: the same contacts on smooth surfaces; dashed: all
        rebounds, seen or not. Black: Coulomb friction.
    """,
    COEFFICIENTS,
    data=("fig06",),
    equations="1, 2, 3, 12, 13, 25, 27, 35, 36",
    article="""
        Measured restitution, impulse ratio and energy loss against the angle, steel SST76 on
        the smooth face and the rough back of silicon at 1.66 m/s, with a curve of Coulomb
        friction without initial spin.
    """,
    finding="""
        A rough back face raises the measured restitution at shallow angles to {back:.1f},
        although its contact is that of the front.
    """,
    disagreement=remarks.FIG06_DISAGREEMENT,
    agreement=remarks.FIG06_AGREEMENT,
    holds=roughness_alone_raises,
    method=IMAGED,
    as_shipped="""
        The front of the wafer is polished, the back lapped, with assumed slopes of
        [[series.silicon back.surface_slope:.2f]] rad per axis; contacts
        [[series.silicon front.case]] and [[series.silicon back.case]]. Diamonds: values printed
        in the article, in pairs where it prints a range.
    """,
    contact=TWO_STAGES,
    tables={
        "oblique_experiments": "Every experiment of Figs. 6 to 12: means, intervals, and fates of the particles.",
    },
    evidence_labels=SMOOTH,
)
def draw_fig06(sheet: Sheet) -> None:
    """Both faces of the wafer."""
    printed = {
        "printed, exceeded below": Series("back", 1, side="right", beside=20),
        "printed, smooth": Series("_printed", 0),
        "printed, smooth, shallow": Series("_printed", 0),
    }
    draw_coefficients(sheet, faces("silicon") | printed)


def faces_differ(y: Curves) -> Stated:
    """The smooth curves differ at normal incidence, and the rough marks rise at shallow angles."""
    front, back = (
        y(f"mirror {face}, smooth", "restitution").iloc[-1] for face in ("front", "back")
    )
    is_rough = y("mirror back", "restitution").iloc[0] > 1.0
    return stated(front - back > 0.01 and is_rough, front=front, back=back)


@figure(
    "fig07",
    "Front and back of [[series.mirror front.case.surface]] at [[series.mirror front.speed_m_per_s:.2f]] m/s, as a PTIS would measure it",
    """
        Restitution, impulse ratio and loss of translational energy against the angle of
        incidence at [[series.mirror front.speed_m_per_s:.2f]] m/s, for the front (shaded) and
        the back (open) of [[series.mirror back.case.surface]]. Marks: virtual experiments with
        95 % intervals. Coloured curves: the same contacts on smooth surfaces; dashed: all
        rebounds, seen or not. Black: Coulomb friction.
    """,
    COEFFICIENTS,
    data=("fig07",),
    equations="1, 2, 3, 12, 13, 25, 27, 35, 36",
    article="""
        The same three quantities for steel SST76 on the front and the rough back of a mirror at
        1.66 m/s.
    """,
    finding="""
        Both differences between the faces are inputs: the restitution, {front:.2f} of the
        front and {back:.2f} of the back at steep angles, and the roughness of the back.
    """,
    agreement=remarks.FIG07_AGREEMENT,
    holds=faces_differ,
    method=IMAGED,
    as_shipped="""
        The slopes of the back, [[series.mirror back.surface_slope:.2f]] rad per axis, are
        assumed, and so is its lower restitution; contacts [[series.mirror front.case]] and
        [[series.mirror back.case]]. Shaded: the range printed for the front of the mirror, at all
        angles; of the back the article prints only that e is lower.
    """,
    evidence_labels=SMOOTH,
)
def draw_fig07(sheet: Sheet) -> None:
    """Both faces of the mirror."""
    draw_coefficients(sheet, faces("mirror"), printed_range="printed, front")


def restitution_falls_with_speed(y: Curves) -> Stated:
    """The slowest class rebounds clearly less at the steepest angle."""
    fast, slow = y("1.60 m/s"), y("0.45 m/s")
    angle = slow.index[-1]
    return stated(
        fast[angle] - slow[angle] > 0.05, angle=angle, fast=fast[angle], slow=slow.iloc[-1]
    )


@figure(
    "fig08",
    "Restitution at several speeds, as a PTIS would measure it",
    """
        Restitution of [[series.1.60 m/s.case.pair]] against the angle of incidence, by class of
        speed. Marks: virtual experiments, each sphere with a random initial spin. Curves: the
        mean sphere without spin or instrument; "all rebounds" is the true mean, seen or not. A
        mark can lie where the mean sphere is captured.
    """,
    {"restitution": ""},
    data=("fig08",),
    equations="1, 25, 27",
    article="""
        Measured restitution of steel SST65 on smooth silicon against the angle at three speeds:
        1.60, 1.05 and 0.45 m/s.
    """,
    finding="""
        At {angle:.0f}° restitution falls from {fast:.2f} in the fastest class to {slow:.2f}
        in the slowest, as adhesion takes a larger share.
    """,
    disagreement=remarks.FIG08_DISAGREEMENT,
    agreement=remarks.FIG08_AGREEMENT,
    holds=restitution_falls_with_speed,
    method=SPINNING,
    as_shipped="""
        Each class of speed is named by the middle of the range that is printed for it. The
        article calls the fall between the classes slight. In the slowest class the camera misses
        more than half of the rebounds at steep angles, mainly the slow ones, so that the measured
        means are slightly too high. Diamonds: values printed in the article.
    """,
    contact=TWO_STAGES,
    evidence_labels=NO_SPIN,
    height_mm=85.0,
)
def draw_fig08(sheet: Sheet) -> None:
    """Restitution of three classes, and of the slowest one spun."""
    draw_classes(sheet, RESTITUTION, (0.0, 1.0))


def spin_lowers_adhesion_raises(y: Curves) -> Stated:
    """The spun marks fall with the angle to below zero; the slow ones begin above the fast."""
    spun, slow, fast = y("0.45 m/s, spun"), y("0.45 m/s"), y("1.60 m/s")
    angle = slow.index[0]
    return stated(
        spun.idxmin() == spun.index[-1] and spun.min() < 0.0 and slow[angle] > fast[angle]
    )


@figure(
    "fig09",
    "Impulse ratio at several speeds, as a PTIS would measure it",
    """
        Impulse ratio of [[series.1.60 m/s.case.pair]] against the angle of incidence, by class
        of speed. Marks: virtual experiments, each sphere with a random initial spin. Curves:
        the mean sphere without spin or instrument. Dashed: the rigid body model with Coulomb
        friction of the same coefficient, without spin.
    """,
    {"impulse_ratio": ""},
    data=("fig09",),
    equations="2, 12, 13, 25, 27",
    article="""
        Measured impulse ratio of the same impacts as in Fig. 8, with a curve of Coulomb
        friction from the rigid body model.
    """,
    finding="""
        A mean spin brings the impulse ratio to zero and below, but most at steep angles;
        adhesion at low speed raises it.
    """,
    disagreement=remarks.FIG09_DISAGREEMENT,
    agreement=remarks.FIG09_AGREEMENT,
    holds=spin_lowers_adhesion_raises,
    method=SPINNING,
    as_shipped="""
        Each class of speed is named by the middle of the range that is printed for it. The
        article finds the ratio at or below zero at shallow angles, not at steep ones; no spin
        that is the same at all angles gives that. Diamonds: ends of the printed plateau.
    """,
    contact=TWO_STAGES,
    evidence_labels=NO_SPIN,
    height_mm=85.0,
)
def draw_fig09(sheet: Sheet) -> None:
    """Impulse ratio of three classes, and of the slowest one spun."""
    draw_classes(sheet, IMPULSE_RATIO, (-0.2, 0.3))


def slow_lose_more(y: Curves) -> Stated:
    """The slowest class loses most at every angle, and less with a mean spin."""
    fast, slow, spun = y("1.60 m/s"), y("0.45 m/s"), y("0.45 m/s, spun")
    more = (slow > fast[slow.index]).all() and (spun < slow).all()
    return stated(more, slow=100.0 * slow.max(), fast=100.0 * fast.max())


@figure(
    "fig10",
    "Energy loss at several speeds, as a PTIS would measure it",
    """
        Loss of translational energy of [[series.1.60 m/s.case.pair]] against the angle of
        incidence, by class of speed. Marks: virtual experiments, each sphere with a random
        initial spin. Curves: the mean sphere without spin or instrument.
    """,
    {"energy_loss": ""},
    data=("fig10",),
    equations="3, 14, 25, 27",
    article="Measured energy loss of the same impacts as in Fig. 8.",
    finding="""
        The slowest spheres lose up to {slow:.0f} % of their energy, the fastest {fast:.0f}
        %; a mean spin lowers the loss.
    """,
    holds=slow_lose_more,
    method=SPINNING,
    contact=TWO_STAGES,
    evidence_labels=NO_SPIN,
    height_mm=85.0,
)
def draw_fig10(sheet: Sheet) -> None:
    """Energy loss of three classes, and of the slowest one spun."""
    draw_classes(sheet, ENERGY_LOSS, (0.0, 1.0))


def spores_rise_and_do_not_fall(y: Curves) -> Stated:
    """Only spores exceed one; from one printed angle to the other they fall by less than half."""
    spore, steel = (y(name, "restitution") for name in ("spore on silicon", "steel on silicon"))
    high, low = (y(f"printed, spore, {angle} deg") for angle in (48, 38))
    ends = high.index[0], low.index[0]
    upper, lower = np.interp(ends, spore.index, spore)
    is_flat = upper - lower < 0.5 * (high.iloc[0] - low.iloc[0])
    return stated(spore.max() > 1.0 > steel.max() and is_flat, high=ends[0], low=ends[1])


@figure(
    "fig11",
    "Rebounds of [[series.spore on silicon.case.pair]] and [[series.steel on silicon.case.pair]], as a PTIS would measure them",
    """
        Restitution, impulse ratio and loss of translational energy against the angle of
        incidence, for [[series.spore on silicon.case.pair]] (shaded) and
        [[series.steel on silicon.case.pair]] (open). Marks: virtual experiments with 95 %
        intervals. Coloured curves: the same contacts, smooth; dashed: all rebounds of the rough
        particles, seen or not. Black: Coulomb friction.
    """,
    COEFFICIENTS,
    data=("fig11",),
    equations="1, 2, 3, 12, 13, 25, 27, 35, 36",
    article="""
        Measured restitution, impulse ratio and energy loss of Lycopodium spores and of steel
        SST76 on silicon, against the angle.
    """,
    finding="""
        Rough [[series.spore on silicon.case.particle]] reaches a restitution above one at
        shallow angles, [[series.steel on silicon.case.particle]] does not; the
        fall that is printed between {high:.0f}° and {low:.0f}° is not obtained.
    """,
    disagreement=remarks.FIG11_DISAGREEMENT,
    agreement=remarks.FIG11_AGREEMENT,
    holds=spores_rise_and_do_not_fall,
    method=IMAGED,
    as_shipped="""
        Lycopodium spores are not spheres; their slopes,
        [[series.spore on silicon.particle_slope:.2f]] rad per axis, are assumed. Speeds are
        [[series.spore on silicon.speed_m_per_s:.2f]] m/s for spores and
        [[series.steel on silicon.speed_m_per_s:.2f]] m/s for steel. Diamonds: values printed in
        the article.
    """,
    contact=TWO_STAGES,
    evidence_labels=SMOOTH,
)
def draw_fig11(sheet: Sheet) -> None:
    """Spores and steel on silicon."""
    spore = "spore on silicon"
    more = {
        f"{spore}, all rebounds": Series(
            f"[[series.{spore}.case.particle]], all rebounds", 1, line="dashed"
        ),
        "printed, spore, 48 deg": Series("_printed", 1),
        "printed, spore, 38 deg": Series("printed", 1, beside=38, side="below"),
    }
    draw_coefficients(sheet, particles(spore, "steel on silicon") | more)


def both_seem_faster(y: Curves) -> Stated:
    """Restitution of both exceeds one at the shallowest angle, and both lose energy at all."""
    particles = "steel on Formica", "spore on Formica"
    exceeds = all(y(name, "restitution").iloc[0] > 1.0 for name in particles)
    losses = [y(name, "energy_loss") for name in particles]
    least, most = min(map(min, losses)), max(map(max, losses))
    return stated(exceeds and least > 0.0, least=100.0 * least, most=100.0 * most)


@figure(
    "fig12",
    "Rebounds of [[series.spore on Formica.case.pair]] and [[series.steel on Formica.case.pair]], as a PTIS would measure them",
    """
        Restitution, impulse ratio and loss of translational energy against the angle of
        incidence, for [[series.spore on Formica.case.pair]] (shaded) and
        [[series.steel on Formica.case.pair]] (open). Marks: virtual experiments with 95 %
        intervals. Coloured curves: the same contacts, smooth; dashed, dash-dotted: all
        rebounds, seen or not. Black: Coulomb friction.
    """,
    COEFFICIENTS,
    data=("fig12",),
    equations="1, 2, 3, 12, 13, 25, 27, 35, 36",
    article="The same for Lycopodium spores and steel SST76 on Formica.",
    finding="""
        At shallow angles both particles seem to leave with a larger normal velocity than
        they arrive with, although they lose {least:.0f} to {most:.0f} % of their energy.
    """,
    disagreement=remarks.FIG12_DISAGREEMENT,
    agreement=remarks.FIG12_AGREEMENT,
    holds=both_seem_faster,
    method=IMAGED,
    as_shipped="""
        Lycopodium spores are not spheres; all slopes are assumed:
        [[series.spore on Formica.surface_slope:.2f]] rad per axis of the surface and
        [[series.spore on Formica.particle_slope:.2f]] of the spores. Diamonds: values printed
        in the article.
    """,
    evidence_labels=SMOOTH,
)
def draw_fig12(sheet: Sheet) -> None:
    """Spores and steel on Formica."""
    spore, steel = "spore on Formica", "steel on Formica"
    more = {
        f"{spore}, all rebounds": Series(
            f"[[series.{spore}.case.particle]], all rebounds", 1, line="dashdot"
        ),
        f"{steel}, all rebounds": Series(
            f"[[series.{steel}.case.particle]], all rebounds", 0, line="dashed"
        ),
        "printed, exceeded below": Series("_printed", 0),
    }
    draw_coefficients(sheet, particles(spore, steel) | more, highest_ratio=0.6)
