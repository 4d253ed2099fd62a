"""Mechanisms each alone, and piles on the target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.shared import facet_rebound

from microimpact.model.dynamics.impact import simulate
from study.analyses.mechanisms.compute import Params
from study.analyses.mechanisms.slope import pair_rows
from study.declared.parameters import build
from study.samples import Sampling, contact_of


@pytest.fixture(scope="module")
def tables(made):
    return made("mechanisms")


@pytest.fixture(scope="module")
def piles(run_study, calibration, made):
    known = {**calibration, "evidence_summary": made("inference")["evidence_summary"]}
    return run_study("pile_up", known, spheres=300, speeds_m_per_s=[0.2, 0.3, 0.5, 0.8, 1.2, 2.0])


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


def test_a_pile_does_not_need_capture_in_one_impact(piles):
    onsets = piles["pile_up_onsets"]
    half = onsets[(onsets["share"] == 0.5) & (onsets["slope_deg"] == 2.0)].set_index("contact")
    printed, lower = (half.loc[[name], "onset_m_per_s"].to_numpy() for name in ("printed", "lower"))
    assert (printed > half.loc[["printed"], "first_impact_onset_m_per_s"] + 0.2).all()
    posterior = half.loc[["posterior"], "onset_m_per_s"].to_numpy()
    assert ((lower < posterior) & (posterior < printed)).all()
    # Larger targets keep more.
    assert (np.diff(printed) > 0.0).all()
    table = piles["pile_up"]
    assert (table["share_on_target"] >= table["share_captured_at_first_impact"]).all()
