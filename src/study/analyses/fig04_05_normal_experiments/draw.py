"""Figs. 4, 5: restitution and energy loss at normal incidence, by sieve class."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from microimpact.core.constants import gravity
from study.figures.declaration import (
    ENERGY_LOSS,
    NORMAL_SPEED,
    RESTITUTION,
    TWO_STAGES,
    Remark,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves, ResultTables

CONTACTS = "steel-silicon, n = 1", "steel-silicon, n = 0"
PROBE_MM = 1.0
# The plateau that the article names begins at 0.75 m/s.
PLATEAU = (0.75, 1.7)

# The marks of the analyser, then all spheres that rebound, without it.
CLASSES = {
    "SST65": Series("SST65, virtual experiment", 0),
    "SST125": Series("SST125, virtual experiment", 1, open=True),
    "SST65 sieve": Series("SST65, all that rebound, [[case]]", 0),
    "SST125 sieve": Series("SST125, all that rebound, [[case]]", 1, line="dashed"),
}
# At the curves, of which two more are of the other end of the contacts.
NAMED = CLASSES | {
    "SST65 sieve": Series("SST65, [[case]]", 0, beside=1.7, side="right"),
    "SST125 sieve": Series("SST125, [[case]]", 1, line="dashed", beside=1.7, side="right"),
    "SST65 sieve, other end": Series(
        "SST65, [[other_case]]", 0, line="dotted", beside=1.4, side="below"
    ),
    "SST125 sieve, other end": Series("SST125, [[other_case]]", 1, line="dotted", beside=1.2),
}


def plateaus_are_flat(tables: ResultTables) -> Stated:
    """Each class keeps its restitution within a tenth above 0.75 m/s, but not below."""
    small, large = (
        tables("normal_experiments").all(
            "restitution", population=name, nominal_speed_m_per_s=PLATEAU
        )
        for name in ("SST65", "SST125")
    )
    slowest = tables("normal_experiments")(
        "true_restitution_of_rebounds", population="SST65", nominal_speed_m_per_s=0.3
    )
    flat = all(max(level) - min(level) < 0.1 * max(level) for level in (small, large))
    flat &= min(small) > slowest + 0.1
    return stated(flat, low=min(small), high=max(small), lower=min(large), higher=max(large))


def smaller_fall_first(tables: ResultTables) -> Stated:
    """The smaller class falls to nine tenths of its plateau at the higher speed."""
    small, large = (
        tables("size_effects")("fallen_speed_m_per_s", case=CONTACTS[0], population=name)
        for name in ("SST65", "SST125")
    )
    return stated(small > large, small=small, large=large)


def probe_overstates_slow_rebounds(tables: ResultTables) -> Stated:
    """The analyser sees a higher mean than all spheres that rebound have."""
    slow = {"population": "SST65", "nominal_speed_m_per_s": 0.3}
    speed, seen, true = (
        tables("normal_experiments")(column, **slow)
        for column in ("speed_m_per_s", "restitution", "true_restitution_of_rebounds")
    )
    limit = sqrt(2.0 * gravity * PROBE_MM * 1e-3)
    return stated(seen > true + 0.05, speed=speed, seen=seen, true=true, limit=limit)


def printed_correction_raises(tables: ResultTables) -> Stated:
    """The printed correction for the height of the probe raises restitution, more at low speed."""
    fast, slow = (
        tables("surface_correction")(
            "printed", quantity="e", probe_height_mm=PROBE_MM, speed_m_per_s=v, restitution=e
        )
        for v, e in ((1.6, 0.7), (0.5, 0.4))
    )
    return stated(slow > fast > 0.0, fast=fast, slow=slow)


def plateaus_differ(tables: ResultTables) -> Stated:
    """The larger class keeps the higher restitution at the highest speed."""
    both = [
        tables("size_effects")("restitution_at_highest_speed", case=case, population="SST125")
        - tables("size_effects")("restitution_at_highest_speed", case=case, population="SST65")
        for case in CONTACTS
    ]
    return stated(min(both) > 0.01, least=min(both), most=max(both))


def repeated_bounces_end_in_capture(tables: ResultTables) -> Stated:
    """With the printed capture velocity piles begin above 0.3 m/s, with a tenth of it within."""
    strong, weak = (
        tables("pile_up_onsets")(
            "onset_m_per_s", contact=contact, target_radius_mm=5.0, slope_deg=2.0, share=0.5
        )
        for contact in ("printed", "lower")
    )
    return stated(strong > 0.35 > weak, strong=strong, weak=weak)


def loss_grows_towards_capture(tables: ResultTables) -> Stated:
    """The slowest experiment of the smaller class loses more than the fastest."""
    losses = tables("normal_experiments").all("energy_loss", population="SST65")
    return stated(losses[0] > losses[-1], slow=losses[0], fast=losses[-1])


def probe_understates_losses(tables: ResultTables) -> Stated:
    """The loss by the analyser is below the loss by the mean restitution of all rebounds."""
    slow = {"population": "SST65", "nominal_speed_m_per_s": 0.3}
    seen, true = (
        tables("normal_experiments")(column, **slow)
        for column in ("energy_loss", "true_restitution_of_rebounds")
    )
    return stated(1.0 - true**2 > seen + 0.05, seen=seen, true=1.0 - true**2)


FIG04_AGREEMENT = (
    Remark(
        "Restitution is constant above about 0.75 m/s: {low:.2f} to {high:.2f} for SST65, "
        "{lower:.2f} to {higher:.2f} for SST125. The article prints no value for these impacts; "
        "for oblique impact it prints about 0.70.",
        plateaus_are_flat,
    ),
    Remark(
        "At lower speeds it falls, for smaller spheres already at higher speeds: to nine tenths "
        "of the plateau at {small:.2f} m/s for SST65 and at {large:.2f} m/s for SST125.",
        smaller_fall_first,
    ),
)
FIG04_DISAGREEMENT = (
    Remark(
        "The probe cannot see the fall of restitution near capture. A sphere that rebounds "
        "below {limit:.2f} m/s never reaches a probe 1 mm above the surface. At {speed:.2f} m/s "
        "the instrument measures {seen:.2f} for SST65, but the spheres that rebound have "
        "{true:.2f}.",
        probe_overstates_slow_rebounds,
    ),
    Remark(
        "The article names no difference between the plateaus of the two classes. Here they "
        "differ by {least:.2f} to {most:.2f} at the highest speed, depending on the contact.",
        plateaus_differ,
    ),
    Remark(
        "Piles are reported at 0.2 to 0.3 m/s. Spheres bounce repeatedly, each time more "
        "slowly, so that half of all stay on a target of 5 mm radius already at {strong:.2f} "
        "m/s if v_c is 0.18 m/s, and at {weak:.2f} m/s if it is 0.02 m/s. The lower value "
        "agrees better, but target, scatter and stream are assumed, so that it decides nothing "
        "(C66).",
        repeated_bounces_end_in_capture,
    ),
    Remark(
        "The printed correction for the height of the probe adds the same speed before and "
        "after the impact. This raises restitution by {fast:.2f} at 1.6 m/s and by {slow:.2f} "
        "at 0.5 m/s; the figure uses the exact correction.",
        printed_correction_raises,
    ),
)
FIG05_AGREEMENT = (
    Remark(
        "The loss grows as the speed falls, from {fast:.0%} in the fastest experiment with "
        "SST65 to {slow:.0%} in the slowest.",
        loss_grows_towards_capture,
    ),
)
FIG05_DISAGREEMENT = (
    Remark(
        "The probe misses the slowest rebounds and so understates the loss. At 0.3 m/s SST65 "
        "appears to lose {seen:.0%} of its energy; the mean restitution of all that rebound "
        "gives {true:.0%}.",
        probe_understates_losses,
    ),
)


def larger_keep_theirs(y: Curves) -> Stated:
    """The larger rebound from lower speeds; the slowest marks lie above their curves."""
    small, large = y("SST65 sieve"), y("SST125 sieve")
    overstated = [
        y(name).iloc[0] > np.interp(y(name).index[0], curve.index, curve)
        for name, curve in (("SST65", small), ("SST125", large))
    ]
    return stated(large.index[0] < small.index[0] and all(overstated))


@figure(
    "fig04",
    "Restitution at normal incidence, as a PDPA would measure it",
    """
        Restitution against the normal impact speed for [[populations]] of
        [[case.particle]] on smooth [[case.surface]]. Marks: virtual experiments with 95 %
        intervals. Curves: all spheres that rebound, without the instrument.
    """,
    {"all": ""},
    data=("fig04",),
    equations="1, 2.1 incident, 2.1 rebound, 25",
    article="""
        Measured restitution of steel spheres of two mean diameters, 49 and 75 µm, on smooth
        silicon at normal incidence, with error bars.
    """,
    finding="""
        Larger spheres keep their restitution to lower speeds, and a probe above the surface
        overstates the slowest.
    """,
    disagreement=FIG04_DISAGREEMENT,
    agreement=FIG04_AGREEMENT,
    holds=larger_keep_theirs,
    method="""
        Particles are dropped, recorded by a virtual phase Doppler particle analyser
        [[instrument.probe_height_mm:g]] mm above the surface, paired, corrected, and averaged
        over [[stop.events]] events, or at least [[stop.fewest_events]] where rebounds are rare.
        The contact is [[case]].
    """,
    as_shipped="""
        In its name, n is the rate exponent of the adhesion damping, whose coefficient falls with
        the impact speed as v^-n.
        SST65 are the spheres of [[populations.SST65.diameter_um.low:.0f]] to
        [[populations.SST65.diameter_um.high:.0f]] µm (shaded marks), SST125 those of
        [[populations.SST125.diameter_um.low:.0f]] to
        [[populations.SST125.diameter_um.high:.0f]] µm (open marks). The slowest marks lie above
        the curves because slow rebounds do not reach the probe again; above about 0.5 m/s both
        agree by construction. The article prints no level for these impacts. Grey: the speeds at
        which it saw particles pile up.
    """,
    contact=TWO_STAGES,
    tables={
        "normal_experiments": "Every experiment of Figs. 4 and 5, with the fates of the particles that were dropped.",
        "size_effects": "Speeds of capture, and of the fall of restitution, by size class.",
    },
    height_mm=95.0,
)
def draw_fig04(sheet: Sheet) -> None:
    """Restitution against the normal speed."""
    (ax,) = sheet.panels(xlim=(0.0, 2.1), ylim=(0.0, 1.0), xlabel=NORMAL_SPEED, ylabel=RESTITUTION)
    sheet.piled_up(ax)
    sheet.draw(ax, NAMED, fixed=True)
    sheet.legend(ax, "lower right")
    sheet.keys()


def smaller_lose_more(y: Curves) -> Stated:
    """The curve of the smaller class lies above the curve of the larger."""
    small, large = y("SST65 sieve"), y("SST125 sieve")
    more = small > np.interp(small.index, large.index, large)
    return stated(more.all() and small.max() > 0.9, most=100.0 * small.max())


@figure(
    "fig05",
    "Energy loss at normal incidence, as a PDPA would measure it",
    """
        Fraction of the kinetic energy lost, from the events of Fig. 4: [[populations]] of
        [[case.particle]] on smooth [[case.surface]]. Curves: 1 - e^2 of the mean restitution of
        the spheres that rebound, for the contact [[case]]. Agreement away from capture is by
        construction.
    """,
    {"all": ""},
    data=("fig05",),
    equations="3, 2.1 incident, 2.1 rebound, 2.3.1 normal loss, 25",
    article="Measured energy loss of the same impacts as in Fig. 4.",
    finding="""
        Near capture {most:.0f} % of the energy is lost, and the smaller spheres lose more
        at every speed.
    """,
    disagreement=FIG05_DISAGREEMENT,
    agreement=FIG05_AGREEMENT,
    holds=smaller_lose_more,
    as_shipped="""
        Filled: SST65, the smaller spheres; open: SST125. Grey: the speeds at which the article
        saw particles pile up.
    """,
    contact=TWO_STAGES,
    height_mm=85.0,
)
def draw_fig05(sheet: Sheet) -> None:
    """Energy loss against the normal speed."""
    (ax,) = sheet.panels(xlim=(0.0, 1.8), ylim=(0.4, 1.0), xlabel=NORMAL_SPEED, ylabel=ENERGY_LOSS)
    sheet.piled_up(ax)
    sheet.draw(ax, CLASSES)
    sheet.legend(ax, "upper right")
    sheet.keys()
