"""Contacts by several laws: similarity is exact, and the truth at other sizes is inside."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.model import law_draws
from microimpact.model.contact import resized
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical import shapes
from microimpact.model.empirical.comparison import LEAST, sorted_data
from microimpact.model.law_draws import LAWS, _contacts, _drawn, calibrate_laws

SIZES = np.array([1.0 / 3.0, 0.5, 1.0, 2.0])


@pytest.mark.parametrize("law", LAWS)
def test_contacts_have_the_shape_and_the_capture_velocity_drawn(contact, law):
    last = np.array(shapes.table(law).shape[:3]) - 1.0
    places = last * np.random.default_rng(1).uniform(0.2, 0.7, (5, 3))
    limit, ratio = np.array([0.02, 0.1, 0.3, 1.0, 4.0]), np.array([[1.3], [5.0]])
    drawn = _contacts(law, contact, np.column_stack([places, limit]), 1.0)
    assert capture_velocity(drawn) == pytest.approx(limit, rel=1e-9)
    e = simulate(drawn, limit * ratio).coefficient_of_restitution
    tabled = [shapes.restitution(law, place, ratio[:, 0]) for place in places]
    assert pytest.approx(np.array(tabled), abs=2e-3) == e.T
    single = drawn.at(2)
    assert single.shape == ()
    assert capture_velocity(single) == pytest.approx(limit[2])


def rebounds(contact, seed, size_scatter=0.0):
    """Twenty-five rebounds from 1.05 v_c upwards, noise 0.015."""
    rng, limit = np.random.default_rng(seed), float(capture_velocity(contact))
    v = limit * np.exp(rng.uniform(np.log(1.05), np.log(15.0), 60))
    d = contact.diameter * np.exp(size_scatter * rng.standard_normal(60))
    e = simulate(contact.replace(diameter=d), v).coefficient_of_restitution
    kept = np.flatnonzero(e > 0.0)[:25]
    return v[kept], np.clip(e[kept] + rng.normal(0.0, 0.015, 25), 1e-3, 1.0)


@pytest.mark.parametrize("size_scatter", [None, 0.05])
def test_predictions_at_other_sizes_hold_the_truth_of_another_law(contact, size_scatter):
    """As often as 90 % say: of 8 hardly less than 5. The ring force alone would miss."""
    viscous = contact.by_law(JKR(viscous_time=3e-9), 0.2)
    held = []
    for seed in range(2):
        v, e = rebounds(viscous, seed, size_scatter or 0.0)
        drawn = calibrate_laws(viscous, v, e, 0.015, size_scatter=size_scatter, draws=100)
        assert sum(each.shape[0] for each in drawn.contacts.values()) == 100
        for model in drawn.comparison.models:
            share = drawn.contacts[model.name].shape[0] if model.name in drawn.contacts else 0
            assert abs(share - 100 * model.weight) < 1.0
        for size in SIZES * viscous.diameter:
            limits = drawn.of_all(lambda c, size=size: capture_velocity(resized(c, size)))
            low, high = np.quantile(limits, [0.05, 0.95])
            held.append(low <= capture_velocity(resized(viscous, size)) <= high)
    assert np.sum(held) >= 5


def test_a_law_that_does_not_fit_is_told_and_sigma_widened(contact, monkeypatch):
    widened = []
    monkeypatch.setattr(law_draws, "_drawn", lambda *a: widened.append(a[2]) or _drawn(*a))
    v, e = rebounds(contact, 3)
    e = e - 0.1 * np.sin(8.0 * np.log(v / v.min()))
    drawn = calibrate_laws(contact, v, np.clip(e, 0.01, 1.0), 0.005, draws=50)
    assert drawn.misfit.probability < 1e-6
    assert set(widened) == {drawn.comparison.scatter}
    assert drawn.comparison.scatter > 3.0
    assert drawn.misfit.freedom == 25 - drawn.comparison.models[0].free
    assert "does not fit: reduced chi-square" in drawn.warnings[0]


def test_data_without_information_leave_uniform_logarithms_of_v_c(contact):
    v, e = rebounds(contact, 3)
    data = sorted_data(v, e, 1.0)
    points, _ = _drawn("viscous JKR", data, 1e9, 400, 0)
    low, high = np.log(LEAST), np.log(data.reach[0])
    places = (np.log(points[:, -1] / data.unit[0]) - low) / (high - low)
    assert np.quantile(places, [0.1, 0.5, 0.9]) == pytest.approx([0.1, 0.5, 0.9], abs=0.1)


def test_what_has_no_laws_is_refused(contact):
    v, e = rebounds(contact, 3)
    with pytest.raises(ValueError, match="at least 5 points"):
        calibrate_laws(contact, v[:4], e[:4], 0.015)
    with pytest.raises(ValueError, match="without damped_attachment"):
        calibrate_laws(contact.replace(damped_attachment=True), v, e, 0.015)
    with pytest.raises(TypeError, match="draws must be a whole number"):
        calibrate_laws(contact, v, e, 0.015, draws=10.5)
