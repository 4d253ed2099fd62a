"""Units of the declared tables."""

import pytest

from microimpact.core import units


@pytest.mark.parametrize(
    ("unit", "kind", "factor"),
    [
        ("GPa", units.PRESSURE, 1e9),
        ("g/cm3", units.DENSITY, 1e3),
        ("um", units.LENGTH, 1e-6),
        ("mJ/m2", units.ENERGY_PER_AREA, 1e-3),
        ("-", units.NUMBER, 1.0),
    ],
)
def test_units_have_their_si_factor(unit, kind, factor):
    assert units.si_factor(unit, kind, "somewhere") == factor


def test_a_unit_of_another_kind_is_an_error_that_lists_the_right_ones():
    with pytest.raises(ValueError, match="row 3: unit 'kg' must be one of m, mm, um, nm"):
        units.si_factor("kg", units.LENGTH, "row 3")
