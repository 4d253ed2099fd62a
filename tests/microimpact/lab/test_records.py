"""Tracks, heights and times that are known give back e and v, with errors that hold."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact import reduce_heights, reduce_times, reduce_tracks
from microimpact.core.constants import gravity
from microimpact.lab import records


def tracks(n=1, *, noise=0.0, angle=80.0, e=0.6, wall=0.0, points=10, keep=0.8, seed=1, g=gravity):
    """Points at 5 kHz of spheres of 1 m/s that hit a wall, ten before and ten after it."""
    rng = np.random.default_rng(seed)
    a, alpha = np.radians(wall), np.radians(angle)
    turn = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    before = np.array([np.cos(alpha), -np.sin(alpha)])
    parts = []
    for i in range(n):
        t = (np.arange(-points, points) + rng.uniform()) / 5000.0
        place = np.where((t < 0)[:, None], t[:, None] * before, t[:, None] * before * [keep, -e])
        place[:, 0] += rng.uniform(-2e-3, 2e-3)
        place = place @ turn.T
        place[:, 1] -= 0.5 * g * t**2
        place += noise * rng.standard_normal(place.shape)
        parts.append(np.column_stack([t + i, place, np.full(t.size, i)]))
    return np.concatenate(parts).T


def normal(found):
    return found.v * np.sin(np.radians(found.angle))


@pytest.mark.parametrize("wall", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("angle", [20.0, 80.0])
@pytest.mark.parametrize("with_gravity", [True, False])
def test_exact_tracks_give_exact_rebounds(wall, angle, with_gravity):
    data = tracks(5, angle=angle, wall=wall, g=gravity if with_gravity else 0.0)
    found = reduce_tracks(*data, wall=wall, with_gravity=with_gravity, diameter=62e-6)
    assert found.used.all()
    assert found.e == pytest.approx(np.full(5, 0.6), rel=1e-6)
    assert found.v == pytest.approx(np.ones(5), rel=1e-6)
    assert found.angle == pytest.approx(np.full(5, angle), rel=1e-6)
    tangent = 0.2 / np.tan(np.radians(angle)) / 1.6
    assert found.impulse_ratio == pytest.approx(np.full(5, tangent), abs=1e-6)
    assert found.d == pytest.approx(np.full(5, 62e-6))


@pytest.mark.parametrize("wall", [0.0, 30.0, "find"])
@pytest.mark.parametrize("points", [4, 10])
def test_sigma_holds_68_percent(wall, points):
    """Of 1,500 tracks, by 3 of their standard errors of 1.2 %; the bias is below a tenth."""
    data = tracks(1500, noise=2e-6, wall=30.0 if wall == 30.0 else 0.0, points=points)
    found = reduce_tracks(*data, wall=wall)
    assert np.mean(found.used) > 0.99
    good = found.select(found.used)
    sigma_v = good.sigma_v * np.sin(np.radians(good.angle))
    for off, sigma in (
        (good.e - 0.6, good.sigma),
        (normal(good) - np.sin(np.radians(80.0)), sigma_v),
    ):
        assert np.mean(np.abs(off) < sigma) == pytest.approx(0.683, abs=0.037)
        assert abs(np.mean(off)) < 0.1 * np.mean(sigma)


def test_the_tilt_is_in_the_errors():
    data = tracks(1, angle=45.0)
    found = [reduce_tracks(*data, wall=wall, tilt=0.5) for wall in (0.0, 0.5)]
    assert float(found[0].sigma[0]) == pytest.approx(abs(found[1].e[0] - found[0].e[0]), rel=0.05)


def test_every_bounce_of_a_track_is_an_impact():
    """Vertical bounces with e = 0.7, ten or more points to a flight."""
    v, begin, parts = 1.0, 0.0, [np.array([-0.03 + 0.002 * i for i in range(14)])]
    heights = [-v * parts[0] - 0.5 * gravity * parts[0] ** 2]
    for _ in range(4):
        v *= 0.7
        t = np.arange(0.001, 2.0 * v / gravity, 0.002)
        parts.append(begin + t)
        heights.append(v * t - 0.5 * gravity * t**2)
        begin += 2.0 * v / gravity
    time, y = np.concatenate(parts), np.concatenate(heights)
    found = reduce_tracks(time, 0.0 * time, y, wall=0.0)
    assert found.e == pytest.approx(np.full(4, 0.7), abs=1e-6)
    assert found.v == pytest.approx(0.7 ** np.arange(4.0), rel=1e-6)


def test_a_sphere_that_stays_is_captured():
    time, x, y, track = tracks(20, noise=1e-6, e=0.0, keep=0.0)
    after = time > track
    y[after] += 0.5 * gravity * (time - track)[after] ** 2
    found = reduce_tracks(time, x, y, track, wall=0.0)
    assert found.captured.all()
    assert np.all(found.e == 0.0)
    assert normal(found) == pytest.approx(np.full(20, np.sin(np.radians(80.0))), rel=0.02)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda t, x, y: (t[:5], x[:5], y[:5]), "5 points; 3 before and 3 after are needed"),
        (lambda t, x, y: (t[:8], x[:8], y[:8]), "no impact: it is one flight"),
        (lambda t, x, y: (np.where(t == t[3], t[2], t), x, y), "two points at"),
        (lambda t, x, y: (t, x + (t > 0) * 1e-3, y), "its flights do not meet"),
        (lambda t, x, y: (-t, x, y), "is above 1 by more than its error"),
        (lambda t, x, y: (t, x + t * (t > 0), y - 2.0 * t * (t > 0)), "does not turn at the wall"),
    ],
)
def test_a_track_that_cannot_be_used_has_its_reason(change, reason):
    good = tracks(3, noise=1e-7)
    bad = change(*tracks(1, noise=1e-7)[:3])
    data = [np.concatenate(pair) for pair in zip(good[:3], bad, strict=True)]
    names = [*good[3], *["bad"] * len(bad[0])]
    found = reduce_tracks(*data, names, wall=0.0)
    assert found.used.tolist() == [True, True, True, False]
    assert found.track[-1] == "bad"
    assert reason in found.reason[-1]
    assert np.isnan(found.e[-1])


def test_a_wall_that_cannot_be_found_is_asked_for():
    one = tracks(1)[:3]
    again = (np.tile(one, 6) + 1e-6 * np.random.default_rng(2).standard_normal((3, 120)))[1:]
    for data in (tracks(2), (np.tile(one[0], 6), *again, np.repeat(np.arange(6), 20))):
        with pytest.raises(ValueError, match="wall must be given: "):
            reduce_tracks(*data, wall="find")


def test_the_fall_of_the_track_is_measured():
    found = reduce_tracks(*tracks(200, noise=1e-6), wall=0.0)
    assert np.mean((found.fall - gravity) / found.sigma_fall) == pytest.approx(0.0, abs=0.25)
    assert np.std((found.fall - gravity) / found.sigma_fall) == pytest.approx(1.0, abs=0.2)


def test_heights_in_vacuum():
    found = reduce_heights([0.1, 0.2, 0.1], [0.025, 0.0, 0.2], sigma=1e-4)
    assert found.e[0] == pytest.approx(0.5)
    assert found.v[:2] == pytest.approx(np.sqrt(2.0 * gravity * np.array([0.1, 0.2])))
    assert found.sigma[0] == pytest.approx(0.25 * np.hypot(1e-4 / 0.025, 1e-4 / 0.1), rel=1e-3)
    assert found.captured.tolist() == [False, True, False]
    assert found.reason[2] == "its rebound is faster than its impact"


def test_heights_in_air_reach_the_terminal_speed_of_stokes():
    """A glass sphere of 20 um: Re = 0.04, of which Schiller and Naumann make 1.6 %."""
    d, density = 20e-6, 2500.0
    stokes = density * d**2 * gravity / (18.0 * records.AIR_VISCOSITY)
    found = reduce_heights([0.1], [1e-6], diameter=d, density=density)
    assert found.v[0] == pytest.approx(stokes, rel=0.03)
    assert found.v[0] < stokes
    heavy = reduce_heights([0.1], [0.03], diameter=1.0, density=1e6)
    assert heavy.v[0] == pytest.approx(np.sqrt(0.2 * gravity), rel=1e-4)


def test_times_of_bounces():
    e, clock, rng = 0.8, 1e-4, np.random.default_rng(3)
    exact = np.concatenate([[0.0], np.cumsum(0.3 * e ** np.arange(4.0))])
    found = reduce_times(exact, sigma=clock)
    assert found.e == pytest.approx(np.full(3, e))
    assert found.v == pytest.approx(0.15 * gravity * e ** np.arange(3.0))
    drawn = exact + clock * rng.standard_normal((4000, 5))
    spread = np.std([reduce_times(times).e for times in drawn], axis=0)
    assert found.sigma == pytest.approx(spread, rel=0.05)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: reduce_times([0.0, 1.0]), "times must be three or more that ascend"),
        (lambda: reduce_heights([0.1], [-0.1]), "risen must be finite and >= 0, got -0.1"),
        (lambda: reduce_heights([0.1], [0.1, 0.2]), "of one length, got 1 and 2"),
        (lambda: reduce_heights([0.1], [0.0], density=2500.0), "diameter must be finite and > 0"),
        (lambda: reduce_tracks([0, 1], [0], [0], wall=0.0), "of one length above 0, got 2, 1, 1"),
        (lambda: reduce_tracks(*tracks()[:3], wall=np.nan), "wall must be finite, got nan"),
        (lambda: reduce_tracks(*tracks()[:3], wall=0.0, tilt=-1.0), "tilt must be finite and >= 0"),
        (lambda: reduce_tracks(*tracks()[:3], [1], wall=0.0), "one name for each point, 20, got 1"),
    ],
)
def test_bad_numbers_are_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
