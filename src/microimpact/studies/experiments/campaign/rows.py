"""One experiment of a campaign, by either instrument, as a row of its table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.lab.experiment import Outcome
from microimpact.lab.pdpa.experiment import UNREACHED
from microimpact.lab.ptis.exposure import (
    CAPTURED,
    MEASURED,
    OFF_SHEET,
    OFF_VIEW,
    SPLIT,
    TOO_SLOW,
    UNMEASURABLE,
)
from microimpact.lab.reduction import quantities
from microimpact.studies.experiments.campaign.plan import Experiment

# Angle of incidence that the analyser sees; the imaging system sees all others.
NORMAL = 90.0
# What became of the particles, in the words of either instrument.
FATES = {
    "missed": (OFF_SHEET, OFF_VIEW, UNREACHED, "incident missed probe", "rebound missed probe"),
    "captured": (CAPTURED,),
    "too_slow": (TOO_SLOW, "incident below probe", "rebound below probe"),
    "not_recorded": (SPLIT, "overlap", "drop-out"),
    "not_measurable": (UNMEASURABLE, "not paired"),
    "measured": (MEASURED, "paired"),
}


def fates_of(counted: Mapping[str, int]) -> dict[str, int]:
    """Return the number of particles by `FATES`; they add up to all dropped."""
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
    first = outcome.first_impacts
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
        "instrument": "PDPA" if one.angle == NORMAL else "PTIS",
        "dropped": outcome.dropped,
        **fates_of(outcome.fates),
        "events": len(outcome.measured),
        "captured_share": float(np.mean(first.captured)) if len(first) else np.nan,
    }
    everything = quantities(first.in_plane)
    # Friction of a particle that stays is not that of an impact.
    everything["impulse_ratio"] = everything["impulse_ratio"][~first.captured]
    for name, truth in quantities(outcome.true).items():
        of = outcome.means.get(name)
        row[name] = of.value if of else np.nan
        row[f"{name}_low"] = of.low if of else np.nan
        row[f"{name}_high"] = of.high if of else np.nan
        row[f"true_{name}"] = _mean(truth)
        row[f"{name}_of_all"] = _mean(everything[name])
    return {**row, "evidence": "virtual experiment"}


def _mean(values: FloatArray) -> float:
    return float(np.mean(values)) if values.size else np.nan
