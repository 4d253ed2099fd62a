"""Pair search in the records of a phase Doppler particle analyser, and correction to the surface.

Virtual experiments on normal impacts (Section 2.1): does the height of the probe volume matter to
the identification of pairs, what does the constant correction do to velocities and restitution,
and what becomes of rebounds too slow to reach the probe volume?
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.constants import gravity
from microimpact.declared.parameters import CaseName, Count, Positive
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.pdpa.analyser import REBOUND, Instrument
from microimpact.lab.pdpa.observation import FATES, Observation, ratio
from microimpact.statistics.distributions import Distribution
from microimpact.statistics.intervals import mean_and_error, wilson_interval
from microimpact.studies.experiments.pair_search.controls import Control, pairing_controls
from microimpact.studies.experiments.pair_search.correction import (
    Correction,
    correction_curves,
    surface_correction,
)
from microimpact.studies.experiments.pair_search.curves import pairing_curves, stream_shown
from microimpact.studies.experiments.pair_search.doppler import (
    Setup,
    dropped,
    observed,
)

NEEDS = {"calibration": ("calibration",)}

# Places of the parts among the draws of the study.
PARTICLES, ANALYSER, CONTROLS, CORRECTION, SLOW, SHOWN = range(6)
COUNTS = ("pairs", "true_pairs", "later_pairs", "recorded_pairs", "rebounds", "seen_rebounds")
# Shares with their interval: found of what.
SHARES = {
    "precision": ("true_pairs", "pairs"),
    "recall": ("true_pairs", "recorded_pairs"),
    "recall_of_seen_rebounds": ("paired", "seen_rebounds"),
    "recall_of_rebounds": ("paired", "rebounds"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Slow:
    """Impacts at exact speeds, so many of each, whose rebounds may not reach the probe volume."""

    speeds_m_per_s: tuple[Positive, ...]
    particles: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """A stretch of one stream."""

    speed_m_per_s: Positive
    window_ms: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Particles, dispenser and analyser; heights and speeds; number and size of experiments."""

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    diameter_um: Distribution
    dispenser: Dispenser
    instrument: Instrument
    heights_mm: tuple[Positive, ...]
    speeds_m_per_s: tuple[Positive, ...]
    experiments: Annotated[int, Field(ge=2)]
    particles: Count
    correction: Correction
    slow: Slow
    controls: Control
    shown: Shown


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Run the virtual experiments.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``calibration``: table of that study; ``materials``: declared rows.

    Returns
    -------
    mapping
        ``pairing_quality``: precision, recall and error of h by height and speed, with intervals of
        95 %; ``pairing_losses``: what became of the impacts; ``pairing_controls``: streams in
        which pairs must not be found; ``surface_correction``: bias of both corrections;
        ``slow_rebounds``: what the analyser does not see. ``doppler_stream``, ``pairing_curves``
        and ``correction_curves``: data of the figure.
    """
    setup = Setup(
        seed=params.seed,
        contact=calibrated_contact(inputs, params.case),
        diameter_um=params.diameter_um,
        dispenser=params.dispenser,
        instrument=params.instrument,
    )
    quality, losses = pairing_quality(params, setup)
    size = params.experiments, params.particles
    correction = surface_correction(setup.aligned.steady, params.correction, CORRECTION)
    return {
        "pairing_quality": quality,
        "pairing_losses": losses,
        "pairing_controls": pairing_controls(setup, params.controls, *size, CONTROLS),
        "surface_correction": correction,
        "slow_rebounds": slow_rebounds(setup.steady, params.slow),
        "doppler_stream": stream_shown(_example(params, setup), params.shown.window_ms),
        "pairing_curves": pairing_curves(quality),
        "correction_curves": correction_curves(correction, params.correction),
    }


def _example(params: Params, setup: Setup) -> Observation:
    speed = params.shown.speed_m_per_s
    return observed(setup, dropped(setup, speed, params.particles, (SHOWN, 0)), speed, (SHOWN, 1))


def pairing_quality(params: Params, setup: Setup) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return quality and losses by height and speed.

    ``..._change_points`` is the spread of a share over all heights at one speed, in points.
    """
    rows, losses = [], []
    for i, height in enumerate(params.heights_mm):
        placed = replace(setup, instrument=replace(setup.instrument, probe_height_mm=height))
        for j, speed in enumerate(params.speeds_m_per_s):
            found = []
            for k in range(params.experiments):
                impacts = dropped(placed, speed, params.particles, (PARTICLES, i, j, k))
                found.append(observed(placed, impacts, speed, (ANALYSER, i, j, k)))
            place = {"probe_height_mm": height, "speed_m_per_s": speed}
            fates = {name: sum(o.quality.fates[name] for o in found) for name in FATES}
            number = params.experiments * params.particles
            rows.append({**place, "impacts": number, **_pooled(found, fates)})
            losses += [{**place, "fate": name, "impacts": n} for name, n in fates.items()]
    table = pd.DataFrame(rows)
    for share in ("precision", "recall"):
        over_heights = table.groupby("speed_m_per_s")[share].transform
        table[f"{share}_change_points"] = 100.0 * (over_heights("max") - over_heights("min"))
    return table, pd.DataFrame(losses)


def _pooled(found: list[Observation], fates: Mapping[str, int]) -> dict[str, object]:
    """Pool the experiments of one height and speed."""
    qualities = [observation.quality for observation in found]
    total = {name: sum(getattr(quality, name) for quality in qualities) for name in COUNTS}
    row: dict[str, object] = dict(total)
    for share, (part, whole) in SHARES.items():
        row |= _share(share, (total | dict(fates))[part], total[whole])
    crossing = fates["captured"] + sum(fates[name] for name in FATES[3:])
    rebounding = crossing - fates["captured"]
    settled = [quality for quality in qualities if quality.converged]
    error = np.array([q.estimated_height - q.height for q in settled])
    stated = np.array([q.estimated_height_error for q in settled])
    bias, bias_error = mean_and_error(1e6 * error)
    return row | {
        "captured_fraction": ratio(fates["captured"], crossing),
        "censored_fraction": ratio(fates["rebound below probe"], rebounding),
        "converged": len(settled) / len(qualities),
        "height_bias_um": bias,
        "height_bias_standard_error_um": bias_error,
        "height_error_rms_in_standard_errors": _rms(error / stated),
    }


def _share(name: str, part: int, whole: int) -> dict[str, float]:
    low, high = np.nan, np.nan
    if whole:
        low, high = wilson_interval(part, whole)
    return {name: ratio(part, whole), f"{name}_low": low, f"{name}_high": high}


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float("nan")


def slow_rebounds(setup: Setup, params: Slow) -> pd.DataFrame:
    """Return, by speed, the share of impacts whose rebound can be seen, and the bias of mean e.

    ``observable`` are the rebounds that rise through the height of the probe volume, ``measured``
    the first impacts that the search found. A mean over too few is empty.
    """
    height = 1e-3 * setup.instrument.probe_height_mm
    rows = []
    for i, speed in enumerate(params.speeds_m_per_s):
        impacts = dropped(setup, speed, params.particles, (SLOW, i, 0))
        found = observed(setup, impacts, speed, (SLOW, i, 1))
        n, rebounds = len(impacts), ~impacts.captured
        e = np.abs(impacts.rebound_velocity[:, 2] / impacts.velocity[:, 2])
        seen = rebounds & found.crossing.reached[REBOUND, :n]
        event = found.measured.event
        first = (event >= 0) & (event < n)
        mean = mean_and_error(e[rebounds])[0]
        visible = mean_and_error(e[seen])[0]
        measured, error = mean_and_error(found.measured.coefficient_of_restitution[first])
        rows.append(
            {
                "speed_m_per_s": speed,
                "probe_height_mm": setup.instrument.probe_height_mm,
                "impacts": n,
                "captured_fraction": 1.0 - float(np.mean(rebounds)),
                "observable_fraction": float(np.mean(seen)),
                "observable_fraction_of_rebounds": ratio(int(seen.sum()), int(rebounds.sum())),
                "least_observable_e": float(np.sqrt(2.0 * gravity * height)) / speed,
                "mean_e_with_captured": float(np.mean(np.where(rebounds, e, 0.0))),
                "mean_e_rebounds": mean,
                "mean_e_observable": visible,
                "bias_observable": visible - mean,
                "events": int(first.sum()),
                "mean_e_measured": measured,
                "mean_e_measured_standard_error": error,
                "bias_measured": measured - mean,
            }
        )
    return pd.DataFrame(rows)
