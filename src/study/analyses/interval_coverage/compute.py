"""How often the 95 % intervals of some 40 events hold the true mean, and which (Section 2.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.random import Generator
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.computable import NotComputable
from microimpact.core.constants import gravity
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.events import Impacts, IntArray, Measured
from microimpact.lab.experiment import NORMAL, Drop, Target
from microimpact.lab.pdpa.analyser import Analyser, RecordStream, passages, records
from microimpact.lab.pdpa.experiment import moved
from microimpact.lab.pdpa.pairing import correct, estimate_height
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.experiment import in_sheet, set_for, turned
from microimpact.lab.ptis.exposure import MEASURED
from microimpact.lab.ptis.system import ImagingSystem, Systematics
from microimpact.lab.reduction import shared_error
from microimpact.lab.surface import rough
from microimpact.statistics.distributions import Distribution, child, generator
from microimpact.statistics.intervals import student_half_width, wilson_interval
from study.contacts import calibrated_contact
from study.declared.parameters import (
    CaseName,
    Count,
    Fraction,
    Name,
    NonNegative,
    OpenShare,
    Positive,
)
from study.tables import NotComputedError, Tables, not_computed, reason, series_frame

# Spheres that some experiment may measure arrive no farther than this, m, from the middle of the
# probe volume.
NEAR_PROBE = 3e-4
# They cross a probe volume that is wider by this factor.
WIDER = 1.3
# Errors of its height, and noise that brings speeds into the class: up to this many deviations.
REACH = 4.0
# Spheres looked at in one experiment: more than it needs on average, by these standard deviations.
SPARE = 6.0
# Experiments with the analyser, in the order of the probe's height, are simulated in these groups.
GROUPS = 20
# Searches for the height of the probe: each starts from the last.
ROUNDS = 3


class Repeated(NamedTuple):
    """Repetitions of one experiment."""

    # Accepted events as measured and as they were, fields of shape (experiments, events).
    measured: Measured
    true: Measured
    # Standard uncertainty of the systematic error, shape (experiments, 1): of the probe's height,
    # m, or of the target's angle, degrees.
    uncertainty: FloatArray


def by_imaging(params: Params, drop: Drop, impacts: Impacts, rng: Generator) -> Repeated:
    """Repeat an oblique experiment.

    Scale, rate and angle are wrong by other amounts in each experiment; they stretch and turn all
    its velocities alike. Which events can be measured is taken not to depend on them.

    Parameters
    ----------
    drop
        What is dropped on what; its range is of measured speeds.
    impacts
        Simulated impacts, from which those of the experiments are drawn.
    """
    experiments, events, instrument = params.experiments, params.events, params.ptis
    setup = set_for(drop, instrument)
    moving = np.flatnonzero(~impacts.captured & in_sheet(impacts.position, instrument))
    draws = [child(rng, 1)] * moving.size
    fates, expected = theory(impacts.select(moving), setup, Systematics(), draws)
    pool = moving[fates == MEASURED]
    speed = np.linalg.norm(expected.velocities[:, 0], axis=1)
    reach = REACH * np.hypot(instrument.rate_error, instrument.scale_error)
    share = min(_share(drop.in_class(speed * (1.0 + wrong))) for wrong in (-reach, reach))

    draw = child(rng, 2)
    chosen = draw.integers(pool.size, size=(experiments, _enough(events, share)))
    # Of small matrices, in a third of the time of their product.
    spread = np.linalg.cholesky(expected.covariance)[chosen]
    noise = np.einsum("...ij,...j->...i", spread, draw.standard_normal((*chosen.shape, 2, 2)))
    rate, scale, angle = draw.standard_normal((3, experiments, 1))
    stretch = 1.0 / (1.0 + instrument.rate_error * rate) / (1.0 + instrument.scale_error * scale)
    velocity = (expected.velocities[chosen] + noise) * stretch[..., None, None]
    seen = Measured(event=pool[chosen], velocities=velocity)
    accepted = _first(seen, drop.in_class(seen.speed), events)
    measured = turned(accepted, instrument.angle_error_deg * angle)
    return Repeated(
        measured=measured,
        true=impacts.in_plane.select(measured.event),
        uncertainty=np.full((experiments, 1), instrument.angle_error_deg),
    )


def by_doppler(params: Params, drop: Drop, impacts: Impacts, rng: Generator) -> Repeated:
    """Repeat a normal experiment, with the right pairs: the search for them is not repeated.

    The height of the probe volume is another in each experiment, and decides which spheres cross
    it; it is found from the delays of the pairs, as in an experiment.

    Arguments as in `by_imaging`; only particles that arrive near the probe volume are followed.
    """
    experiments, events, instrument = params.experiments, params.events, params.pdpa
    draw = child(rng, 2)
    usual = 1e-3 * instrument.probe_height_mm
    error = 1e-6 * instrument.probe_height_error_um
    speed = np.abs(impacts.velocity[:, 2])
    noise = REACH * instrument.velocity_noise(speed)
    slowest, fastest = drop.speed_range
    near = _may_cross(impacts, usual + REACH * error * np.array([-1.0, 0.0, 1.0]), instrument)
    pool = impacts.select(near & (speed >= slowest - noise) & (speed <= fastest + noise))
    height = np.sort(usual + error * draw.standard_normal(experiments))
    measured, true, uncertainty = zip(
        *(
            _doppler_experiments(pool, part, events, instrument, drop, draw)
            for part in np.array_split(height, GROUPS)
            if part.size
        ),
        strict=True,
    )
    return Repeated(
        Measured.joined(list(measured)), Measured.joined(list(true)), np.concatenate(uncertainty)
    )


def _doppler_experiments(
    pool: Impacts, height: FloatArray, events: int, instrument: Analyser, drop: Drop, rng: Generator
) -> Repeated:
    """Return one experiment of the probe volume, in ascending order.

    At the last one the fewest spheres rise into it.
    """
    pool = pool.select(_may_cross(pool, height[[0, -1]], instrument))
    crossing = passages(pool, height[-1], instrument).crossed.all(axis=0)
    share = _share(crossing & drop.in_class(np.abs(pool.velocity[:, 2])))
    number = _enough(events, share * (1.0 - instrument.drop_out) ** 2)
    chosen = rng.integers(len(pool), size=(height.size, number))
    stream, pairs = _recorded(pool, chosen, height, instrument, rng)
    paired = (pairs >= 0).all(axis=0)
    at_probe = np.where(paired, stream.velocity[pairs], np.nan)
    usual = 1e-3 * instrument.probe_height_mm
    event = np.arange(paired.size).reshape(paired.shape)
    seen = Measured.of_normal(event, np.moveaxis(at_probe, 0, -1))
    speed = np.abs(np.asarray(correct(at_probe[0], usual)))
    # A rebound that seems to fall, by its noise, is no candidate in the search for pairs.
    kept = _first(seen, drop.in_class(speed) & (at_probe[1] > 0.0), events)
    used = pairs.reshape(2, -1)[:, kept.event]
    estimate = np.array([instrument.initial_height, np.nan])[:, None]
    for _ in range(ROUNDS):
        estimate = np.stack(estimate_height(stream, used, estimate[0], instrument))
    corrected = np.asarray(correct(kept.velocities, estimate[0, :, None, None, None]))
    measured = replace(kept, velocities=corrected)
    return Repeated(
        measured, pool.in_plane.select(chosen.ravel()[kept.event]), estimate[1, :, None]
    )


def _may_cross(impacts: Impacts, heights: FloatArray, instrument: Analyser) -> BoolArray:
    """Tell which spheres may cross a probe volume, both ways, at some height of a range, m.

    Between the heights, which ascend, their paths are short.
    """
    larger = replace(
        instrument,
        probe_across_um=WIDER * instrument.probe_across_um,
        probe_along_um=WIDER * instrument.probe_along_um,
    )
    inside = np.any([passages(impacts, one, larger).inside for one in heights], axis=0)
    rises = np.square(impacts.rebound_velocity[:, 2]) > 2.0 * gravity * heights[0]
    near: BoolArray = inside.all(axis=0) & rises & ~impacts.captured
    return near


def _recorded(
    impacts: Impacts, chosen: IntArray, height: FloatArray, instrument: Analyser, rng: Generator
) -> tuple[RecordStream, IntArray]:
    """Record impacts (experiments, k) one by one; where in the stream both records are, or -1."""
    apart = replace(impacts.select(chosen.ravel()), time=np.arange(chosen.size, dtype=float))
    levels = np.repeat(height, chosen.shape[1])
    quiet = replace(instrument, false_records_per_s=0.0)
    stream, truth = records(passages(apart, levels, quiet), 0.0, quiet, rng)
    pairs = np.full((2, chosen.size), -1)
    pairs[truth.leg, truth.impact] = np.arange(len(stream))
    return stream, pairs.reshape(2, *chosen.shape)


def _share(good: BoolArray) -> float:
    return float(np.mean(good)) if good.size else 0.0


def _enough(events: int, share: float) -> int:
    """Return how many must be looked at to be sure of the events wanted."""
    if share <= 0.0:
        raise NotComputable(f"no event in the speed range can be measured: {events} are wanted")
    # n p - SPARE sqrt(n p (1 - p)) = events
    spread = 0.5 * SPARE * np.sqrt(1.0 - share)
    return int(np.ceil((spread + np.sqrt(spread**2 + events)) ** 2 / share))


def _first(measured: Measured, good: BoolArray, events: int) -> Measured:
    """Return the first good events of each experiment, shape (experiments, events)."""
    if np.any(good.sum(axis=1) < events):
        raise NotComputable(f"too few events in some experiments: {events} are wanted")
    order = np.argsort(~good, axis=1, kind="stable")[:, :events]
    return measured.select((np.arange(len(order))[:, None], order))


NEEDS = {"calibration": ("calibration",)}

# The means that are drawn, by the end of their columns.
DRAWN = {"observable": "events that can be measured", "rebounds": "all rebounds"}


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageCase:
    """Experiments of one surface, over speeds at one angle or over angles at one speed."""

    speeds_m_per_s: tuple[Positive, ...]
    angles_deg: tuple[Annotated[float, Field(gt=0, le=90)], ...]
    diameter_um: Distribution
    slope: NonNegative
    speed_window: OpenShare
    simulated: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Cases, and how often each is repeated; at 90 deg by the analyser, else by imaging."""

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    friction: Fraction
    cases: dict[Name, CoverageCase]
    experiments: Annotated[int, Field(ge=2)]
    events: Annotated[int, Field(ge=2)]
    level: OpenShare
    dispenser: Dispenser
    pdpa: Analyser
    ptis: ImagingSystem

    def __post_init__(self) -> None:
        """Refuse to draw a panel of nothing."""
        normal = [angle == NORMAL for case in self.cases.values() for angle in case.angles_deg]
        if not (any(normal) and not all(normal)):
            raise ValueError("cases: must hold an experiment at 90 deg and one at another angle")


def run(params: Params, inputs: Tables) -> Tables:
    """Repeat every experiment and count the intervals that hold each mean.

    ``interval_coverage``: one row per experiment, of restitution; in the column ``problem``, why
    one without events has no numbers. ``coverage_by_speed``, ``coverage_by_angle``: the same, and
    the nominal level.
    """
    contact = calibrated_contact(inputs, params.case).replace(friction=params.friction)
    rows: list[dict[str, Any]] = []
    for number, (name, case) in enumerate(params.cases.items()):
        for (i, angle), (k, speed) in product(
            enumerate(case.angles_deg), enumerate(case.speeds_m_per_s)
        ):
            drop = Drop(
                target=Target(contact=contact, surface=rough(case.slope)),
                diameter_um=case.diameter_um,
                angle=angle,
                speed=speed,
                speed_range=(speed * (1.0 - case.speed_window), speed * (1.0 + case.speed_window)),
                dispenser=params.dispenser,
            ).tabulated()
            rng = generator(params.seed, number, i, k)
            row: dict[str, Any] = {
                "case": name,
                "instrument": "PDPA" if angle == NORMAL else "PTIS",
                "angle_deg": angle,
                "speed_m_per_s": speed,
            }
            try:
                row |= coverage(params, drop, case.simulated, rng)
            except NotComputable as error:
                where = f"interval_coverage.cases.{name}, {speed:g} m/s, {angle:g} deg"
                row["problem"] = reason(where, error)
            rows.append(row | {"evidence": "virtual experiment"})
    if all("problem" in row for row in rows):
        raise NotComputedError(rows[0]["problem"])
    table = pd.DataFrame(rows)
    return {"interval_coverage": table, **drawn(table, params.level)}


def coverage(params: Params, drop: Drop, simulated: int, rng: Generator) -> dict[str, Any]:
    """Return how often the intervals of restitution hold each mean, and how wide they are.

    The means are over the events that can be measured, over all rebounds of the class, seen or
    not, and over all its impacts, captured ones with no restitution.
    """
    normal = drop.angle == NORMAL
    impacts = drop.impacts(simulated, child(rng, 0), within=NEAR_PROBE if normal else np.inf)
    repeat, shifted = (by_doppler, moved) if normal else (by_imaging, turned)
    repeated = repeat(params, drop, impacts, rng)
    measured = repeated.measured.coefficient_of_restitution
    systematic = shared_error(repeated.measured, shifted, repeated.uncertainty)["restitution"]
    sd = measured.std(axis=1, ddof=1)
    half = student_half_width(sd, params.events, systematic, params.level)
    exact = impacts.in_plane
    e, inside = exact.coefficient_of_restitution, drop.in_class(exact.speed)
    means = {
        "observable": repeated.true.coefficient_of_restitution.mean(),
        "rebounds": e[inside & ~impacts.captured].mean(),
        "all": e[inside].mean(),
    }
    row: dict[str, Any] = {"experiments": params.experiments, "half_width": float(half.mean())}
    for name, mean in means.items():
        held = np.abs(measured.mean(axis=1) - mean) <= half
        low, high = wilson_interval(int(held.sum()), held.size)
        row |= {f"mean_{name}": float(mean), f"coverage_{name}": float(held.mean())}
        row |= {f"coverage_{name}_low": low, f"coverage_{name}_high": high}
    return row


def drawn(table: pd.DataFrame, level: float) -> dict[str, pd.DataFrame]:
    """Return the coverage, by speed at normal and by angle at oblique incidence.

    The series ``nominal`` is the level of the intervals.
    """
    frames_by_axis = {}
    for axis, instrument, unit in (("speed", "PDPA", "m_per_s"), ("angle", "PTIS", "deg")):
        rows, column = table[table["instrument"] == instrument], f"{axis}_{unit}"
        known = rows[rows["coverage_observable"].notna()]
        if known.empty:
            frames_by_axis[f"coverage_by_{axis}"] = not_computed(rows["problem"].iloc[0])
            continue
        frame = partial(series_frame, axis, x_unit=unit, y_unit="percent")
        frames = [
            frame(
                f"{name}: {words}",
                own[column],
                100.0 * own[f"coverage_{which}"],
                "virtual experiment",
                *(100.0 * own[f"coverage_{which}_{end}"] for end in ("low", "high")),
            )
            for name, own in known.groupby("case", sort=False)
            for which, words in DRAWN.items()
        ]
        ends = [known[column].min(), known[column].max()]
        frames.append(frame("nominal", ends, 100.0 * level))
        frames_by_axis[f"coverage_by_{axis}"] = pd.concat(frames, ignore_index=True)
    return frames_by_axis
