"""The explorer's tables: coordinates, interpolation, and the errors that the study states."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

from microimpact.core.materials import Material
from microimpact.core.tables import parse_table
from microimpact.declared.parameters import build
from microimpact.declared.selection import read_all
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.run.config import load, validate
from microimpact.studies.models import explorer_tables as study
from microimpact.studies.models.explorer_tables.accuracy import Tables
from microimpact.studies.models.explorer_tables.coordinates import (
    SLOW_PASSAGE,
    adhesion_strength,
    chebyshev_nodes,
    closeness,
    impulse_closeness,
    impulse_strength_at,
    interpolate,
    node_weights,
    strength_at,
)

scaled = import_module("microimpact.studies.models.explorer_tables.impacts")
ROOT = Path(__file__).parents[2]
CASE = {
    "particle": "stainless-steel-316",
    "surface": "silicon",
    "diameter": 62e-6,
    "work_of_adhesion": 0.7,
    "hertz_damping": 0.2,
    "adhesion_damping": 1.6,
    "adhesion_rate_exponent": 1.0,
    "reference_velocity": 1.66,
}


@pytest.fixture(scope="module")
def branch():
    base = load(ROOT / "config/config.yaml")
    return validate(base, base).branches["explorer_tables"]


@pytest.fixture(scope="module")
def inputs():
    base = load(ROOT / "config/config.yaml")
    tables = validate(base, base).general.tables
    declared = read_all(*(str(ROOT / path) for path in tables)).contact_rows()
    numbers = {key: value for key, value in CASE.items() if key not in {"particle", "surface"}}
    rows = [
        {"case": "one", "particle": CASE["particle"], "surface": CASE["surface"]}
        | {"role": "parameter", "quantity": name, "value": value}
        for name, value in numbers.items()
    ]
    return {name: parse_table(text) for name, text in declared.items()} | {
        "calibration": pd.DataFrame(rows)
    }


@pytest.fixture(scope="module")
def tables(branch, inputs):
    return study.run(build(study.Params, branch), inputs)


def test_interpolation_is_exact_for_polynomials_up_to_one_degree_less_than_nodes():
    x, y = chebyshev_nodes(5), chebyshev_nodes(4)
    values = x[:, None] ** 4 - 2.0 * x[:, None] * y**3
    at = np.array([0.0, 0.3, x[2], 1.0]), np.array([1.0, 0.7, y[1], 0.0])
    found = interpolate(values, node_weights(x, at[0]), node_weights(y, at[1]))
    assert found == pytest.approx(at[0] ** 4 - 2.0 * at[0] * at[1] ** 3, abs=1e-14)
    fifth = interpolate(x**5, node_weights(x, at[0]))
    assert np.max(np.abs(fifth - at[0] ** 5)) > 1e-4


def test_slow_passage_is_the_shortfall_of_the_time_near_the_surface():
    # the integral of 2 s (1/sqrt(4/3 s^3) - 1/sqrt(q^2 + 4/3 s^3)) over all s, at q = 1; s = r^2
    def shortfall(r):
        s = r * r
        return (
            4.0 * r * s * (1.0 / np.sqrt(4.0 / 3.0 * s**3) - 1.0 / np.sqrt(1.0 + 4.0 / 3.0 * s**3))
        )

    found = quad(shortfall, 0.0, 3.0)[0] + quad(shortfall, 3.0, np.inf)[0]
    assert pytest.approx(found, rel=1e-7) == SLOW_PASSAGE


def test_axes_and_strength_are_inverse_to_each_other():
    critical = np.array([0.3, 1.0, 20.0])
    for axis in (0.05, 0.5, 1.0):
        at = np.full(3, axis)
        assert closeness(strength_at(at, critical), critical) == pytest.approx(at)
        strength = impulse_strength_at(at, critical)
        assert impulse_closeness(strength, critical) == pytest.approx(at)
    assert np.all(strength_at(np.zeros(3), critical) == critical)
    assert adhesion_strength(np.array([32.0])) == pytest.approx([1.0 / 16.0])


def test_scaled_outcomes_do_not_depend_on_the_contact(monkeypatch):
    damping, share, strength = np.array([0.5, 3.0]), np.array([0.2, 0.9]), np.array([0.1, 0.4])
    here = scaled.impacts(damping, share, strength)
    body = Material(name="other", youngs_modulus=3e9, poissons_ratio=0.4, density=1100.0)
    other = Contact(particle=body, surface=body, diameter=0.7e-6, ring_force=0.0)
    monkeypatch.setattr(scaled, "_CONTACT", other)
    there = scaled.impacts(damping, share, strength)
    for name in here.__dataclass_fields__:
        assert getattr(there, name) == pytest.approx(getattr(here, name), rel=1e-11)


def test_threshold_is_that_of_a_contact_with_a_constant_loss_of_adhesion():
    body = Material(name="any", youngs_modulus=1e11, poissons_ratio=0.3, density=3000.0)
    contact = Contact(
        particle=body,
        surface=body,
        diameter=1e-5,
        work_of_adhesion=0.3,
        adhesion_damping=0.8,
        adhesion_rate_exponent=1.0,
        reference_velocity=2.0,
    )
    w = scaled.scaled_thresholds(np.array([1.6]), np.array([0.0]))
    assert w * contact.velocity_scale == pytest.approx(capture_velocity(contact), rel=1e-11)


def test_errors_are_as_small_as_the_page_promises(tables):
    accuracy = tables["explorer_accuracy"]
    largest = accuracy.groupby("quantity")["largest"].max()
    assert largest["threshold_speed"] < 1e-10
    assert largest["coefficient_of_restitution"] < 2e-6
    assert largest["hertz_work"] < 1e-4
    for name in ("compressive_impulse", "hertz_impulse", "peak_net_impulse", "contact_time"):
        assert 0.0 < largest[name] < 1e-4, name
    assert largest["captured"] == 0


def test_a_wrong_table_shows_in_the_errors(tables, branch):
    broken = dict(tables)
    restitution = tables["explorer_restitution"].copy()
    restitution.loc[4000, "scaled_restitution"] *= 1.01
    broken["explorer_restitution"] = restitution
    params = build(study.Params, branch)
    found = study.accuracy(
        broken,
        largest_damping=params.largest_damping,
        near=params.near_threshold,
        points=2000,
        seed=params.seed,
    ).set_index(["quantity", "region"])["largest"]
    assert found["coefficient_of_restitution"].max() > 1e-3


def test_without_damping_nothing_is_lost_and_the_tables_still_hold(tables):
    outcome = Tables(16.0, tables)
    strength = np.array([0.02, 0.5, 3.0])
    damping = np.full(3, 1e-12)
    speed = strength ** (-1.25)
    found = outcome.impacts(damping, np.zeros(3), speed)
    exact = scaled.impacts(np.zeros(3), np.zeros(3), strength)
    assert found.restitution == pytest.approx(np.ones(3), abs=1e-6)
    assert found.compressive_impulse == pytest.approx(exact.compressive_impulse, rel=1e-4)
    assert found.contact_time == pytest.approx(exact.contact_time, rel=1e-4)


def test_nodes_too_close_to_the_threshold_are_refused(branch, inputs):
    small = {**branch, "threshold_nodes": [6, 6], "restitution_nodes": [6, 6, 6]}
    params = build(study.Params, {**small, "impulse_nodes": [6, 6, 60], "trial_points": 100})
    with pytest.raises(ValueError, match=r"impulse_nodes: with 60 nodes"):
        study.run(params, inputs)


def test_declared_pairs_and_calibrated_cases_are_carried_in_si(tables, inputs):
    contacts = tables["explorer_contacts"].set_index("contact")
    assert contacts.loc["one", "origin"] == "calibrated"
    for name in ("diameter", "work_of_adhesion", "hertz_damping", "adhesion_rate_exponent"):
        assert contacts.loc["one", name] == pytest.approx(CASE[name])
    declared = inputs["contacts"].drop_duplicates(["particle", "surface"])
    assert (contacts["origin"] == "declared").sum() == len(declared)
    materials = tables["explorer_materials"].set_index("material")
    assert materials.loc["stainless-steel-316", "youngs_modulus"] == pytest.approx(193e9)
