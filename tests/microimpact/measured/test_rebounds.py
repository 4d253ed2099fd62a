"""Measured rebounds are read with their units, or refused in one line."""

import numpy as np
import pytest

from microimpact.measured.rebounds import SPEED_UNITS, read_rebounds


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "mine.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("v,e\n0.5,0.6\n0.1,0\n", None),
        ("# by hand\n\nv (cm/s),e\n50,0.6\n10,0\n", None),
        ("v_mm_per_s , e [-]\n500,0.6\n100,0\n", None),
        ("v,V\n50,30\n10,0\n", "cm/s"),
        ("v,V (mm/s)\n50,-300\n10,0\n", "cm/s"),
        ("v,captured,e\n0.5,no,0.6\n0.1,yes,\n", None),
    ],
)
def test_units_and_forms(written, text, unit):
    data = read_rebounds(written(text), unit)
    assert np.allclose(data.v, [0.5, 0.1])
    assert np.allclose(data.e, [0.6, 0.0])
    assert data.sigma is None


@pytest.mark.parametrize(
    ("unit", "speed"),
    [("m/s", 36.0), ("mm/s", 0.036), ("cm/s", 0.36), ("um/s", 3.6e-5), ("km/h", 10.0)],
)
def test_every_unit_of_speed(written, unit, speed):
    for data in (
        read_rebounds(written(f"v ({unit}),e\n36,0.6\n")),
        read_rebounds(written("v,e\n36,0.6\n"), unit),
    ):
        assert data.v == pytest.approx([speed], rel=1e-15)


def test_every_unit_of_speed_is_tried():
    assert set(SPEED_UNITS) == {"m/s", "mm/s", "cm/s", "um/s", "km/h"}


def test_sigma_is_read(written):
    assert read_rebounds(written("v,e,sigma\n1,0.5,0.02\n")).sigma == [0.02]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no header"),
        ("v,e\n", "no data"),
        ("v,f\n1,2\n", "the column 'f' is none of"),
        ("speed,e\n1,2\n", "the column 'speed'"),
        ("v,v\n1,2\n", "stands there twice"),
        ("v (m/s);e\n1;0,5\n", "line 1: the columns must be separated by commas, got ';'"),
        ("v\te\n1\t0.5\n", "the columns must be separated by commas, got '\\t'"),
        ("v e\n1 0.5\n", "the columns must be separated by commas, got ' '"),
        ('v,e\n"1,0.5\n2,0.6\n', "line 2: unexpected end of data"),
        ("v,sigma\n1,2\n", "either e or V are needed"),
        ("v,e,V\n1,0.5,0.5\n", "either e or V are needed"),
        ("v (furlong),e\n1,0.5\n", "the unit of v must be one of"),
        ("v,e (%)\n1,50\n", "e has no unit"),
        ("v,e\n1,0.5\n2\n", "line 3: 1 cells, but 2 columns"),
        ("v,e\n1,fast\n", "line 2: e must be a number, got 'fast'"),
        ("v,e\n1,nan\n", "e must be a number"),
        ("v,e\n0,0.5\n", "v must be positive, got 0"),
        ("v,e\n1,70\n", "line 2: e must be from 0 to 1, got 70; divide percent by 100"),
        ("v,e\n1,-0.1\n", "e must be from 0 to 1"),
        ("v,V\n1,1.5\n", "V/v = 1.5"),
        ("v,e,sigma\n1,0.5,0\n", "sigma must be above 0"),
        ("v,e,captured\n1,0.5,yes\n", "captured, but e is 0.5"),
        ("v,e,captured\n1,0.5,maybe\n", "captured must be yes or no, got 'maybe'"),
    ],
)
def test_bad_files_are_refused(written, text, message):
    with pytest.raises(ValueError, match=r"mine\.csv") as refused:
        read_rebounds(written(text))
    assert message in str(refused.value)


def test_a_file_in_another_encoding_is_refused(tmp_path):
    (tmp_path / "mine.csv").write_bytes("v,e\n1,0.5\n".encode("utf-16"))
    with pytest.raises(ValueError, match=r"mine\.csv: must be a text in UTF-8, byte 0 is not"):
        read_rebounds(tmp_path / "mine.csv")


def test_an_unknown_unit_is_refused(written):
    with pytest.raises(ValueError, match="unit must be one of"):
        read_rebounds(written("v,e\n1,0.5\n"), "mph")
