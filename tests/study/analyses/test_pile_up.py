"""Piles on the target, and spheres that bounce until they rest."""

from __future__ import annotations

import numpy as np
import pytest
from tests.shared import STILL

from microimpact.lab.bounces import resting
from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.events import Falling
from microimpact.model.contact import resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.distributions import TruncatedNormal, generator
from study.analyses.pile_up.compute import Params, contacts, onset
from study.declared.parameters import build
from study.samples import Dropped
from study.tables import parse_table

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


SPEEDS = [0.2, 0.3, 0.5, 0.8, 1.2]
GRAVITY = 9.80665


@pytest.fixture(scope="module")
def known(calibration, made):
    return {**calibration, "evidence_summary": made("inference")["evidence_summary"]}


@pytest.fixture(scope="module")
def params(settings):
    return build(Params, settings.branches["pile_up"])


@pytest.fixture(scope="module")
def spheres_of(params, known, settings):
    """Contacts by name, at the mean diameter."""
    rows = {name: parse_table(text) for name, text in settings.rows["pile_up"].items()}
    return contacts(params, {**rows, **known})


@pytest.fixture(scope="module")
def piles(run_study, known):
    return run_study("pile_up", known, spheres=300, speeds_m_per_s=[*SPEEDS, 2.0])


def test_a_pile_does_not_need_capture_in_one_impact(piles):
    onsets = piles["pile_up_onsets"]
    half = onsets[(onsets["share"] == 0.5) & (onsets["slope_deg"] == 2.0)].set_index("contact")
    printed = half.loc[["printed"], "onset_m_per_s"].to_numpy()
    assert (printed > half.loc[["printed"], "first_impact_onset_m_per_s"] + 0.2).all()
    # Larger targets keep more.
    assert (np.diff(printed) > 0.0).all()
    table = piles["pile_up"]
    assert (table["share_on_target"] >= table["share_captured_at_first_impact"]).all()


def test_spheres_dropped_straight_stay_as_bounces_on_tilted_facets_say(
    run_study, known, settings, params, spheres_of
):
    """A bounce to first order in slopes, from restitutions and capture velocities alone."""
    branch, spheres, tries, radius, slope = settings.branches["pile_up"], 1000, 2000, 5.0, 2.0
    straight = {key: 0.0 for key in branch["dispenser"] if "exit" in key or "lateral" in key}
    changes = {"speeds_m_per_s": SPEEDS, "slopes_deg": [slope], "dispenser": straight}
    table = run_study("pile_up", known, spheres=spheres, **changes)["pile_up"]
    table = table[table["target_radius_mm"] == radius].set_index(["contact", "speed_m_per_s"])
    sizes = 1e-6 * params.diameter_um.quantile((np.arange(tries) + 0.5) / tries)
    for name, contact in spheres_of.items():
        bodies = resized(contact, sizes)
        at_once, rest = (
            table.loc[name, column]
            for column in ("share_captured_at_first_impact", "share_on_target")
        )
        for speed in SPEEDS:
            captured = np.mean(capture_velocity(bodies) > speed)
            stay = share_at_rest(bodies, speed, np.tan(np.radians(slope)), 1e-3 * radius)
            for found, share in ((at_once[speed], captured), (rest[speed], stay)):
                error = np.sqrt(max(share * (1.0 - share), 1e-3) * (1 / spheres + 1 / tries))
                assert found == pytest.approx(share, abs=4.0 * error), (name, speed)
    strength = table["capture_velocity_m_per_s"].groupby("contact").first()
    assert strength["lower"] < strength["posterior"] < strength["printed"]


def share_at_rest(bodies, speed, slope, radius):
    """Share of spheres that come to rest: small tilts of each facet, contacts that end rolling."""
    rng, n = np.random.default_rng(7), bodies.shape[0]
    down, along, rim, way = np.full(n, speed), *np.zeros((3, n, 2))
    rests, still_bounces = np.zeros(n, bool), np.ones(n, bool)
    while still_bounces.any():
        tilt = slope * rng.standard_normal((n, 2))
        normal = np.maximum(down + np.sum(along * tilt, axis=1), 1e-6)
        e = normal_impact(bodies, normal).coefficient_of_restitution
        rests |= still_bounces & (e == 0.0)
        rim = (5.0 * (along - down[:, None] * tilt) + 2.0 * rim) / 7.0
        along, down = rim - (e * normal)[:, None] * tilt, e * normal + np.sum(rim * tilt, axis=1)
        way = way + along * (2.0 * down / GRAVITY)[:, None]
        still_bounces &= (e > 0.0) & (np.hypot(*way.T) <= radius)
    return rests.mean()


def test_the_contact_of_the_posterior_has_its_median_and_the_printed_restitution(known, spheres_of):
    contact = spheres_of["posterior"]
    table = known["evidence_summary"].set_index(["case", "scenario", "law", "quantity"])["median"]
    median = table.sort_index()[("steel-silicon", "0.18 m/s alone", "all laws", "v_c_m_per_s")]
    assert capture_velocity(contact) == pytest.approx(median, rel=1e-5)
    assert float(simulate(contact, 1.66).coefficient_of_restitution) == pytest.approx(0.7, abs=1e-6)


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
        way += drift * 2 * v / GRAVITY
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
