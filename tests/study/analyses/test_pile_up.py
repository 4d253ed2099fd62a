"""Piles on the target, and spheres that bounce until they rest."""

from __future__ import annotations

import numpy as np
import pytest
from tests.shared import STILL

from microimpact.lab.bounces import resting
from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.events import Falling
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.statistics.distributions import TruncatedNormal, generator
from study.analyses.pile_up.compute import onset
from study.samples import Dropped

STEEL = Dropped(
    case="none",
    friction=0.15,
    diameter_um=TruncatedNormal(mean=62, sd=0.01, low=61, high=63),
    surface_slope=0.0,
    particle_slope=0.0,
    speed_m_per_s=1.66,
    speed_range_m_per_s=(1.6, 1.72),
    spin=NO_SPIN,
)


@pytest.fixture(scope="module")
def piles(run_study, calibration, made):
    known = {**calibration, "evidence_summary": made("inference")["evidence_summary"]}
    return run_study("pile_up", known, spheres=300, speeds_m_per_s=[0.2, 0.3, 0.5, 0.8, 1.2, 2.0])


def test_a_pile_does_not_need_capture_in_one_impact(piles):
    onsets = piles["pile_up_onsets"]
    half = onsets[(onsets["share"] == 0.5) & (onsets["slope_deg"] == 2.0)].set_index("contact")
    printed, lower = (half.loc[[name], "onset_m_per_s"].to_numpy() for name in ("printed", "lower"))
    assert (printed > half.loc[["printed"], "first_impact_onset_m_per_s"] + 0.2).all()
    posterior = half.loc[["posterior"], "onset_m_per_s"].to_numpy()
    assert (lower < posterior).all()
    # Larger targets keep more.
    assert (np.diff(printed) > 0.0).all()
    table = piles["pile_up"]
    assert (table["share_on_target"] >= table["share_captured_at_first_impact"]).all()


def falling_from(position, velocity, spin):
    """What arrives on smooth steel spheres of 62 um."""
    n = len(velocity)
    return Falling(
        time=np.zeros(n),
        diameter=np.full(n, 62e-6),
        position=np.array(position),
        velocity=np.array(velocity),
        spin=np.array(spin),
    )


def test_bounces_end_where_a_ball_would(contact):
    """Straight up and down with a drift: flight 2 V/g, a geometric series until capture."""
    drop, rng = STEEL.drop(contact, 90.0, STILL), generator(0)
    drift, speed = 0.004, 0.3
    rolls = [[0.0, drift / 31e-6, 0.0]]  # already: friction does nothing
    first = drop.hit(falling_from([[0.0, 0.0]], [[drift, 0.0, -speed]], rolls), rng)
    found = resting(first, drop.target.later(first.diameter, rng), 60, 1.0)
    way, v, count = 0.0, speed, 1
    while v >= float(capture_velocity(contact)):
        v *= float(simulate(contact, v).coefficient_of_restitution)
        way += drift * 2 * v / 9.80665
        count += 1
    assert found.captured.all()
    assert found.impacts[0] == count
    assert found.reach[0] == pytest.approx(way, rel=1e-6)
    assert found.on_target(1.01 * way).all()
    assert not found.on_target(0.99 * way).any()


def test_spheres_past_the_edge_are_let_go(contact):
    drop, rng = STEEL.drop(contact, 90.0, STILL), generator(0)
    velocity = [[0.5, 0.0, -0.5], [0.0, 0.0, -0.5]]
    first = drop.hit(falling_from(np.zeros((2, 2)), velocity, np.zeros((2, 3))), rng)
    found = resting(first, drop.target.later(first.diameter, rng), 60, 1e-3)
    assert found.captured.tolist() == [False, True]
    assert found.impacts[0] == 1
    assert found.impacts[1] > 3


def test_onset_is_the_last_crossing():
    speed = np.array([0.1, 0.2, 0.3, 0.4])
    assert onset(speed, np.array([0.9, 0.6, 0.4, 0.0]), 0.5) == pytest.approx(0.25)
    assert np.isnan(onset(speed, np.zeros(4), 0.5))
    assert np.isnan(onset(speed, np.ones(4), 0.5))
