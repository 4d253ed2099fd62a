"""Figs. 4 and 5: where the results agree with the article's description, and where they do not."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

from microimpact.core.constants import gravity
from study.figures.declaration import Remark, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.tables import ResultTables

CASES = "steel-silicon, n = 1", "steel-silicon, n = 0"
PROBE_MM = 1.0
# The plateau that the article names begins at 0.75 m/s.
PLATEAU = (0.75, 1.7)


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
        tables("size_effects")("fallen_speed_m_per_s", case=CASES[0], population=name)
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
        for case in CASES
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
