"""Search for pairs in a stream, estimate of the height, and correction to the surface."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from scipy.constants import g
from tests.microimpact.lab.pdpa.test_pdpa import DEFAULT, QUIET, impacts

from microimpact.lab.bounces import with_later_impacts
from microimpact.lab.pdpa.analyser import RecordStream, passages, records
from microimpact.lab.pdpa.experiment import FATES, observe, pair_events
from microimpact.lab.pdpa.pairing import (
    assign,
    correct,
    delay,
    delay_noise,
    estimate_height,
    height_from_delay,
    matched,
    search,
)
from microimpact.lab.surface import Rebound

H = 1e-3


def experiment(seed, n=300, speed=0.75, e=0.65, gap=7e-3):
    """Return spheres that arrive at random, a few within the time of one flight."""
    rng = np.random.default_rng([11, seed])
    v = np.hypot(speed, rng.normal(0.0, 0.15, n))
    V = v * np.clip(rng.normal(e, 0.02, n), 0.05, 1.0)
    d = np.clip(rng.normal(50e-6, 9e-6, n), 10e-6, 65e-6)
    return impacts(v, V, time=0.1 + np.cumsum(rng.exponential(gap, n)), d=d)


def never(velocity, spin, sphere):
    """Keep whoever falls back."""
    kept = np.ones(len(sphere), dtype=bool)
    return Rebound(velocity=0.0 * velocity, spin=spin, kept=kept, contacts=np.ones_like(sphere))


def observed(some, later, duration, rng, **options):
    everything = with_later_impacts(some, later)
    return observe(everything, len(some), duration, DEFAULT, rng, **options)


def stream_of(some, instrument=DEFAULT, height=H, seed=0):
    crossing = passages(some, height, instrument)
    rng = np.random.default_rng([12, seed])
    return records(crossing, float(some.time[-1]) + 0.1, instrument, rng)


def test_exact_correction_is_that_of_free_fall_on_both_legs():
    v, V = np.array([-0.3, -1.66]), np.array([0.2, 1.2])
    at_probe = -np.sqrt(v**2 - 2 * g * H), np.sqrt(V**2 - 2 * g * H)
    assert correct(at_probe[0], H) == pytest.approx(v, rel=1e-14)
    assert correct(at_probe[1], H) == pytest.approx(V, rel=1e-14)


def test_delay_is_the_time_of_flight_and_the_height_its_inverse():
    v, V = np.array([0.265, 0.74, 1.65, 0.5]), np.array([0.05, 0.5, 1.2, 0.6])
    for h in (0.5e-3, 5e-3):
        time = delay(-v, V, h)
        fall = (np.sqrt(v**2 + 2 * g * h) - v) / g
        rise = (np.sqrt(V**2 + 2 * g * h) - V) / g
        assert time == pytest.approx(fall + rise, rel=1e-12)
        assert height_from_delay(-v, V, time) == pytest.approx(h, rel=1e-11)


def test_noise_of_the_delay_is_that_of_its_parts():
    rng, v, V = np.random.default_rng(1), np.array([-0.74]), np.array([0.2])
    spread, slope = delay_noise(v, V, H, DEFAULT)
    drawn = delay(
        *(s + DEFAULT.velocity_noise(s) * rng.standard_normal(40000) for s in (v, V)), H
    ) + np.diff(rng.uniform(-5e-6, 5e-6, (2, 40000)), axis=0)
    assert np.std(drawn) == pytest.approx(spread[0], rel=0.02)
    assert slope[0] == pytest.approx(
        (delay(v, V, H + 1e-8) - delay(v, V, H - 1e-8))[0] / 2e-8, rel=1e-6
    )


def test_two_rounded_stamps_differ_by_a_triangle_of_errors():
    """Each is off by a uniform error of a clock's step, of variance 1/12."""
    rounding = replace(QUIET, time_resolution_us=10.0)
    spread, _ = delay_noise(np.array([-0.74]), np.array([0.2]), H, rounding)
    assert spread == pytest.approx(10e-6 / np.sqrt(6), rel=1e-12)
    some = experiment(3, n=2000)
    stamps, true = (
        records(passages(some, H, clock), 1e3, clock, np.random.default_rng(1))[0].time
        for clock in (rounding, QUIET)
    )
    assert np.std(stamps - true) == pytest.approx(10e-6 / np.sqrt(12), rel=0.05)


def test_a_quiet_stream_is_paired_perfectly_and_gives_the_true_speeds():
    # a probe volume so thin that the mean over the transit is the speed in its middle
    thin = replace(QUIET, probe_across_um=1e-4, probe_along_um=1e-4)
    some = experiment(0)
    stream, truth = stream_of(some, thin)
    found = search(stream, 1.2e-3, DEFAULT)
    event = pair_events(found, truth)
    # in order of the passages: a fast sphere may overtake a slow one above the surface
    assert sorted(event) == list(range(len(some)))
    assert found.converged
    assert found.height == pytest.approx(H, rel=1e-9)
    before, after = (
        correct(stream.velocity[i], found.height) for i in (found.incident, found.rebound)
    )
    assert before == pytest.approx(some.velocity[event, 2], rel=1e-9)
    assert after == pytest.approx(some.rebound_velocity[event, 2], rel=1e-9)


@pytest.mark.parametrize(("speed", "e"), [(0.3, 0.6), (0.75, 0.65), (1.66, 0.7)])
def test_pairs_are_found_at_the_declared_noise(speed, e):
    pairs = true = both = 0
    for seed in range(8):
        stream, truth = stream_of(experiment(seed, speed=speed, e=e), seed=seed)
        event = pair_events(search(stream, 1.2e-3, DEFAULT), truth)
        pairs, true = pairs + len(event), true + int(np.sum(event >= 0))
        both += int(np.sum(np.all(truth.recorded, axis=0)))
    assert true / pairs > 0.99
    # two outliers of 1 % each, of which half leave the window, and its own 2 x 0.3 %
    assert true / both > 0.96


@pytest.mark.parametrize("start", [0.8, 1.2])
def test_the_height_is_found_within_its_standard_error(start):
    pulls = []
    for seed in range(40):
        height = 1e-3 + 5e-5 * np.random.default_rng(seed).standard_normal()
        stream, _ = stream_of(experiment(seed, n=80), height=height, seed=seed)
        found = search(stream, start * 1e-3, DEFAULT)
        assert found.converged
        pulls.append((found.height - height) / found.height_error)
        assert found.height_error < 5e-6
    assert abs(np.mean(pulls)) < 3 / np.sqrt(40)
    assert 0.7 < np.std(pulls) < 1.3


def test_without_rebounds_hardly_anything_is_paired():
    some = experiment(4, n=1000)
    some.captured[:] = True
    stream, truth = stream_of(some)
    found = search(stream, 1.2e-3, DEFAULT)
    assert np.sum(truth.impact == -1) > 0
    assert len(found.incident) <= 2
    assert not found.converged
    assert (found.height, found.height_error) == (1.2e-3, pytest.approx(0.24e-3))


def test_competing_pairs_are_settled_by_their_total_worth():
    rng = np.random.default_rng(6)
    for _ in range(200):
        worth = np.where(rng.random((4, 4)) < 0.6, rng.uniform(0.1, 1.0, (4, 4)), 0.0)
        incident, rebound = np.nonzero(worth)
        chosen = matched(10 + incident, 50 + rebound, worth[incident, rebound])
        assert len(set(incident[chosen])) == len(set(rebound[chosen])) == len(chosen)
        best = max(sum(worth[range(4), list(p)]) for p in permutations(range(4)))
        assert worth[incident, rebound][chosen].sum() == pytest.approx(best, rel=1e-12)


def test_a_few_wrong_pairs_hardly_move_the_height():
    stream, _ = stream_of(experiment(10))
    found = search(stream, 1.2e-3, DEFAULT)
    pairs, usual = np.stack([found.incident, found.rebound]), np.asarray(H)
    clean, error = estimate_height(stream, pairs, usual, DEFAULT)
    late = stream.time.copy()
    late[found.rebound[::20]] += 5e-3
    moved, wider = estimate_height(replace(stream, time=late), pairs, usual, DEFAULT)
    # their mean would move by 80 um, 160 standard errors
    assert abs(moved - clean) < 1.5 * error
    assert wider > 5 * error


def test_an_experiment_accounts_for_every_impact():
    some = experiment(11, speed=0.5, e=0.4)
    some.captured[:30] = True
    some.position[30:60] = 1.0
    found = observed(some, never, 10.0, np.random.default_rng(1))
    quality = found.quality
    assert tuple(quality.fates) == FATES
    assert sum(quality.fates.values()) == len(some)
    assert quality.fates["incident missed probe"] == 30
    assert quality.fates["captured"] == 30
    assert quality.fates["paired"] == quality.true_pairs
    assert quality.true_pairs > 0.97 * quality.pairs
    assert quality.true_pairs > 0.93 * quality.recorded_pairs
    assert quality.fates["paired"] < quality.seen_rebounds < len(some) - 30
    measured, true = found.at_surface(), found.impacts
    event = measured.event
    good = event >= 0
    exact = np.array([of[event[good], 2] for of in (true.velocity, true.rebound_velocity)])
    assert np.array(measured.normal)[:, good] == pytest.approx(exact, abs=0.03)
    assert not np.any(measured.tangential)


def test_a_second_bounce_is_a_genuine_pair():
    e = 0.6

    def later(velocity, spin, sphere):
        after, kept = velocity * [1.0, 1.0, -e], np.zeros(len(sphere), dtype=bool)
        return Rebound(velocity=after, spin=spin, kept=kept, contacts=np.ones_like(sphere))

    some = impacts(np.full(100, 1.0), e, time=0.1 + 0.5 * np.arange(100))
    found = observed(some, later, 60.0, np.random.default_rng(2))
    # 1, 0.6 and 0.36 m/s rebound through the probe volume; 0.216 m/s leaves with 0.13 m/s
    measured = found.at_surface()
    again = measured.event >= 100
    assert np.sum(again) == pytest.approx(200, abs=25)
    assert measured.coefficient_of_restitution[again] == pytest.approx(e, abs=0.08)


@pytest.mark.parametrize("likest", [1, 2])
def test_of_two_rebounds_alike_in_time_the_one_of_its_size_is_taken(likest):
    sizes = np.full(3, 50e-6)
    # a difference of one standard deviation, well inside the window
    sizes[3 - likest] *= 1.0 + np.hypot(*2 * (DEFAULT.diameter_noise(50e-6),))
    v, V = -0.75, 0.5
    stream = RecordStream(
        time=np.array([0.0, *2 * (float(delay(v, V, H)),)]),
        velocity=np.array([v, V, V]),
        diameter=sizes,
    )
    incident, rebound = assign(stream, H, 1e-6, DEFAULT)
    assert (incident.tolist(), rebound.tolist()) == ([0], [likest])
