"""Units of the declared tables."""

import pytest

from microimpact.core import materials
from microimpact.core.materials import quantity


def row(unit):
    return {"property": "size", "value": "2", "unit": unit}


@pytest.mark.parametrize(
    ("unit", "kind", "factor"),
    [
        ("GPa", materials.PRESSURE, 1e9),
        ("g/cm3", materials.DENSITY, 1e3),
        ("um", materials.LENGTH, 1e-6),
        ("mJ/m2", materials.ENERGY_PER_AREA, 1e-3),
        ("-", materials.NUMBER, 1.0),
    ],
)
def test_units_have_their_si_factor(unit, kind, factor):
    assert quantity(row(unit), {"size": kind}, "somewhere") == 2.0 * factor


def test_a_unit_of_another_kind_is_an_error_that_lists_the_right_ones():
    with pytest.raises(ValueError, match="row 3, size: unit 'kg' must be one of m, mm, um, nm"):
        quantity(row("kg"), {"size": materials.LENGTH}, "row 3")
