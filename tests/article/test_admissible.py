"""The contacts that the printed statements admit: drawn well, and what they say of the article."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tests.shared import made_once

from microimpact.core.tables import parse_table
from microimpact.lab.contacts import admissible_contact
from microimpact.model.contact import resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate

STEEL, FLUORESCEIN = "steel-silicon", "fluorescein-molybdenum"
WITH, WITHOUT = "with the printed v_c", "without the printed v_c"
# Smaller than as shipped, for speed; large enough for what is asserted.
SAMPLER = {"spread": 13, "walkers": 96, "steps": 120, "pool": 1000}


@pytest.fixture(scope="module")
def tables(run_study, calibration, tmp_path_factory):
    def write(place):
        made = run_study("admissible_contacts", calibration, sampler=SAMPLER, draws=200)
        place.write_text(json.dumps({k: t.to_csv(index=False) for k, t in made.items()}))

    made = json.loads(made_once(tmp_path_factory, "admissible", write).read_text())
    return {name: parse_table(text) for name, text in made.items()}


@pytest.fixture(scope="module")
def draws(tables):
    return tables["admissible_contacts"].set_index(["case", "variant"])


@pytest.fixture
def summary(tables):
    return tables["admissible_summary"].set_index(["case", "estimate", "quantity"])


def test_every_case_and_variant_has_its_draws(draws):
    assert set(draws.index) == {(c, v) for c in (STEEL, FLUORESCEIN) for v in (WITH, WITHOUT)}
    assert (draws.groupby(level=[0, 1]).size() == 200).all()
    assert (draws.groupby(level=[0, 1])["most_central"].sum() == 1).all()
    assert np.isfinite(draws.select_dtypes("number")).all(axis=None)


def test_the_chains_have_come_together(tables):
    table = tables["admissible_diagnostics"]
    assert (table["split_r_hat"] < 1.05).all()
    assert (table["effective_size"] > 100).all()
    assert (table["effective_size_weighted"] > 150).all()
    assert (table["different_draws"] > 150).all()


def test_the_contacts_of_the_table_are_those_drawn(draws, tables, run_study):
    inputs = {"admissible_contacts": tables["admissible_contacts"], "materials": materials()}
    for case, variant in set(draws.index):
        rows = draws.loc[(case, variant)]
        contact = admissible_contact(inputs, case, variant)
        assert capture_velocity(contact) == pytest.approx(rows["v_c_m_per_s"].to_numpy(), rel=1e-9)
        size, speed = rows["derived_at_um"].iloc[0] * 1e-6, rows["derived_at_m_per_s"].iloc[0]
        e = simulate(resized(contact, size), speed).coefficient_of_restitution
        assert e == pytest.approx(rows["restitution"].to_numpy(), rel=1e-9)


def materials():
    from microimpact.core.materials import declared_file

    return parse_table(declared_file("materials.csv").read_text())
