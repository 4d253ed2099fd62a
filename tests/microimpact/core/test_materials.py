"""Materials, the tables they are declared in with their units, and constants of nature."""

import csv
import math

import numpy as np
import pytest
import scipy

from microimpact.core import constants, materials
from microimpact.core.materials import (
    Material,
    declared_file,
    find_material,
    materials_from_rows,
    quantity,
)

GOOD = {"name": "steel", "youngs_modulus": 193e9, "poissons_ratio": 0.28, "density": 8000.0}


def rows(**values):
    table = {"youngs_modulus": ("193", "GPa"), "poissons_ratio": ("0.28", "-")}
    table |= {"density": ("8000", "kg/m3")} | values
    return [
        {"material": "steel", "property": name, "value": value, "unit": unit}
        for name, (value, unit) in table.items()
    ]


@pytest.mark.parametrize("ratio", [-0.999999, 0.0, 0.5])
def test_poissons_ratio_may_be_anything_a_stable_solid_has(ratio):
    assert Material(**GOOD | {"poissons_ratio": ratio}).poissons_ratio == ratio


@pytest.mark.parametrize("key", ["youngs_modulus", "density", "poissons_ratio"])
@pytest.mark.parametrize("value", ["1", True, None, 1j])
def test_a_property_that_is_no_number_is_a_type_error(key, value):
    with pytest.raises(TypeError, match=f"^{key} must be a real number"):
        Material(**GOOD | {key: value})


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("youngs_modulus", 0.0, "0"),
        ("youngs_modulus", -1.0, "-1"),
        ("youngs_modulus", math.nan, "nan"),
        ("youngs_modulus", math.inf, "inf"),
        ("density", 0, "0"),
        ("density", -2, "-2"),
        ("poissons_ratio", -1.0, "-1"),
        ("poissons_ratio", 0.51, "0.51"),
        ("poissons_ratio", math.nan, "nan"),
    ],
)
def test_a_property_out_of_range_is_a_value_error(key, value, said):
    with pytest.raises(ValueError, match=f"^{key} must be .*got {said}$"):
        Material(**GOOD | {key: value})


def test_the_name_is_text():
    with pytest.raises(TypeError, match="name must be text, got 3"):
        Material(**GOOD | {"name": 3})


@pytest.mark.parametrize(
    "name", ["α-Al₂O₃ (50 %), no. 7", "Si/SiO2 [100] #2", "glass - soda * lime"]
)
def test_a_name_is_one_printable_line(name):
    assert Material(**GOOD | {"name": name}).name == name


@pytest.mark.parametrize(
    "name",
    [
        *("a\nb", "a\rb", "a\u2028b", "a\x00b", "a\u202eb", "a */ b", "a /* b", "a\\", "a??/"),
        *("=1+1", "+1", "@SUM(A1)", "a, =1+1", 'a;"-1"'),
    ],
)
def test_a_name_that_is_code_elsewhere_is_refused(name):
    with pytest.raises(ValueError, match="name must be one line of printable text") as refused:
        Material(**GOOD | {"name": name})
    assert repr(name) in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_properties_broadcast():
    material = Material(**GOOD | {"density": [1e3, 2e3]})
    assert np.shape(material.density) == (2,)
    with pytest.raises(ValueError, match=r"youngs_modulus \(3,\).*density \(2,\)"):
        Material(**GOOD | {"density": [1e3, 2e3], "youngs_modulus": [1e9, 2e9, 3e9]})


def test_rows_become_a_material_in_si_units():
    steel = materials_from_rows(rows(density=("8", "g/cm3")))["steel"]
    assert steel.youngs_modulus == 193e9
    assert steel.density == 8000.0


def test_an_unknown_material_is_an_error_that_names_the_nearest():
    known = materials_from_rows(rows())
    assert find_material("steel", known) is known["steel"]
    with pytest.raises(ValueError, match=r"unknown material 'stel' \(did you mean 'steel'\?\)"):
        find_material("stel", known)


def test_every_declared_material_is_sound():
    text = declared_file("materials.csv").read_text(encoding="utf-8")
    declared = materials_from_rows(csv.DictReader(text.splitlines()))
    assert {"stainless-steel-316", "silicon"} <= set(declared)
    assert all(1e8 < m.youngs_modulus < 1e12 for m in declared.values())
    assert all(500 < m.density < 25000 for m in declared.values())


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
    row = {"property": "size", "value": "2", "unit": unit}
    assert quantity(row, {"size": kind}, "somewhere") == 2.0 * factor
    with pytest.raises(ValueError, match="row 3, size: unit 'kg' must be one of"):
        quantity(row | {"unit": "kg"}, {"size": kind}, "row 3")


def test_constants_are_scipys():
    assert constants.gravity == scipy.constants.g
    assert constants.epsilon_0 == scipy.constants.epsilon_0
