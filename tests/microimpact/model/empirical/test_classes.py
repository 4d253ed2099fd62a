"""Classes of one data set: the exponent of v_c is that of the data, a poor class costs its row."""

import numpy as np
import pytest

from microimpact import compare_classes, compare_models
from microimpact.core.computable import NotComputable
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.empirical import scatter, shapes

EXPONENT, NOISE = -1.3, 0.01
SIZES = (20e-6, 40e-6, 80e-6, 160e-6)


@pytest.fixture(scope="module")
def data():
    rng, rows = np.random.default_rng(5), []
    for d in SIZES:
        limit = 0.2 * (d / SIZES[0]) ** EXPONENT
        v = limit * np.geomspace(0.9, 10.0, 3 if d == SIZES[-1] else 14)
        e = 0.7 * np.sqrt(np.maximum(1.0 - (limit / v) ** 2, 0.0))
        rows.append(
            np.array([v, np.where(e > 0.0, e + rng.normal(0.0, NOISE, v.size), 0.0), 0 * v + d])
        )
    return np.concatenate(rows, axis=1)


def test_exponent_of_classes_and_one_that_cannot_be_fitted(data):
    v, e, d = data
    names = [f"{1e6 * x:g} um" for x in d]
    found = compare_classes(names, v, e, NOISE, d=d, models=["fixed loss", "hysteresis"])
    low, high = found.exponent_interval
    assert low < EXPONENT < high
    assert high - low < 0.2
    assert [*found.compared] == ["20 um", "40 um", "80 um", "160 um"]
    assert isinstance(found.compared["160 um"], NotComputable)
    assert "160 um: v must hold at least" in str(found)
    rows = d == SIZES[1]
    alone = compare_models(v[rows], e[rows], NOISE, d=d[rows], models=["fixed loss", "hysteresis"])
    assert found.compared["40 um"].v_c_interval == alone.v_c_interval
    assert found.laws["fixed loss"] == pytest.approx((-5.0 / 6.0, 1.0), abs=1e-3)


def test_without_sizes_there_is_no_exponent(data):
    v, e, d = data
    found = compare_classes(d, v, e, NOISE, models=["fixed loss"])
    assert found.exponent is None
    assert "two classes with v_c and d" in found.summary()
    with pytest.raises(ValueError, match="classes must be of the shape of v"):
        compare_classes(d[1:], v, e)


@pytest.mark.parametrize("name", ["viscous JKR", "Thornton-Ning", "hysteresis"])
def test_exponent_of_a_law_is_that_of_its_capture_velocity(name):
    at = 20.0
    low, high, count = shapes.LAWS[name].axes[0]
    value = low * (high / low) ** (at / (count - 1))
    contact = shapes.contact(name, np.array(value), np.array(1.0))
    limits = capture_velocity(contact.replace(diameter=contact.diameter * np.array([0.99, 1.01])))
    exponent = np.log(limits[1] / limits[0]) / np.log(1.01 / 0.99)
    assert -scatter.size_exponent(name, np.array([0.0, at, 0.0])) == pytest.approx(
        exponent, rel=0.01
    )
