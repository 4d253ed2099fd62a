"""Checked numbers."""

import math

import numpy as np
import pandas as pd
import pint
import pytest

from microimpact.core.arrays import (
    FINITE,
    NON_NEGATIVE,
    POSITIVE,
    Range,
    checked,
    choice,
    common_shape,
)


@pytest.mark.parametrize("value", [2, 2.0, np.int8(2), np.float32(2), np.array(2), np.array(2.0)])
def test_a_single_number_becomes_a_float(value):
    number = checked("x", value)
    assert type(number) is float
    assert number == 2.0


@pytest.mark.parametrize(
    "values",
    [
        [1, 2],
        (1.0, 2.0),
        np.array([1, 2], dtype=np.uint8),
        np.float32([1, 2]),
        pd.Series([1.0, 2.0], index=[7, 3]),
        pd.Series([1, 2], dtype="Float64"),
    ],
)
def test_sequences_become_float_arrays_that_cannot_be_written(values):
    array = checked("x", values)
    assert isinstance(array, np.ndarray)
    assert array.dtype == np.float64
    assert array.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 3.0


def test_the_argument_is_copied():
    given = np.array([1.0, 2.0])
    kept = checked("x", given)
    given[0] = 9.0
    assert kept[0] == 1.0


def test_empty_arrays_keep_their_shape():
    assert checked("x", np.zeros((0, 3)), POSITIVE).shape == (0, 3)


@pytest.mark.parametrize(
    "value",
    [
        "1",
        b"1",
        True,
        None,
        1j,
        [1.0, None],
        [1.0, "a"],
        [[1.0], [1.0, 2.0]],
        {"a": 1.0},
        {1.0},
        object,
        np.array([True]),
        np.array(["1"]),
        np.timedelta64(1, "s"),
    ],
)
def test_what_is_no_real_number_is_a_type_error_that_names_it(value):
    with pytest.raises(TypeError, match=r"^speed must be a real number") as error:
        checked("speed", value)
    assert repr(value) in str(error.value)


@pytest.mark.parametrize(
    ("value", "allowed", "said"),
    [
        (math.nan, FINITE, "finite, got nan"),
        (math.inf, FINITE, "finite, got inf"),
        (-math.inf, NON_NEGATIVE, "finite and >= 0, got -inf"),
        (0, POSITIVE, "finite and > 0, got 0"),
        (-1e-300, NON_NEGATIVE, "finite and >= 0, got -1e-300"),
        (-2, Range(lower=-1.0, upper=0.5, upper_closed=True), r"finite and in \(-1, 0.5\], got -2"),
        ([1, math.nan], FINITE, "finite, got nan at index 1"),
        ([[1, 2], [3, -4]], POSITIVE, "finite and > 0, got -4 at index 1, 1"),
    ],
)
def test_a_number_out_of_range_is_a_value_error_that_names_it(value, allowed, said):
    with pytest.raises(ValueError, match=f"^speed must be {said}$"):
        checked("speed", value, allowed)


def test_ranges_know_their_ends():
    values = np.array([0.0, 0.5, 1.0])
    assert Range(lower=0.0, upper=1.0).contains(values).tolist() == [False, True, False]
    closed = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)
    assert closed.contains(values).all()


def test_shapes_broadcast_or_are_named():
    assert common_shape({"a": 1.0, "b": np.zeros(3), "c": np.zeros((2, 1))}) == (2, 3)
    with pytest.raises(ValueError, match=r"speed \(2,\), angle \(3,\)") as error:
        common_shape({"speed": np.zeros(2), "angle": np.zeros(3), "spin": 0.0})
    assert "spin" not in str(error.value)


def test_a_choice_is_one_of_the_allowed_words():
    assert choice("mode", "a", ("a", "b")) == "a"
    with pytest.raises(ValueError, match="mode must be one of 'a', 'b', got 'c'"):
        choice("mode", "c", ("a", "b"))
    with pytest.raises(TypeError, match="mode must be one of 'a', 'b', got None"):
        choice("mode", None, ("a", "b"))


def test_masked_values_are_refused_and_a_mask_that_hides_nothing_is_not():
    measured = np.ma.masked_greater([1.0, 2.0, 9.0], 5.0)
    with pytest.raises(ValueError, match=r"^speed must have no masked values"):
        checked("speed", measured)
    np.testing.assert_array_equal(checked("speed", measured[:2]), [1.0, 2.0])


@pytest.mark.parametrize(
    ("name", "value", "unit", "expected"),
    [
        ("diameter", 62.0, "um", 62e-6),
        ("speed", 166.0, "cm/s", 1.66),
        ("angle", np.pi / 2.0, "rad", 90.0),
        ("youngs_modulus", 193.0, "GPa", 193e9),
        ("e", 70.0, "percent", 0.7),
        ("density", [8.0, 2.5], "g/cm**3", [8000.0, 2500.0]),
    ],
)
def test_a_quantity_with_a_unit_is_converted(name, value, unit, expected):
    quantity = pint.UnitRegistry().Quantity(np.asarray(value), unit)
    assert np.allclose(checked(name, quantity), expected, rtol=1e-14)


def test_a_quantity_of_another_kind_is_refused():
    length = pint.UnitRegistry().Quantity(1.0, "m")
    with pytest.raises(TypeError, match=r"speed must be in m/s, got 1\.0 meter"):
        checked("speed", length)
    with pytest.raises(TypeError, match="friction must be in plain numbers"):
        checked("friction", length)
