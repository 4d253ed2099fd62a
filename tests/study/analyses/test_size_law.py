"""The size law: exponents by hand, and the design against simulated fits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import curve_fit

from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from study.analyses.size_law.compute import Params, error_of_one, exponents
from study.declared.parameters import build


@pytest.fixture
def params(settings):
    return build(Params, settings.branches["size_law"])


def test_jkr_alone_has_five_sixths(contact):
    elastic = contact.by_law(JKR(), 0.5)
    assert float(exponents(elastic, 40.0, 80.0)) == pytest.approx(-5 / 6, rel=1e-6)


def test_the_error_of_one_rebound_is_that_of_fits(params, contact):
    limit, rng = float(capture_velocity(contact)), np.random.default_rng(3)
    speed = np.geomspace(1.2, params.highest_speed_in_v_c, 60) * limit
    grid = np.geomspace(0.3, 40.0, 4000) * limit
    e_of = normal_impact(contact, grid).coefficient_of_restitution

    def shape(v, shift, level):
        return np.exp(level) * np.interp(v * np.exp(-shift), grid, e_of)

    found = []
    for _ in range(300):
        noise = params.noise_of_e * rng.standard_normal(speed.size)
        seen = shape(speed, 0.0, 0.0) + noise
        found.append(curve_fit(shape, speed, seen, p0=(0.0, 0.0))[0][0])
    one = error_of_one(params, contact, 1.2, exponent=0.0)
    assert np.std(found) == pytest.approx(one / np.sqrt(speed.size), rel=0.2)


def test_more_apart_needs_fewer_rebounds(run_study, made):
    design = run_study("size_law")["size_law_design"]
    first = design[design["laws"] == "ring force, n free against ring force, n = 0"]
    assert (np.diff(first[first["lowest_speed_in_v_c"] == 1.2]["rebounds_per_sieve"]) < 0).all()
    slow, fast = (first[first["lowest_speed_in_v_c"] == v]["rebounds_per_sieve"] for v in (1.2, 2))
    assert (slow.to_numpy() < fast.to_numpy()).all()
