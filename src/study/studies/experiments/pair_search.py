"""Pair search in the records of a phase Doppler particle analyser, and correction to the surface.

Virtual experiments on normal impacts (Section 2.1): does the height of the probe volume matter to
the identification of pairs, what does the constant correction do to velocities and restitution,
and what becomes of rebounds too slow to reach the probe volume?
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.constants import gravity
from microimpact.lab.bounces import generations, with_later_impacts
from microimpact.lab.dispenser import Dispenser, Paths, arrivals
from microimpact.lab.events import Impacts, IntArray, Measured
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.pdpa.analyser import REBOUND, Analyser, through_probe
from microimpact.lab.pdpa.observation import FATES, Observation, observe, ratio
from microimpact.lab.pdpa.pairing import Form, correct, search
from microimpact.lab.surface import Rebound
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Distribution, generator
from microimpact.statistics.intervals import ERROR_BAR, mean_and_error, wilson_interval
from study.declared.parameters import AboveOne, CaseName, Count, Points, Positive
from study.studies.contacts import calibrated_contact
from study.tables import Row, Tables, series_frame

# Particles released, at most, for each that is to fall through the probe volume; so many of these
# at a time.
MOST_RELEASED, AT_ONCE = 20_000, 100
# The stream that is shown: slow enough for some rebounds to be missing, m/s, and the release after
# one tap.
SHOWN_SPEED, WINDOW_MS = 0.5, 100.0
# Places of the parts among the draws of the study.
PARTICLES, ANALYSER, CONTROLS, CORRECTION, SLOW, SHOWN = range(6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Apparatus:
    """Contact, particles and instruments of an experiment; `seed` is the root of its draws."""

    seed: int
    contact: Contact
    diameter_um: Distribution
    dispenser: Dispenser
    instrument: Analyser

    def drop(self, speed: float) -> Drop:
        """Return the drop at a nominal speed, m/s."""
        return Drop(
            target=Target(contact=self.contact),
            diameter_um=self.diameter_um,
            speed=speed,
            dispenser=self.dispenser,
        ).tabulated()

    @property
    def steady(self) -> Apparatus:
        """The same with impacts at one speed and with the probe volume where it should be."""
        return replace(
            self,
            dispenser=replace(self.dispenser, exit_speed_m_per_s=0.0),
            instrument=replace(self.instrument, probe_height_error_um=0.0),
        )

    @property
    def aligned(self) -> Apparatus:
        """The same with every sphere falling through the middle of the probe volume."""
        straight = replace(self.dispenser, lateral_speed_m_per_s=0.0, lateral_position_mm=0.0)
        return replace(self, dispenser=straight)


def dropped(
    setup: Apparatus, speed: float, particles: int, key: tuple[int, ...], experiments: int = 1
) -> Impacts:
    """Drop particles at a nominal speed, m/s, until so many fall through the probe volume.

    Only they are followed, and they alone arrive at the dispenser's rate: the stream of records
    is then as dense as declared, however few of all particles find the probe volume. Experiments
    come one after the other, each with times of its own.

    Raises ValueError if hardly any particle falls through the probe volume.
    """
    rng, drop = generator(setup.seed, *key), setup.drop(speed)
    through = partial(_through_probe, drop.paths, setup.instrument, speed)
    falling = drop.release(experiments * particles, rng, through)
    times = [arrivals(particles, setup.dispenser, rng) for _ in range(experiments)]
    return drop.hit(replace(falling, time=np.concatenate(times)), rng)


def _through_probe(
    path: Paths, instrument: Analyser, speed: float, n: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the first paths that fall through the probe volume."""
    parts, released, crossed = [], 0, 0
    while crossed < n:
        if released >= MOST_RELEASED * n:
            raise ValueError(
                f"particles: at {speed:g} m/s fewer than {n} of {released} fall through the probe"
                " volume; make"
                " probe_across_um or probe_along_um larger, or lateral_speed_m_per_s smaller"
            )
        # As many as are wanted by the share so far.
        number = min(math.ceil((n - crossed) * (released + 1) / (crossed + 1)), AT_ONCE * n)
        drawn = path(number, rng)
        inside = through_probe(*drawn[:2], 1e-3 * instrument.probe_height_mm, instrument)
        parts.append([values[inside] for values in drawn])
        released, crossed = released + number, crossed + int(np.sum(inside))
    position, velocity, fall = (np.concatenate(of)[:n] for of in zip(*parts, strict=True))
    return position, velocity, fall


def observed(
    setup: Apparatus, speed: float, particles: int, *keys: tuple[int, ...], experiments: int = 1
) -> list[Observation]:
    """Observe experiments of so many particles each, with keys of particles and of analyser."""
    impacts = dropped(setup, speed, particles, keys[0], experiments)
    rng, drop = generator(setup.seed, *keys[1]), setup.drop(speed)
    later = drop.target.later(impacts.diameter, rng)
    spheres, whole = zip(*generations(impacts, later, setup.instrument.later_impacts), strict=True)
    followed = Impacts.joined(whole)
    experiment = np.concatenate(spheres) // particles
    parts = [followed.select(experiment == i) for i in range(experiments)]
    pause = 1.0 / setup.dispenser.taps_per_s
    return [
        observe(
            part,
            particles,
            float(np.max(part.time[:particles])) + pause,
            setup.instrument,
            rng,
            drop_height=drop.height,
        )
        for part in parts
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """Nominal speed of the impacts, and how many times as many arrive in the crowded stream."""

    speed_m_per_s: Positive
    crowding: AboveOne


def pairing_controls(
    setup: Apparatus, params: Control, experiments: int, particles: int
) -> Iterator[Row]:
    """Yield how the search fares with changed streams of the same experiments.

    ``pairs_per_incident`` is the rate at which a falling record is given a partner; where there
    are none to be found, it is the rate of false pairs.
    """
    often = setup.dispenser.particles_per_tap * params.crowding
    crowded = replace(setup, dispenser=replace(setup.dispenser, particles_per_tap=often))
    speed, keys = params.speed_m_per_s, ((CONTROLS, 0), (CONTROLS, 1))
    plain, dense = (
        observed(case, speed, particles, *keys, experiments=experiments)
        for case in (setup, crowded)
    )
    draws = (generator(setup.seed, CONTROLS, i, 2) for i in range(experiments))
    streams = {
        "as recorded": plain,
        "times of rebounds permuted": map(_times_permuted, plain, draws),
        "rebounds left out": map(_without_rebounds, plain),
        f"{params.crowding:g} times the arrivals": dense,
    }
    for name, observations in streams.items():
        height = setup.instrument.initial_height
        paired = [
            replace(one, pairing=search(one.stream, height, setup.instrument))
            for one in observations
        ]
        total = _total(paired)
        yield {
            "stream": name,
            "speed_m_per_s": speed,
            "probe_height_mm": setup.instrument.probe_height_mm,
            "experiments": experiments,
            **{name: total[name] for name in CONTROLLED},
            "precision": ratio(total["true_pairs"], total["pairs"]),
            "recall": ratio(total["true_pairs"], total["recorded_pairs"]),
            "pairs_per_incident": ratio(
                total["pairs"], total["pairs"] + total["unpaired_incidents"]
            ),
            "converged": sum(one.pairing.converged for one in paired) / experiments,
        }


def _total(experiments: list[Observation]) -> dict[str, int]:
    """Return all counts of some experiments, and their fates."""
    qualities = [observation.quality for observation in experiments]
    total = {name: sum(getattr(quality, name) for quality in qualities) for name in COUNTS}
    return total | {name: sum(quality.fates[name] for quality in qualities) for name in FATES}


def _times_permuted(observation: Observation, rng: np.random.Generator) -> Observation:
    rising = np.flatnonzero(observation.stream.velocity > 0.0)
    time = observation.stream.time.copy()
    time[rising] = time[rng.permutation(rising)]
    return replace(observation, stream=replace(observation.stream, time=time))


def _without_rebounds(observation: Observation) -> Observation:
    """Leave out rising spheres; false records stay, and rise as often as they fall."""
    stream, truth = observation.stream, observation.truth
    stays: BoolArray = (truth.impact < 0) | (stream.velocity < 0.0)
    truth = replace(truth, leg=truth.leg[stays], impact=truth.impact[stays])
    return replace(observation, stream=stream.select(stays), truth=truth)


_frame = partial(series_frame, x_unit="m_per_s", y_unit="1")

FORMS: tuple[Form, ...] = ("printed", "exact")


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """Impacts at exact speeds with given restitution, so many of each."""

    speeds_m_per_s: tuple[Positive, ...]
    restitutions: tuple[Annotated[float, Field(gt=0, le=1)], ...]
    particles: Count
    curve_points: Points


def surface_correction(setup: Apparatus, params: Correction) -> Iterator[Row]:
    """Yield the bias of both corrections on the speeds v and V, m/s, and on e.

    ``closed_form`` is that of the printed correction. ``printed`` and ``exact`` come from the
    analyser's records and the height found from them, each with its standard error. Where the
    rebound does not reach the probe volume there is none.
    """
    for i, speed in enumerate(params.speeds_m_per_s):
        for j, e in enumerate(params.restitutions):
            expected = closed_form(speed, e, 1e-3 * setup.instrument.probe_height_mm)
            corrected = _measured(setup, params.particles, speed, e, (CORRECTION, i, j))
            for quantity, true in {"v": speed, "V": e * speed, "e": e}.items():
                row = {
                    "speed_m_per_s": speed,
                    "restitution": e,
                    "probe_height_mm": setup.instrument.probe_height_mm,
                    "quantity": quantity,
                    "true": true,
                    "events": len(corrected["exact"][quantity]),
                    "closed_form": expected[quantity],
                }
                for form in FORMS:
                    mean, error = mean_and_error(corrected[form][quantity] - true)
                    row |= {form: mean, f"{form}_standard_error": error}
                yield row


def closed_form(speed: float, e: float, height: float) -> dict[str, float]:
    """Return the bias of the printed correction on v, V and e; nan where V does not reach h."""
    gained = 2.0 * gravity * height
    if (e * speed) ** 2 <= gained:
        return dict.fromkeys(("v", "V", "e"), float("nan"))
    at_probe = np.sqrt(np.square([speed, e * speed]) - gained)
    v, V = (float(x) for x in np.asarray(correct(at_probe, height, "printed")))
    return {"v": v - speed, "V": V - e * speed, "e": V / v - e}


def correction_curves(table: pd.DataFrame, params: Correction) -> pd.DataFrame:
    """Return the bias of e against speed, by closed forms and from the records."""
    (height,) = 1e-3 * table["probe_height_mm"].unique()
    ends = min(params.speeds_m_per_s), max(params.speeds_m_per_s)
    frames = []
    for e in params.restitutions:
        # From the slowest impact whose rebound reaches the probe volume.
        slowest = max(ends[0], (1.0 + 1e-9) * float(np.sqrt(2.0 * gravity * height)) / e)
        if slowest < ends[1]:
            speed = np.geomspace(slowest, ends[1], params.curve_points)
            bias = np.array([closed_form(v, e, height)["e"] for v in speed])
            frames.append(_frame("correction", f"closed form, e = {e:g}", speed, bias))
        rows = table[(table["quantity"] == "e") & (table["restitution"] == e)]
        rows = rows[rows["exact_standard_error"].notna()]
        for form in FORMS:
            y, half = rows[form], ERROR_BAR * rows[f"{form}_standard_error"]
            name, x = f"{form}, e = {e:g}", rows["speed_m_per_s"]
            frames.append(
                _frame("correction", name, x, y, "virtual experiment", y - half, y + half)
            )
    return pd.concat(frames, ignore_index=True)


def _measured(
    setup: Apparatus, particles: int, speed: float, e: float, key: tuple[int, ...]
) -> dict[Form, dict[str, FloatArray]]:
    """Return v, V and e of the first impacts that were identified, by correction."""

    def bounce(velocity: FloatArray, spin: FloatArray, sphere: IntArray) -> Rebound:
        kept = np.zeros(len(sphere), dtype=np.bool_)
        after = velocity * [1.0, 1.0, -e]
        return Rebound(velocity=after, spin=spin, kept=kept, contacts=np.ones_like(sphere))

    impacts = dropped(setup, speed, particles, (*key, 0))
    first = bounce(impacts.velocity, impacts.spin, np.arange(particles))
    impacts = replace(
        impacts, rebound_velocity=first.velocity, rebound_spin=first.spin, captured=first.captured
    )
    duration, rng = float(np.max(impacts.time)), generator(setup.seed, *key, 1)
    followed = with_later_impacts(impacts, bounce, setup.instrument.later_impacts)
    observation = observe(followed, particles, duration, setup.instrument, rng)
    reduced: dict[Form, dict[str, FloatArray]] = {}
    for form in FORMS:
        events = _of_first(observation, form)
        v, V = events.normal
        reduced[form] = {"v": -v, "V": V, "e": events.coefficient_of_restitution}
    return reduced


def _of_first(observation: Observation, form: Form = "exact") -> Measured:
    """Return the events that are first impacts, and known to be."""
    events = observation.at_surface(form)
    return events.select((events.event >= 0) & (events.event < observation.first))


DRAWN_SHARES = {"precision": "precision", "recall": "recall", "seen": "recall_of_seen_rebounds"}


def stream_shown(observation: Observation) -> pd.DataFrame:
    """Return the stretch of a stream with the most records, velocity against time."""
    stream, pairing = observation.stream, observation.pairing
    time = 1e3 * stream.time
    # A stretch begins a little ahead of a record; those of a stream are in order of time.
    starts = time - 0.05 * WINDOW_MS
    number = np.searchsorted(time, starts + WINDOW_MS) - np.arange(len(time))
    start = float(starts[np.argmax(number)]) if len(time) else 0.0
    shown = (time >= start) & (time <= start + WINDOW_MS)
    series = {
        "falling": np.flatnonzero(shown & (stream.velocity < 0.0)),
        "rising": np.flatnonzero(shown & (stream.velocity > 0.0)),
    }
    pairs = np.column_stack([pairing.incident, pairing.rebound])
    whole = pairs[np.all(shown[pairs], axis=1)]
    series |= {f"pair {i}": pair for i, pair in enumerate(whole, start=1)}
    frame = partial(series_frame, evidence="virtual experiment", x_unit="ms", y_unit="m_per_s")
    frames = [
        frame("stream", name, time[records] - start, stream.velocity[records])
        for name, records in series.items()
    ]
    return pd.concat(frames, ignore_index=True)


def pairing_curves(quality: pd.DataFrame) -> pd.DataFrame:
    """Return precision and recall against speed, a series per height of the probe volume."""
    frames = []
    for panel, share in DRAWN_SHARES.items():
        for height, rows in quality[quality[share].notna()].groupby("probe_height_mm"):
            speed, y = rows["speed_m_per_s"], rows[share]
            ends = rows[f"{share}_low"], rows[f"{share}_high"]
            frames.append(
                _frame(panel, f"h = {height:g} mm", speed, y, "virtual experiment", *ends)
            )
    return pd.concat(frames, ignore_index=True)


NEEDS = {"calibration": ("calibration",)}

POOLED = ("pairs", "true_pairs", "later_pairs", "recorded_pairs", "rebounds", "seen_rebounds")
CONTROLLED = ("pairs", "true_pairs", "recorded_pairs", "unpaired_incidents")
COUNTS = {*POOLED, *CONTROLLED}
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
class Params:
    """Particles, dispenser and analyser; heights and speeds; number and size of experiments."""

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    diameter_um: Distribution
    dispenser: Dispenser
    instrument: Analyser
    heights_mm: tuple[Positive, ...]
    speeds_m_per_s: tuple[Positive, ...]
    experiments: Annotated[int, Field(ge=2)]
    particles: Count
    correction: Correction
    slow: Slow
    controls: Control


def run(params: Params, inputs: Tables) -> Tables:
    """Run the virtual experiments.

    ``pairing_quality``: precision, recall and error of h by height and speed, with intervals of 95
    %; ``pairing_losses``: what became of the impacts; ``pairing_controls``: streams in which pairs
    must not be found; ``surface_correction``: bias of both corrections; ``slow_rebounds``: what the
    analyser does not see. ``doppler_stream``, ``pairing_curves`` and ``correction_curves``: data of
    the figure.
    """
    setup = Apparatus(
        seed=params.seed,
        contact=calibrated_contact(inputs, params.case),
        diameter_um=params.diameter_um,
        dispenser=params.dispenser,
        instrument=params.instrument,
    )
    quality, losses = pairing_quality(params, setup)
    size = params.experiments, params.particles
    controls = pairing_controls(setup, params.controls, *size)
    (example,) = observed(setup, SHOWN_SPEED, params.particles, (SHOWN, 0), (SHOWN, 1))
    correction = pd.DataFrame(surface_correction(setup.aligned.steady, params.correction))
    return {
        "pairing_quality": quality,
        "pairing_losses": losses,
        "pairing_controls": pd.DataFrame(controls),
        "surface_correction": correction,
        "slow_rebounds": pd.DataFrame(slow_rebounds(setup.steady, params.slow)),
        "doppler_stream": stream_shown(example),
        "pairing_curves": pairing_curves(quality),
        "correction_curves": correction_curves(correction, params.correction),
    }


def pairing_quality(params: Params, setup: Apparatus) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return quality and losses by height and speed.

    ``..._change_points`` is the spread of a share over all heights at one speed, in points.
    """
    rows, losses = [], []
    places = product(enumerate(params.heights_mm), enumerate(params.speeds_m_per_s))
    for (i, height), (j, speed) in places:
        placed = replace(setup, instrument=replace(setup.instrument, probe_height_mm=height))
        size = params.particles, (PARTICLES, i, j), (ANALYSER, i, j)
        observations = observed(placed, speed, *size, experiments=params.experiments)
        setting = {"probe_height_mm": height, "speed_m_per_s": speed}
        total, number = _total(observations), params.experiments * params.particles
        rows.append({**setting, "impacts": number, **_pooled(observations, total)})
        losses += [{**setting, "fate": name, "impacts": total[name]} for name in FATES]
    table = pd.DataFrame(rows)
    for share in ("precision", "recall"):
        over_heights = table.groupby("speed_m_per_s")[share].transform
        table[f"{share}_change_points"] = 100.0 * (over_heights("max") - over_heights("min"))
    return table, pd.DataFrame(losses)


def _pooled(observations: list[Observation], total: Mapping[str, int]) -> Row:
    """Pool the experiments of one height and speed."""
    row: Row = {name: total[name] for name in POOLED}
    for share, (part, whole) in SHARES.items():
        row |= _share(share, total[part], total[whole])
    rebounding = sum(total[name] for name in FATES[3:])
    settled = [one for one in observations if one.pairing.converged]
    error = np.array([one.pairing.height - one.height for one in settled])
    stated = np.array([one.pairing.height_error for one in settled])
    bias, bias_error = mean_and_error(1e6 * error)
    square, _ = mean_and_error(np.square(error / stated))
    return row | {
        "captured_fraction": ratio(total["captured"], total["captured"] + rebounding),
        "censored_fraction": ratio(total["rebound below probe"], rebounding),
        "converged": len(settled) / len(observations),
        "height_bias_um": bias,
        "height_bias_standard_error_um": bias_error,
        "height_error_rms_in_standard_errors": square**0.5,
    }


def _share(name: str, part: int, whole: int) -> dict[str, float]:
    low, high = wilson_interval(part, whole) if whole else (np.nan, np.nan)
    return {name: ratio(part, whole), f"{name}_low": low, f"{name}_high": high}


def slow_rebounds(setup: Apparatus, params: Slow) -> Iterator[Row]:
    """Yield, by speed, the share of impacts whose rebound can be seen, and the bias of mean e.

    ``observable`` are the rebounds that rise through the height of the probe volume, ``measured``
    the first impacts that the search found. A mean over too few is empty.
    """
    height = 1e-3 * setup.instrument.probe_height_mm
    for i, speed in enumerate(params.speeds_m_per_s):
        (observation,) = observed(setup, speed, params.particles, (SLOW, i, 0), (SLOW, i, 1))
        n, impacts = observation.first, observation.impacts.select(slice(observation.first))
        rebounds = ~impacts.captured
        e = np.abs(impacts.rebound_velocity[:, 2] / impacts.velocity[:, 2])
        seen = rebounds & observation.crossing.reached[REBOUND, :n]
        first = _of_first(observation).coefficient_of_restitution
        mean = mean_and_error(e[rebounds])[0]
        visible = mean_and_error(e[seen])[0]
        measured, error = mean_and_error(first)
        yield {
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
            "events": len(first),
            "mean_e_measured": measured,
            "mean_e_measured_standard_error": error,
            "bias_measured": measured - mean,
        }
