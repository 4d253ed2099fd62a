"""Contacts of declared pairs: which number of a pair gives way to which change."""

from __future__ import annotations

import pytest

from microimpact.model.pairs import pair_contact, pairs_from_rows

ZETAS = [
    {"property": "zeta_hertz", "value": "0.3", "unit": "-"},
    {"property": "zeta_adhesion", "value": "70", "unit": "-"},
    {"property": "work_of_adhesion", "value": "500", "unit": "mJ/m2"},
    {"property": "diameter", "value": "62", "unit": "um"},
    {"property": "reference_velocity", "value": "1.66", "unit": "m/s"},
]


def built(steel, silicon, rows=ZETAS, **changes):
    pair = {"particle": "steel", "surface": "silicon"}
    materials = {"steel": steel, "silicon": silicon}
    return pair_contact(
        *pair.values(), materials, pairs_from_rows(pair | r for r in rows), **changes
    )


def test_the_declared_numbers_are_those_of_the_contact(steel, silicon):
    contact = built(steel, silicon)
    assert (contact.particle, contact.surface) == (steel, silicon)
    assert contact.diameter == pytest.approx(62e-6)
    assert contact.work_of_adhesion == pytest.approx(0.5)
    zetas = (
        contact.hertz_damping / contact.damping_unit,
        (contact.adhesion_damping / contact.damping_unit),
    )
    assert zetas == pytest.approx((0.3, 70.0), rel=1e-12)


def test_a_change_takes_the_place_of_the_same_quantity_alone(steel, silicon):
    contact = built(steel, silicon, zeta_hertz=0.6, ring_force=9.0)
    assert contact.hertz_damping == pytest.approx(0.6 * contact.damping_unit)
    assert contact.adhesion_damping == pytest.approx(70.0 * contact.damping_unit)
    assert contact.adhesion_input == "ring_force"
    damped = built(steel, silicon, hertz_damping=0.2, adhesion_damping=3.0)
    assert (damped.hertz_damping, damped.adhesion_damping) == (0.2, 3.0)
    with pytest.raises(ValueError, match="both zetas or both dampings"):
        built(steel, silicon, hertz_damping=0.2)


@pytest.mark.parametrize(
    ("left_out", "missing"), [(0, "hertz_damping"), (1, "adhesion_damping"), (3, "diameter")]
)
def test_what_is_missing_is_named(steel, silicon, left_out, missing):
    rows = ZETAS[:left_out] + ZETAS[left_out + 1 :]
    with pytest.raises(ValueError, match=f"is incomplete; give {missing}$"):
        built(steel, silicon, rows)
