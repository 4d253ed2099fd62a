"""Calibration: steel on silicon as a family, fluorescein on molybdenum as an interval."""

from __future__ import annotations

import pytest

from microimpact.model.dynamics.normal import normal_impact
from study.contacts import calibrated_contact
from study.tables import parse_table


@pytest.fixture(scope="module")
def tables(made):
    return made("calibration")


@pytest.fixture(scope="module")
def members(tables):
    return tables["calibration_family"]


def test_every_target_is_met(tables):
    rows = tables["calibration"].query("role == 'target'")
    fitted = rows[rows["quantity"] != "adhesion_over_hertz"]
    band = fitted["case"].str.contains("least|greatest")
    assert fitted[~band]["value"].to_numpy() == pytest.approx(
        fitted[~band]["target"].to_numpy(), abs=1e-7
    )
    # the ends of the molybdenum band: 10 % off the printed ratio
    ends = fitted[band]["value"].to_numpy() / fitted[band]["target"].to_numpy()
    assert sorted(ends) == pytest.approx([0.9, 1.1], rel=1e-6)


def test_a_small_work_of_adhesion_has_no_solution_and_says_why(members):
    weak = members.query("rate_exponent == 0 and work_of_adhesion_J_per_m2 <= 0.5")
    assert not weak["solved"].any()
    assert weak["reason"].str.contains("adhesion damping alone").all()


def test_each_exponent_has_a_member_that_is_flat(members):
    flat = members[members["plateau_of_e_holds"] == True]  # noqa: E712
    assert set(flat["rate_exponent"]) == {0.0, 0.5, 1.0}


def test_molybdenum_interval(tables):
    table = tables["molybdenum_capture"].set_index("diameter_um")
    assert table.index.tolist() == [2.58, 3.44, 4.9, 6.89]
    assert (table["low_m_per_s"] < table["capture_velocity_m_per_s"]).all()
    assert (table["capture_velocity_m_per_s"] < table["high_m_per_s"]).all()
    # nominal from c_H = 0 and a dissipation ratio of 1/5
    assert table.loc[4.9, "capture_velocity_m_per_s"] == pytest.approx(1.274, abs=2e-3)
    assert table["printed_inside"].tolist() == [False, False, True, False]


def test_a_target_that_is_not_printed_is_marked_as_assumed(run_study, tables):
    def evidence(made):
        marks = made["ridge_curves"].query("series == 'targets'")
        return dict(zip(marks["x_m_per_s"], marks["evidence"], strict=True))

    # Of normal impact no restitution is printed.
    assert evidence(tables) == {0.18: "printed", 1.66: "assumed"}
    few = {"rate_exponents": [1.0], "works_of_adhesion_J_per_m2": [0.7]}
    case = "steel-silicon, n = 1"
    changed = {**few, "capture_velocity_m_per_s": 0.15, "members": {case: {}}}
    found = evidence(run_study("calibration", two_stage=changed))
    assert found == {0.15: "assumed", 1.66: "assumed"}


FEW = {"rate_exponents": [1.0], "works_of_adhesion_J_per_m2": [0.7]}


def test_damping_fitted_at_another_work_of_adhesion_stays(run_study, tables):
    case = "steel-silicon, n = 1"
    humid = {"work_of_adhesion_J_per_m2": 1.4, "damping_fitted_at_J_per_m2": 0.7}
    made = run_study("calibration", two_stage={**FEW, "members": {case: humid}})
    dry, wet = (
        each["calibration"].set_index(["case", "quantity"])["value"][case]
        for each in (tables, made)
    )
    assert wet["work_of_adhesion"] == 2 * dry["work_of_adhesion"]
    damping = ["hertz_damping", "adhesion_damping"]
    assert wet[damping].tolist() == pytest.approx(dry[damping].tolist(), rel=1e-9)
    assert wet["capture_velocity"] > 1.5 * dry["capture_velocity"]


@pytest.mark.parametrize("law", ["jkr", "thornton-ning"])
def test_another_law_meets_the_same_targets(run_study, settings, law):
    case = "steel-silicon, n = 1"
    made = run_study("calibration", two_stage={**FEW, "members": {case: {"law": law}}})
    rows = made["calibration"].query("case == @case and role == 'target'")
    assert rows["value"].tolist() == pytest.approx(rows["target"].tolist(), rel=1e-9)
    materials = parse_table(settings.rows["fig18_21_oblique_impact"]["materials"])
    contact = calibrated_contact({**made, "materials": materials}, case)
    assert contact.law.name == law
    impact = normal_impact(contact, 1.66)
    assert impact.coefficient_of_restitution == pytest.approx(0.70, rel=1e-9)


def test_a_law_has_its_own_work_of_adhesion(run_study):
    both = {"law": "jkr", "damping_fitted_at_J_per_m2": 0.7}
    with pytest.raises(ValueError, match="leave damping_fitted_at_J_per_m2"):
        run_study("calibration", two_stage={"members": {"steel-silicon, n = 1": both}})
