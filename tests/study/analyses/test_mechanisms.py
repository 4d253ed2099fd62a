"""Mechanisms each alone: samples of virtual impacts, their comparison, and the pieces of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.shared import STILL, facet_rebound

from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.experiment import Target
from microimpact.lab.reduction import EXACT
from microimpact.lab.surface import rough
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.statistics.distributions import TruncatedNormal, generator
from study.analyses.mechanisms.compute import Params
from study.analyses.mechanisms.impulse_regions import regions
from study.analyses.mechanisms.loss import rigid_loss
from study.analyses.mechanisms.slope import pair_rows
from study.analyses.mechanisms.spin import rolling_limit
from study.analyses.mechanisms.spore import off_centre
from study.declared.parameters import build
from study.samples import Dropped, Sample, Sampling, contact_of, difference_columns, half_width


@pytest.fixture(scope="module")
def tables(made):
    return made("mechanisms")


def test_spin_needed_is_the_speed_along_the_surface(tables):
    table = tables["spin_needed"]
    along = np.cos(np.radians(table["angle_deg"]))
    np.testing.assert_allclose(table["mean_spin_needed"], along, atol=0.04)
    np.testing.assert_allclose(
        table["rotational_over_translational_energy"], 0.4 * table["mean_spin_needed"] ** 2
    )


@pytest.fixture(scope="module")
def params(settings):
    return build(Params, settings.branches["mechanisms"])


@pytest.fixture(scope="module")
def inputs(settings, calibration):
    return {**calibration, "materials": pd.DataFrame(settings.tables.materials.rows)}


def test_spin_or_tilt_at_normal_incidence(tables, params, inputs):
    """An impulse ratio of 0.01 by closed forms: (7/2) (1 + e) mu, and its tilt."""
    row = tables["spin_or_tilt"].iloc[0]
    sphere = contact_of(replace(params.spin.dropped, case=row["case"]), inputs)
    e = float(simulate(sphere, params.spin.bias_speed_m_per_s).coefficient_of_restitution)
    assert row["spin_over_speed"] == pytest.approx(3.5 * (1.0 + e) * 0.01, rel=1e-3)
    tilt = np.degrees(0.01 / (1.0 - 2.0 / 7.0 / (1.0 + e)))
    assert row["tilt_deg"] == pytest.approx(tilt, rel=1e-2)


def test_slopes_raise_the_impulse_ratio_at_steep_angles_as_the_rigid_body_says(params, inputs):
    """There the difference is far below what few impacts tell: it needs samples of its own."""
    sampling = Sampling(
        seed=1, impacts=40_000, events=40, angle_error_deg=0.25, dispenser=params.dispenser
    )
    name, pair = next(iter(params.slope.pairs.items()))
    steep = replace(params.slope, pairs={name: pair}, angles_deg=(85.0, 75.0, 65.0))
    table = pd.DataFrame(pair_rows(steep, sampling, inputs))
    error = table["impulse_ratio_sd"] / np.sqrt(table["rebounds"])
    found = table["impulse_ratio_difference"]
    expected = [
        rigid_rise(angle, pair.rough.slope_sd, e, pair.rough.friction)
        for angle, e in table[["angle_deg", "restitution"]].to_numpy()
    ]
    assert ((found - expected).abs() < 4.0 * error).all()
    assert (found[table["angle_deg"] < 80.0] > 4.0 * error[table["angle_deg"] < 80.0]).all()


def rigid_rise(angle_deg, slope_sd, e, friction, n=400_000):
    """Rise of -mu over that of a smooth plane, facets taken by their area as seen (rejection)."""
    rng, alpha = np.random.default_rng(7), np.radians(angle_deg)
    x, y = slope_sd * rng.standard_normal((2, n))
    seen = np.tan(alpha) + x
    taken = rng.random(n) * (np.tan(alpha) + 6.0 * slope_sd) < seen
    normal = np.stack([-x, -y, np.ones(n)], axis=1)[taken]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    before = np.tile([np.cos(alpha), 0.0, -np.sin(alpha)], (len(normal), 1))
    each = np.full(len(normal), e), np.full(len(normal), friction)
    after, _ = facet_rebound(before, np.zeros_like(before), normal, *each)
    change = after - before
    smooth = min(friction, 2 / 7 / (1 + e) / np.tan(alpha))
    return float(np.mean(-change[:, 0] / change[:, 2]) - smooth)


def test_energy_loss_rises_towards_shallow_angles_only_where_spheres_roll(tables):
    table = tables["loss_slopes"]
    exceptions = table[table["share_falling"] < 1.0]
    assert not exceptions.empty
    # Rolling, T_L = (1 - e^2) sin^2 + (24/49) cos^2 rises if e > 5/7.
    assert (exceptions["restitution"] > 5 / 7).all()
    assert (exceptions["friction"] >= 0.2).all()
    assert table["share_falling"].mean() > 0.9


def test_spores_lose_more_where_their_restitution_is_lower(tables):
    """Both slide at 40 deg: T_L = 1 - e^2 sin^2 - (cos - f (1 + e) sin)^2, f = 0.15."""
    row, alpha = tables["loss_resolution"].iloc[0], np.radians(40.0)
    e = np.array([0.70, 0.55])  # Steel, then spores
    along = np.cos(alpha) - 0.15 * (1.0 + e) * np.sin(alpha)
    loss = 1.0 - (e * np.sin(alpha)) ** 2 - along**2
    assert row["difference_of_losses"] == pytest.approx(loss[1] - loss[0], rel=1e-9)
    assert row["difference_of_restitutions"] == pytest.approx(0.15)


SAMPLING = Sampling(seed=5, impacts=800, events=40, angle_error_deg=0.25, dispenser=STILL)
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


def on(contact):
    return Sample(dropped=STEEL, contact=contact, sampling=SAMPLING)


@pytest.mark.parametrize("angle", [85.0, 60.0, 30.0])
def test_a_sample_without_spreads_is_the_single_impact(contact, angle):
    one = on(contact).seen(angle)
    sphere = simulate(contact, 1.66, angle)
    e, mu, loss = (one.means[q] for q in ("restitution", "impulse_ratio", "energy_loss"))
    assert e.value == pytest.approx(float(sphere.coefficient_of_restitution), abs=1e-4)
    assert mu.value == pytest.approx(float(sphere.impulse_ratio), abs=1e-4)
    assert loss.value == pytest.approx(float(sphere.translational_energy_loss), abs=1e-4)
    assert one.captured_share == 0.0
    # A tilt turns part of the tangential speed into normal speed: de = (1 + e) cot(alpha) dalpha
    # where the tangential speed hardly changes.
    if angle == 30.0:
        rebound = float(sphere.tangential_velocity) / (1.66 * np.sin(np.radians(angle)))
        cot = 1.0 / np.tan(np.radians(angle))
        slope = rebound + e.value * cot
        assert e.systematic == pytest.approx(slope * np.radians(0.25), rel=0.02)


def test_slopes_lower_restitution_at_steep_angles_and_raise_it_at_shallow_ones(contact):
    smooth = on(contact)
    rough = smooth.with_changes(surface_slope=0.1)
    steep, shallow = (
        difference_columns(rough.seen(a), smooth.seen(a), SAMPLING) for a in (85.0, 15.0)
    )
    e = float(simulate(contact, 1.66, 85.0).coefficient_of_restitution)
    # Exact at normal incidence: e - (e + 5/7) phi^2, over both axes of slopes.
    assert steep["restitution_difference"] == pytest.approx(-2 * (e + 5 / 7) * 0.01, rel=0.15)
    assert shallow["restitution_difference"] > 0.2
    assert shallow["impulse_ratio_difference"] > 0.0


def test_half_width_of_a_difference():
    one = replace(EXACT, value=0.7, sd=0.04)
    other = replace(EXACT, value=0.6, sd=0.03, systematic=0.004)
    expected = 1.9908 * np.sqrt((0.04**2 + 0.03**2) / 40 + 0.004**2)
    assert half_width(one, other, SAMPLING) == pytest.approx(expected, rel=1e-4)


def test_bodies_without_offset_are_spheres(contact):
    body = off_centre(on(contact), 40.0, 0.0)
    sphere = on(contact).seen(40.0)
    for name, of in sphere.means.items():
        assert body.means[name].value == pytest.approx(of.value, abs=1e-9), name


def test_limit_of_rolling(contact):
    e = float(simulate(contact, 1.66, 48.0).coefficient_of_restitution)
    found = rolling_limit(contact, 1.66, 0.0)
    # cot(alpha) = (7/2) f (1 + e); adhesion adds to the compressive impulse that supports friction.
    closed = np.degrees(np.arctan(1.0 / (3.5 * 0.15 * (1.0 + e))))
    assert found == pytest.approx(closed, abs=1.0)
    assert rolling_limit(contact, 1.66, -0.3) > found + 5.0


def test_slopes_let_capture_appear_at_a_lower_normal_speed_at_shallow_angles(contact):
    """Said below Fig. 8: without slopes capture knows the normal speed alone."""
    spheres, limit = 500, float(capture_velocity(contact))

    def captured(slope_sd, angle):
        """Return the share captured at 0.9 of the normal speed of capture."""
        into, along = velocity_components(0.9 * limit / np.sin(np.radians(angle)), angle)
        velocity = np.tile([along, 0.0, into], (spheres, 1))
        target = Target(contact=contact, surface=rough(slope_sd))
        diameter = np.full(spheres, contact.diameter)
        return target.hit(diameter, velocity, 0.0 * velocity, generator(98)).captured.mean()

    assert captured(0.0, 90.0) == captured(0.0, 10.0) == 1.0
    assert captured(0.1, 90.0) > 0.9
    assert captured(0.1, 10.0) < 0.5


def test_no_spin_both_narrows_the_rolling_region_and_ends_friction(contact):
    """Said below Fig. 9."""
    slow, spins = 0.45, np.linspace(-1.0, 1.0, 41)
    wide = rolling_limit(contact, 1.6, 0.0)
    narrower = np.array([rolling_limit(contact, slow, spin) for spin in spins]) >= wide + 5.0
    impact = simulate(contact, slow, 45.0, spins * slow / contact.radius)
    frictionless = impact.impulse_ratio <= 0.0
    assert narrower.any()
    assert frictionless.any()
    assert not (narrower & frictionless).any()


def test_regions_of_an_ideal_curve():
    angle = np.arange(87.0, 5.0, -2.0)
    x = 1.0 / np.tan(np.radians(angle))
    ratio = np.interp(x, [0.0, 0.7, 1.4, 4.0, 11.0], [0.0, 0.12, 0.15, 0.15, 0.24])
    rows = regions(angle, ratio, np.full(angle.size, 1e-3), 0.1)
    assert [row["region"] for row in rows] == ["rolling", "transition", "sliding", "departure"]
    # Without a rise there is no fourth one, and noise makes none.
    noise = 1e-3 * generator(1).standard_normal(angle.size)
    plain = regions(angle, np.minimum(ratio, 0.15) + noise, np.full(angle.size, 1e-3), 0.1)
    assert "departure" not in {row["region"] for row in plain}


def test_loss_of_a_rolling_sphere():
    # (1 - e^2) sin^2 + (24/49) cos^2
    angle, e = np.array([80.0, 70.0]), 0.8
    sine = np.sin(np.radians(angle)) ** 2
    expected = (1 - e**2) * sine + 24 / 49 * (1 - sine)
    np.testing.assert_allclose(rigid_loss(e, 0.5, angle), expected, rtol=1e-12)
