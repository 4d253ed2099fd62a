"""One experiment of a campaign, by either instrument, as a row of its table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.pdpa import experiment as normal_incidence
from microimpact.lab.ptis import experiment as oblique_incidence
from microimpact.lab.ptis.experiment import quantities
from microimpact.lab.ptis.exposure import (
    CAPTURED,
    MEASURED,
    OFF_SHEET,
    OFF_VIEW,
    SPLIT,
    TOO_SLOW,
    UNMEASURABLE,
)
from microimpact.lab.reduction import Mean
from microimpact.studies.experiments.campaign.plan import Experiment

# What became of the particles, in the words of either instrument.
FATES = {
    "missed": (OFF_SHEET, OFF_VIEW, "incident missed probe", "rebound missed probe"),
    "captured": (CAPTURED,),
    "too_slow": (TOO_SLOW, "incident below probe", "rebound below probe"),
    "not_recorded": (SPLIT, "overlap", "drop-out"),
    "not_measurable": (UNMEASURABLE, "not paired"),
    "measured": (MEASURED, "paired"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What either instrument gives of an experiment.

    Attributes
    ----------
    instrument
        Its name.
    dropped
        Particles dropped.
    fates
        Number of them by `FATES`; they add up to all dropped.
    impacts
        First impacts within the reach of the instrument.
    accepted
        Events averaged, as they truly were.
    events
        Number of events accepted.
    found
        Means that are good enough to be reported.
    """

    instrument: str
    dropped: int
    fates: Mapping[str, int]
    impacts: Impacts
    accepted: Measured
    events: int
    found: Mapping[str, Mean]


def by_imaging(collected: oblique_incidence.Collected, angle_error: float, fewest: int) -> Outcome:
    """Return the outcome of an oblique experiment; the angle's standard error is in degrees."""
    measured, impacts = collected.measured, collected.impacts
    enough = len(measured) >= fewest
    return Outcome(
        instrument="PTIS",
        dropped=collected.dropped,
        fates=_fates(collected.fates),
        impacts=impacts,
        accepted=impacts.in_plane.select(measured.event),
        events=len(measured),
        found=oblique_incidence.reduced(measured, angle_error) if enough else {},
    )


def by_doppler(collected: normal_incidence.Collected, fewest: int) -> Outcome:
    """Return the outcome of a normal experiment; pairs of two different spheres have no truth."""
    measured, seen = collected.measured, collected.observation
    fates = _fates(seen.quality.fates)
    arrived = sum(fates.values())
    height_error = seen.pairing.height_error
    enough = len(measured) >= fewest
    return Outcome(
        instrument="PDPA",
        dropped=collected.dropped,
        fates={**fates, "missed": fates["missed"] + collected.dropped - arrived},
        impacts=seen.impacts.select(slice(arrived)),
        accepted=seen.impacts.in_plane.select(measured.event[measured.event >= 0]),
        events=len(measured),
        found=normal_incidence.reduced(measured, height_error) if enough else {},
    )


def _fates(counted: Mapping[str, int]) -> dict[str, int]:
    # A reason may say more after a colon.
    kinds = {word: kind for kind, words in FATES.items() for word in words}
    fates = dict.fromkeys(FATES, 0)
    for word, number in counted.items():
        kind = kinds.get(word.partition(":")[0])
        if kind:
            fates[kind] += number
    return fates


def experiment_row(one: Experiment, contact_evidence: str, outcome: Outcome) -> dict[str, Any]:
    """Return the row of one experiment: what it is, what was lost, measured, and true."""
    low, high = one.speed_class.speed_range_m_per_s
    smallest, largest = one.particles.diameter_um.quantile(np.array([0.0, 1.0]))
    captured = outcome.impacts.captured
    row: dict[str, Any] = {
        "particles": one.particles.name,
        "material": one.particles.particle,
        "smallest_um": smallest,
        "largest_um": largest,
        "surface": one.surface.name,
        "surface_material": one.surface.surface,
        "slope_sd": float(np.hypot(one.surface.surface_slope, one.particles.particle_slope)),
        "contact_case": one.case,
        "contact_evidence": contact_evidence,
        "angle_deg": one.angle,
        "nominal_speed_m_per_s": one.speed_class.speed_m_per_s,
        "slowest_m_per_s": low,
        "fastest_m_per_s": high,
        "instrument": outcome.instrument,
        "dropped": outcome.dropped,
        **outcome.fates,
        "events": outcome.events,
        "captured_share": float(np.mean(captured)) if captured.size else np.nan,
    }
    everything = quantities(outcome.impacts.in_plane)
    # Friction of a particle that stays is not that of an impact.
    everything["impulse_ratio"] = everything["impulse_ratio"][~captured]
    for name, truth in quantities(outcome.accepted).items():
        of = outcome.found.get(name)
        row[name] = of.value if of else np.nan
        row[f"{name}_low"] = of.low if of else np.nan
        row[f"{name}_high"] = of.high if of else np.nan
        row[f"true_{name}"] = _mean(truth)
        row[f"{name}_of_all"] = _mean(everything[name])
    return {**row, "evidence": "virtual experiment"}


def _mean(values: FloatArray) -> float:
    return float(np.mean(values)) if values.size else np.nan
