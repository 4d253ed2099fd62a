"""Claims say what of their inputs is not as shipped; of another impact they have no verdict."""

from __future__ import annotations

import pytest
from tests.shared import shipped

from study.declared.references import merged
from study.judge.changed import OF_ANOTHER, with_inputs
from study.run.changed import changed_inputs
from study.run.config import validate

FORCES = {"id": "C32", "inputs": "force_ratios printed"}
PAIRS = {"id": "C72", "inputs": "surface_pairs"}
PLATEAU = {"id": "C68", "inputs": "calibration steel.speed_m_per_s"}
STEEL, FLUORESCEIN = "steel-silicon, n = 1", "fluorescein-molybdenum, nominal"


@pytest.fixture
def marked(settings):
    def row(claim, overlay):
        used = validate(merged(shipped(), overlay), shipped())
        changed = changed_inputs(used, settings)
        return with_inputs({"verdict": "reproduced", "sentence": "", **claim}, changed)

    return row


@pytest.mark.parametrize(
    ("overlay", "key"),
    [
        ({"fig20_force_history": {"case": STEEL}}, "fig20_force_history.case"),
        ({"fig20_force_history": {"speed_m_per_s": 1.66}}, "fig20_force_history.speed_m_per_s"),
        (
            {"particles": {"fluorescein": {"mean_diameter_um": 3.0}}},
            "particles.fluorescein.mean_diameter_um",
        ),
    ],
)
def test_a_claim_computed_for_another_impact_has_no_verdict(marked, overlay, key):
    row = marked(FORCES, overlay)
    assert row["verdict"] == OF_ANOTHER
    assert key in row["sentence"]
    assert key in row["changed_inputs"]
    assert marked(PAIRS, overlay)["verdict"] == "reproduced"


def test_a_claim_on_the_shared_impact_has_no_verdict_at_another_speed(marked):
    overlay = {"speeds": {"nominal": {"speed_m_per_s": 3.0, "speed_range_m_per_s": [2.9, 3.1]}}}
    assert marked(PLATEAU, overlay)["verdict"] == OF_ANOTHER
    assert marked({"id": "C88", "inputs": "formica_mechanism"}, overlay)["verdict"] == OF_ANOTHER
    spores = {"speeds": {"spore": {"speed_m_per_s": 2.0, "speed_range_m_per_s": [1.9, 2.1]}}}
    assert marked({"id": "C84", "inputs": "spore_trends"}, spores)["verdict"] == OF_ANOTHER
    assert marked(PAIRS, spores)["verdict"] == "reproduced"
    of_size = PLATEAU | {"inputs": "calibration steel.diameter_um"}
    assert marked(of_size, overlay)["verdict"] == "reproduced"


@pytest.mark.parametrize(
    ("overlay", "key"),
    [
        ({"drops": {"steel on silicon": {"friction": 0.3}}}, "drops.steel on silicon.friction"),
        ({"cases": {"steel-silicon, n = 0": {"restitution": 0.8}}}, "cases.steel-silicon, n = 0"),
        ({"seed": 1}, "seed"),
    ],
)
def test_a_verdict_by_other_inputs_names_them(marked, overlay, key):
    row = marked(PAIRS, overlay)
    assert row["verdict"] == "reproduced"
    assert key in row["changed_inputs"]


def test_another_contact_of_the_pair_is_of_the_same_experiment(marked):
    row = marked({"id": "C10", "inputs": "pile_up"}, {"pile_up": {"case": "steel-silicon, n = 0"}})
    assert (row["verdict"], row["changed_inputs"]) == ("reproduced", "pile_up.case")


def test_a_claim_that_rests_on_no_change_bears_no_mark(marked):
    overlay = {"fig20_force_history": {"speed_m_per_s": 1.66}}
    for claim, changes in ((FORCES, {}), (PAIRS, overlay)):
        assert marked(claim, changes)["changed_inputs"] == ""
