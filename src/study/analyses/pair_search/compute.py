"""Pair search in the records of a phase Doppler particle analyser, and correction to the surface.

Virtual experiments on normal impacts (Section 2.1): does the height of the probe volume matter to
the identification of pairs, and what does the constant correction do to restitution?
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.core.constants import gravity
from microimpact.lab.bounces import LATER_IMPACTS, generations, with_later_impacts
from microimpact.lab.dispenser import Dispenser, Paths, arrivals
from microimpact.lab.events import Impacts, IntArray
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.pdpa.analyser import Analyser, through_probe
from microimpact.lab.pdpa.experiment import Observation, observe, ratio
from microimpact.lab.pdpa.pairing import Form, correct
from microimpact.lab.surface import Rebound
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Distribution, generator
from microimpact.statistics.intervals import ERROR_BAR, mean_and_error, wilson_interval
from study.contacts import calibrated_contact
from study.declared.parameters import CaseName, Count, MaterialName, Points, Positive
from study.laboratory import Laboratory
from study.tables import Row, Tables, series_frame

# Particles released, at most, for each that is to fall through the probe volume, and how many of
# the latter are sought at a time.
MOST_RELEASED, AT_ONCE = 20_000, 100
# The stream that is shown: slow enough for some rebounds to be missing, m/s, and the release after
# one tap.
SHOWN_SPEED, WINDOW_MS = 0.5, 100.0
# Places of the parts among the draws of the study.
PARTICLES, ANALYSER, CORRECTION, SHOWN = 0, 1, 3, 5


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
    def exact(self) -> Apparatus:
        """The same with all impacts at one speed, in the middle of a probe volume in its place."""
        still = {
            "exit_speed_m_per_s": 0.0,
            "lateral_speed_m_per_s": 0.0,
            "lateral_position_mm": 0.0,
        }
        return replace(
            self,
            dispenser=replace(self.dispenser, **still),
            instrument=replace(self.instrument, probe_height_error_um=0.0),
        )


def dropped(
    setup: Apparatus, speed: float, particles: int, key: tuple[int, ...], experiments: int = 1
) -> Impacts:
    """Drop particles at a nominal speed, m/s, until `particles` fall through the probe volume.

    Only they are followed, and they alone arrive at the dispenser's rate: the stream of records
    is then as dense as declared, however few of all particles find the probe volume. Experiments
    come one after the other, each with times of its own.

    Raises NotComputable if hardly any particle falls through the probe volume.
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
            raise NotComputable(
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
    """Observe experiments of `particles` each, with keys of particles and of analyser."""
    impacts = dropped(setup, speed, particles, keys[0], experiments)
    rng, drop = generator(setup.seed, *keys[1]), setup.drop(speed)
    later = drop.target.later(impacts.diameter, rng)
    spheres, whole = zip(*generations(impacts, later, LATER_IMPACTS), strict=True)
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


_frame = partial(series_frame, x_unit="m_per_s", y_unit="1")

FORMS: tuple[Form, ...] = ("printed", "exact")


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """Impacts at exact speeds with a given restitution, `particles` of each."""

    speeds_m_per_s: tuple[Positive, ...]
    restitutions: tuple[Annotated[float, Field(gt=0, le=1)], ...]
    particles: Count
    curve_points: Points


def surface_correction(setup: Apparatus, params: Correction) -> Iterator[Row]:
    """Yield the bias of both corrections on e.

    ``closed_form`` is that of the printed correction. ``printed`` and ``exact`` come from the
    analyser's records and the height found from them, each with its standard error. Where the
    rebound does not reach the probe volume there is none.
    """
    height = setup.instrument.probe_height_mm
    speeds, restitutions = enumerate(params.speeds_m_per_s), enumerate(params.restitutions)
    for (i, speed), (j, e) in product(speeds, restitutions):
        measured = _measured(setup, params.particles, speed, e, (CORRECTION, i, j))
        row: Row = {
            "speed_m_per_s": speed,
            "restitution": e,
            "probe_height_mm": height,
            "quantity": "e",
            "events": len(measured["exact"]),
            "closed_form": closed_form(speed, e, 1e-3 * height),
        }
        for form, values in measured.items():
            mean, error = mean_and_error(values - e)
            row |= {form: mean, f"{form}_standard_error": error}
        yield row


def closed_form(speed: float, e: float, height: float) -> float:
    """Return the bias of the printed correction on e; nan where the rebound does not reach h."""
    gained = 2.0 * gravity * height
    if (e * speed) ** 2 <= gained:
        return float("nan")
    at_probe = np.sqrt(np.square([speed, e * speed]) - gained)
    v, V = (float(x) for x in np.asarray(correct(at_probe, height, "printed")))
    return V / v - e


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
            bias = np.array([closed_form(v, e, height) for v in speed])
            frames.append(_frame("correction", f"closed form, e = {e:g}", speed, bias))
        rows = table[(table["restitution"] == e) & table["exact_standard_error"].notna()]
        for form in FORMS:
            y, half = rows[form], ERROR_BAR * rows[f"{form}_standard_error"]
            name, x = f"{form}, e = {e:g}", rows["speed_m_per_s"]
            frames.append(
                _frame("correction", name, x, y, "virtual experiment", y - half, y + half)
            )
    return pd.concat(frames, ignore_index=True)


def _measured(
    setup: Apparatus, particles: int, speed: float, e: float, key: tuple[int, ...]
) -> dict[Form, FloatArray]:
    """Return e of the first impacts that were identified, by correction."""

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
    followed = with_later_impacts(impacts, bounce)
    observation = observe(followed, particles, duration, setup.instrument, rng)
    events = {form: observation.at_surface(form) for form in FORMS}
    return {
        form: of.coefficient_of_restitution[(of.event >= 0) & (of.event < observation.first)]
        for form, of in events.items()
    }


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

# Shares with their interval: found of what.
SHARES = {
    "precision": ("true_pairs", "pairs"),
    "recall": ("true_pairs", "recorded_pairs"),
    "recall_of_seen_rebounds": ("paired", "seen_rebounds"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Particles, dispenser and analyser; heights and speeds; number and size of experiments."""

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    particle: MaterialName
    diameter_um: Distribution
    dispenser: Dispenser
    instrument: Analyser
    heights_mm: tuple[Positive, ...]
    speeds_m_per_s: tuple[Positive, ...]
    experiments: Annotated[int, Field(ge=2)]
    particles: Count
    correction: Correction


def disagreements(params: Params, _: Mapping[str, Any], laboratory: Laboratory) -> Iterator[str]:
    """Yield a line if the particles are not those of the contact."""
    yield from laboratory.other_particle("particle", params.particle, params.case)


def run(params: Params, inputs: Tables) -> Tables:
    """Run the virtual experiments.

    ``pairing_quality``: precision and recall by height and speed, with intervals of 95 %.
    ``surface_correction``: bias of both corrections. ``doppler_stream``, ``pairing_curves`` and
    ``correction_curves``: data of the figure.
    """
    setup = Apparatus(
        seed=params.seed,
        contact=calibrated_contact(inputs, params.case),
        diameter_um=params.diameter_um,
        dispenser=params.dispenser,
        instrument=params.instrument,
    )
    quality = pd.DataFrame(pairing_quality(params, setup))
    (example,) = observed(setup, SHOWN_SPEED, params.particles, (SHOWN, 0), (SHOWN, 1))
    correction = pd.DataFrame(surface_correction(setup.exact, params.correction))
    return {
        "pairing_quality": quality,
        "surface_correction": correction,
        "doppler_stream": stream_shown(example),
        "pairing_curves": pairing_curves(quality),
        "correction_curves": correction_curves(correction, params.correction),
    }


def pairing_quality(params: Params, setup: Apparatus) -> Iterator[Row]:
    """Yield the quality of the pairs by height and speed, pooled over experiments."""
    places = product(enumerate(params.heights_mm), enumerate(params.speeds_m_per_s))
    for (i, height), (j, speed) in places:
        placed = replace(setup, instrument=replace(setup.instrument, probe_height_mm=height))
        size = params.particles, (PARTICLES, i, j), (ANALYSER, i, j)
        observations = observed(placed, speed, *size, experiments=params.experiments)
        qualities = [observation.quality for observation in observations]
        total = {
            name: sum(getattr(quality, name) for quality in qualities)
            for name in ("pairs", "true_pairs", "recorded_pairs", "seen_rebounds")
        }
        total["paired"] = sum(quality.fates["paired"] for quality in qualities)
        row: Row = {"probe_height_mm": height, "speed_m_per_s": speed}
        row |= {name: total[name] for name in ("pairs", "recorded_pairs")}
        for share, (part, whole) in SHARES.items():
            row |= _share(share, total[part], total[whole])
        yield row


def _share(name: str, part: int, whole: int) -> dict[str, float]:
    low, high = wilson_interval(part, whole) if whole else (np.nan, np.nan)
    return {name: ratio(part, whole), f"{name}_low": low, f"{name}_high": high}
