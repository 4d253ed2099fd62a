"""Many repetitions of one experiment, drawn from a pool of impacts that are simulated once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.lab.events import Impacts, IntArray, Measured
from microimpact.lab.experiment import Drop
from microimpact.lab.pdpa import analyser as pdpa
from microimpact.lab.pdpa.pairing import correct, heights
from microimpact.lab.ptis import system as ptis
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.experiment import in_sheet, turned
from microimpact.lab.ptis.exposure import MEASURED
from microimpact.statistics.distributions import mean

# Spheres that may be measured in some experiment: they arrive no further from the middle of the
# probe volume than this, m, cross one that is wider by this factor and so many standard deviations
# lower, at speeds that a noise of as many may bring into the class.
NEAR_PROBE = 3e-4
WIDER = 1.15
REACH = 4.0
# Looked at in one experiment: so many standard deviations more than it needs on average.
SPARE = 6.0
# Experiments with the analyser, by height of its probe, are repeated in so many groups.
GROUPS = 50
# Searches for the height of the probe: each starts from the last.
ROUNDS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeated:
    """Repetitions of one experiment.

    Attributes
    ----------
    measured, true
        Accepted events as measured and as they were, fields of shape (experiments, events).
    uncertainty
        Standard uncertainty of the systematic error, shape (experiments, 1): of the probe's
        height, m, or of the target's angle, degrees.
    impacts
        All simulated impacts, seen or not.
    observable
        Share of them that can be measured.
    """

    measured: Measured
    true: Measured
    uncertainty: FloatArray
    impacts: Impacts
    observable: float


def by_imaging(
    experiments: int,
    events: int,
    number: int,
    drop: Drop,
    instrument: ptis.Instrument,
    rng: Generator,
) -> Repeated:
    """Repeat an oblique experiment.

    Scale, rate and angle are wrong by other amounts in each experiment; they stretch and turn all
    its velocities alike. Which events can be measured is taken not to depend on them.

    Parameters
    ----------
    experiments, events
        How many, of how many events.
    number
        Impacts to simulate.
    drop
        What is dropped on what; its range is of measured speeds.
    instrument
        Settings.
    rng
        Its children serve the draws.
    """
    impacts = drop.impacts(number, ptis.child(rng, 0))
    setup = ptis.Setup(
        instrument=instrument,
        angle=drop.angle,
        speed=drop.speed,
        diameter=1e-6 * mean(drop.diameter_um),
    )
    moving = np.flatnonzero(~impacts.captured & in_sheet(impacts.position, instrument))
    draws = [ptis.event_generator(rng, i) for i in moving.tolist()]
    fates, found = theory(impacts.select(moving), setup, ptis.Systematics(), draws)
    pool = moving[fates == MEASURED]
    speed = np.linalg.norm(found.velocities[:, 0], axis=1)
    reach = REACH * np.hypot(instrument.rate_error, instrument.scale_error)
    share = min(_share(drop.in_class(speed * (1.0 + wrong))) for wrong in (-reach, reach))

    draw = ptis.child(rng, 2)
    chosen = draw.integers(pool.size, size=(experiments, _enough(events, share)))
    noise = np.linalg.cholesky(found.covariance)[chosen] @ draw.standard_normal(
        (*chosen.shape, 2, 2, 1)
    )
    rate, scale, angle = draw.standard_normal((3, experiments, 1))
    stretch = 1.0 / (1.0 + instrument.rate_error * rate) / (1.0 + instrument.scale_error * scale)
    velocity = (found.velocities[chosen] + noise[..., 0]) * stretch[..., None, None]
    seen = Measured(
        event=pool[chosen],
        incident_tangential=velocity[..., 0, 0],
        incident_normal=velocity[..., 0, 1],
        rebound_tangential=velocity[..., 1, 0],
        rebound_normal=velocity[..., 1, 1],
    )
    seen = turned(seen, instrument.angle_error_deg * angle)
    measured = _first(seen, drop.in_class(seen.speed), events)
    return Repeated(
        measured=measured,
        true=impacts.in_plane.select(measured.event),
        uncertainty=np.full((experiments, 1), instrument.angle_error_deg),
        impacts=impacts,
        observable=pool.size / number,
    )


def by_doppler(
    experiments: int,
    events: int,
    number: int,
    drop: Drop,
    instrument: pdpa.Instrument,
    rng: Generator,
) -> Repeated:
    """Repeat a normal experiment, with the right pairs: the search for them is not repeated.

    The height of the probe volume is another in each experiment, and decides which spheres cross
    it; it is found from the delays of the pairs, as in an experiment.

    Parameters
    ----------
    experiments, events, number, drop, instrument, rng
        As in `by_imaging`; only particles that arrive near the probe volume are followed.
    """
    impacts = drop.impacts(number, ptis.child(rng, 0), within=NEAR_PROBE)
    pool = impacts.select(_may_be_measured(impacts, instrument, drop.speed_range))
    draw = ptis.child(rng, 2)
    usual = 1e-3 * instrument.probe_height_mm
    error = 1e-6 * instrument.probe_height_error_um
    height = np.sort(usual + error * draw.standard_normal(experiments))
    parts = [
        _doppler_experiments(pool, of, events, instrument, drop, draw)
        for of in np.array_split(height, GROUPS)
        if of.size
    ]
    return Repeated(
        measured=Measured.joined([part[0] for part in parts]),
        true=Measured.joined([part[1] for part in parts]),
        uncertainty=np.concatenate([part[2] for part in parts]),
        impacts=impacts,
        observable=float(np.mean(pdpa.passages(impacts, usual, instrument).crossed.all(axis=0))),
    )


def _doppler_experiments(
    pool: Impacts,
    height: FloatArray,
    events: int,
    instrument: pdpa.Instrument,
    drop: Drop,
    rng: Generator,
) -> tuple[Measured, Measured, FloatArray]:
    """Return events as measured and as they were, and the uncertainty of the height found, m.

    One experiment for each height of the probe volume, in ascending order: at the last one the
    fewest spheres rise into it.
    """
    crossing = pdpa.passages(pool, height[-1], instrument).crossed.all(axis=0)
    share = _share(crossing & drop.in_class(np.abs(pool.velocity[:, 2])))
    number = _enough(events, share * (1.0 - instrument.drop_out) ** 2)
    chosen = rng.integers(len(pool), size=(height.size, number))
    stream, pairs = _recorded(pool, chosen, height, instrument, rng)
    paired = (pairs >= 0).all(axis=0)
    falling, rising = np.where(paired, stream.velocity[pairs], np.nan)
    usual = 1e-3 * instrument.probe_height_mm
    seen = Measured(
        event=np.arange(paired.size).reshape(paired.shape),
        incident_normal=falling,
        incident_tangential=np.zeros(paired.shape),
        rebound_normal=rising,
        rebound_tangential=np.zeros(paired.shape),
    )
    speed = np.abs(np.asarray(correct(falling, usual)))
    # A rebound that seems to fall, by its noise, is no candidate in the search for pairs.
    kept = _first(seen, drop.in_class(speed) & (rising > 0.0), events)
    estimate = usual * (1.0 + instrument.initial_estimate_error)
    used = pairs.reshape(2, -1)[:, kept.event]
    found = np.array([estimate, np.nan])[:, None]
    for _ in range(ROUNDS):
        found = np.stack(heights(stream, used, found[0], instrument))
    measured = replace(
        kept,
        incident_normal=np.asarray(correct(kept.incident_normal, found[0, :, None])),
        rebound_normal=np.asarray(correct(kept.rebound_normal, found[0, :, None])),
    )
    return measured, pool.in_plane.select(chosen.ravel()[kept.event]), found[1, :, None]


def _may_be_measured(
    impacts: Impacts, instrument: pdpa.Instrument, speed_range: tuple[float, float]
) -> IntArray:
    """Return which impacts can be events of some experiment."""
    larger = replace(
        instrument,
        probe_across_um=WIDER * instrument.probe_across_um,
        probe_along_um=WIDER * instrument.probe_along_um,
    )
    lowest = 1e-3 * instrument.probe_height_mm
    lowest -= 1e-6 * REACH * instrument.probe_height_error_um
    speed = np.abs(impacts.velocity[:, 2])
    noise = REACH * instrument.velocity_noise(speed)
    near = pdpa.passages(impacts, lowest, larger).crossed.all(axis=0) & ~impacts.captured
    near &= (speed >= speed_range[0] - noise) & (speed <= speed_range[1] + noise)
    return np.flatnonzero(near)


def _recorded(
    impacts: Impacts,
    chosen: IntArray,
    height: FloatArray,
    instrument: pdpa.Instrument,
    rng: Generator,
) -> tuple[pdpa.Stream, IntArray]:
    """Record impacts (experiments, k) one by one; where in the stream both records are, or -1."""
    apart = replace(impacts.select(chosen.ravel()), time=np.arange(chosen.size, dtype=float))
    levels = np.repeat(height, chosen.shape[1])
    quiet = replace(instrument, false_records_per_s=0.0)
    stream, truth = pdpa.records(pdpa.passages(apart, levels, quiet), 0.0, quiet, rng)
    pairs = np.full((2, chosen.size), -1)
    pairs[truth.leg, truth.impact] = np.arange(len(stream))
    return stream, pairs.reshape(2, *chosen.shape)


def _share(good: BoolArray) -> float:
    return float(np.mean(good)) if good.size else 0.0


def _enough(events: int, share: float) -> int:
    """Return how many must be looked at to be sure of so many events."""
    if share <= 0.0:
        raise ValueError(f"no event in the speed range can be measured: {events} are wanted")
    # n p - SPARE sqrt(n p (1 - p)) = events
    spread = 0.5 * SPARE * np.sqrt(1.0 - share)
    return int(np.ceil((spread + np.sqrt(spread**2 + events)) ** 2 / share))


def _first(measured: Measured, good: BoolArray, events: int) -> Measured:
    """Return the first good events of each experiment, shape (experiments, events)."""
    if np.any(good.sum(axis=1) < events):
        raise ValueError(f"too few events in some experiments: {events} are wanted")
    order = np.argsort(~good, axis=1, kind="stable")[:, :events]
    names = Measured.__dataclass_fields__
    return Measured(**{k: np.take_along_axis(getattr(measured, k), order, 1) for k in names})
