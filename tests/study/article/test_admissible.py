"""The contacts that the printed statements admit: drawn well, and what they say of the article."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.model.contact import resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from study.studies.contacts import admissible_contact
from study.tables import parse_table

STEEL, FLUORESCEIN = "steel-silicon", "fluorescein-molybdenum"
WITH, WITHOUT = "with the printed v_c", "without the printed v_c"


@pytest.fixture(scope="module")
def tables(made):
    return made("admissible_contacts")


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


def test_the_contacts_of_the_table_are_those_drawn(draws, tables):
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


def test_without_the_printed_capture_velocity_the_facts_ask_for_half_of_it(draws):
    v_c = draws.loc[(STEEL, WITHOUT), "v_c_derived_m_per_s"]
    assert 0.06 < v_c.median() < 0.12
    assert np.mean(v_c < 0.17) > 0.9
    stated = draws.loc[(STEEL, WITH), "v_c_m_per_s"]
    assert np.mean(np.abs(stated - 0.18) < 0.03) > 0.9


def test_most_of_the_loss_is_not_adhesion(draws):
    for variant in (WITH, WITHOUT):
        share = draws.loc[(STEEL, variant), "adhesion_share"]
        assert 0.2 < share.median() < 0.5
    # adhesion takes the more, the less the material does
    rows = draws.loc[STEEL]
    assert rows["adhesion_share"].corr(rows["hertz_damping_s_per_m"], method="spearman") < -0.5


def test_the_rate_exponent_is_near_one(draws):
    n = draws.loc[(STEEL, WITHOUT), "rate_exponent"]
    assert n.median() > 0.75
    assert n.quantile(0.05) > 0.4


def test_friction_on_the_hertz_term_is_ruled_out(draws):
    assert np.mean(draws.loc[STEEL, "friction_basis"] == "hertz") < 0.02


def test_statements_that_a_printed_capture_velocity_contradicts(tables):
    table = tables["admissible_statements"].set_index(["case", "variant", "statement"])
    steel = table.loc[STEEL]
    # half of the slow spheres and more would have stayed, and the ratio would not have risen
    assert steel.loc[(WITH, "no capture seen"), "median"] > 0.5
    assert steel.loc[(WITHOUT, "no capture seen"), "median"] < 0.1
    assert steel.loc[(WITH, "rise of the impulse ratio"), "share_inside"] < 0.5
    assert not steel.loc[(WITHOUT, "printed capture velocity"), "stated"]
    # both agree with what is printed of restitution
    rows = table[table["quantity"] == "restitution"]
    assert (rows["log_likelihood"] > -1.0).all()


def test_what_a_statement_decides_is_told(tables):
    table = tables["admissible_statements"].set_index(["case", "variant", "statement"])
    steel = table.loc[STEEL]
    middle = steel["v_c_left_out_median_m_per_s"]
    # one that is left out already changes nothing, the printed one leads to the other variant
    same = middle.loc[(WITHOUT, "printed capture velocity")]
    assert middle.loc[(WITH, "printed capture velocity")] == pytest.approx(same)
    assert middle.loc[(WITHOUT, "no capture seen")] > same
    assert (steel["effective_size_left_out"] > 10).all()


def test_two_stage_estimates_stand_beside_the_draws(summary, calibration):
    rows = summary.xs("two-stage, steel-silicon, n = 1", level="estimate").loc[STEEL, "median"]
    assert rows["v_c_at_62_um_m_per_s"] == pytest.approx(0.18, rel=1e-6)
    assert rows["restitution"] == pytest.approx(0.70, rel=1e-6)
    assert rows["work_of_adhesion_J_per_m2"] == pytest.approx(0.7)
    low, high = summary.loc[(STEEL, WITH, "v_c_at_62_um_m_per_s"), ["low", "high"]]
    assert low < 0.18 < high


def test_a_captured_share_becomes_a_likelihood_over_what_is_noticed():
    from microimpact.statistics.distributions import Constant
    from study.studies.models.admissible_contacts.statements import NoCapture

    one = NoCapture(
        diameter_um=Constant(at=50.0),
        speed_range_m_per_s=(0.4, 0.5),
        angle_deg=30.0,
        spheres=40,
    )
    q = (np.arange(20000) + 0.5) / 20000
    share = np.array([0.0, 0.01, 0.3, 1.0])
    by_hand = [np.log(np.mean((1.0 - q * p) ** 40)) for p in share]
    assert one.log_likelihood(share) == pytest.approx(by_hand, abs=1e-3)
    # normal speeds from 0.2 to 0.25 m/s: half are below 0.225
    limits = {40.0: np.array([0.225, 0.1, 0.3]), 60.0: np.array([0.225, 0.1, 0.3])}
    assert one.captured(limits).tolist() == [0.5, 0.0, 1.0]


def test_an_interval_with_normal_tails():
    from study.studies.models.admissible_contacts.statements import Within

    one = Within(quantity="restitution", interval=(0.6, 0.7), tail=0.1)
    values = np.array([0.5, 0.6, 0.65, 0.9, np.nan, np.inf])
    logs = one.log_likelihood(values)
    assert logs[:4] == pytest.approx([-0.5, 0.0, 0.0, -2.0])
    assert (logs[4:] < -1e5).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"cases": {STEEL: {"ranges": {"friction": [0.2, 0.1]}}}},
            r"friction: .* must ascend",
        ),
        (
            {"cases": {STEEL: {"statements": {"piles": {"interval": [0.3, 0.2]}}}}},
            r"interval: \[0.3, 0.2\] must ascend",
        ),
        ({"cases": {STEEL: {"statements": {"piles": {"diameter_um": 50.0}}}}}, "one of classes_um"),
        ({"cases": {STEEL: {"statements": {"piles": {"quantity": "restituton"}}}}}, "quantity"),
    ],
)
def test_bad_declarations_are_refused(run_study, calibration, changes, message):
    with pytest.raises(ValueError, match=message):
        run_study("admissible_contacts", calibration, **changes)
