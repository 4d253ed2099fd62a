"""Printed values appear beside just the impact that they are printed of."""

from __future__ import annotations

import pandas as pd
import pytest
from tests.shared import shipped

from study.contacts import intervals, printed_values_for
from study.declared.references import merged
from study.run.config import validate

STEEL = "stainless-steel-316", "silicon"


@pytest.fixture(scope="module")
def inputs(settings):
    table = settings.tables.printed_values
    return {"printed": pd.DataFrame(list(table.rows)).replace("", None)}


@pytest.mark.parametrize(
    ("pair", "impact", "appears"),
    [
        (STEEL, {"diameter_um": 49.1, "speed_m_per_s": 1.64, "angle_deg": 25.0}, True),
        (STEEL, {"diameter_um": 49.1, "speed_m_per_s": 1.64}, True),
        (STEEL, {}, True),
        (("stainless-steel-316", "glass"), {}, False),
        (("glass", "silicon"), {}, False),
        (STEEL, {"diameter_um": 62.0}, False),
        (STEEL, {"speed_m_per_s": 1.05}, False),
        (STEEL, {"angle_deg": 85.0}, False),
    ],
)
def test_a_value_appears_beside_its_pair_size_speed_and_angle(inputs, pair, impact, appears):
    keys = printed_values_for(inputs, *pair, **impact).index
    assert ("restitution_sst65_silicon_25deg" in keys) == appears


def test_a_general_value_appears_beside_every_impact(inputs):
    keys = printed_values_for(inputs, "lycopodium", "mica", diameter_um=1.0, angle_deg=5.0).index
    assert "doe_small_variation" in keys


def test_no_restitution_of_steel_is_printed_for_normal_impact(inputs):
    printed = printed_values_for(inputs, *STEEL, angle_deg=90.0)
    assert not printed.index.str.startswith("restitution").any()


def test_a_cell_holds_numbers_and_ranges():
    assert intervals("49; 62") == [(49.0,), (62.0,)]
    assert intervals("85 to 15") == [(85.0, 15.0)]
    assert intervals(None) == []


def test_faster_drops_move_no_printed_target(settings):
    faster = {"speed_m_per_s": 3.0, "speed_range_m_per_s": [2.9, 3.1]}
    changed = validate(merged(shipped(), {"speeds": {"nominal": faster}}), shipped())
    assert (
        changed.branches["fig18_21_oblique_impact"] != settings.branches["fig18_21_oblique_impact"]
    )
    assert changed.branches["calibration"] == settings.branches["calibration"]
