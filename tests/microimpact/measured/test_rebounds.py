"""Measured rebounds are read with their units, or refused in one line."""

import numpy as np
import pandas as pd
import pytest

from microimpact import compare_models, fit_restitution
from microimpact.measured.rebounds import read_rebounds
from microimpact.measured.table import SPEED_UNITS


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
        ("v,e (%)\n0.5,60\n0.1,0\n", None),
        ("v in cm/s;e\n50;0,6\n10;0\n", None),
        ("v\te\n0,5\t0,6\n0,1\t0\n", None),
        ("  % by hand\nv (m/s)  e\n0.5  0.6\n0.1  0\n", None),
        ("v,e,angle\n1.0,0.6,30\n0.1,0,90\n", None),
        ("v [m s^-1],e,Captured\n0.5,0.6,no\n0.1,,yes\n", None),
        ("v mm/s,e\n500,0.6\n100,0\n", None),
        ("v:mm/s,e\n500,0.6\n100,0\n", None),
        ("vel_mms,e\n500,0.6\n100,0\n", {"v": "vel_mms"}),
        ("U_mm_s,e\n500,0.6\n100,0\n", None),
        ("u.impact (mm s$^{-1}$),COR [1]\n500,0.6\n100,0\n", None),
        ("V_in mm/s,V_out\n500,300\n100,0\n", None),
        ("velocity (m/s),restitution\n0.5,0.6\n0.1,0\n", None),
        ("v,e,sigma_d\nmm/s,-,%\n500,0.6,2\n100,0,2\n", None),
        ('"","v","e"\n"1",0.5,0.6\n"2",0.1,0\n', None),
        ('"v" "e"\n"0.5" 0.6\n0.1 0\n', None),
        ("v,V\n-0.5,0.3\n-0.1,0\n", None),
    ],
)
def test_units_and_forms(written, text, unit):
    unit, columns = (None, unit) if isinstance(unit, dict) else (unit, None)
    data = read_rebounds(written(text), unit, columns=columns)
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
    "text",
    [
        "v (m/s),e,sigma_v (mm/s),d (um),sigma_d (nm)\n0.5,0.6,10,30,600\n",
        "v (m/s),e,sigma_v [%],d [mm],sigma_d [%]\n0.5,0.6,2,0.03,2\n",
        "v (m/s),e,sigma_v (m/s),d (m),sigma_d (um),angle\n1.0,0.6,0.02,3e-5,0.6,30\n",
    ],
)
def test_errors_of_speed_and_diameters_are_read(written, text):
    data = read_rebounds(written(text))
    assert data.sigma_v == pytest.approx([0.01])
    assert data.d == pytest.approx([30e-6])
    assert data.size_scatter == pytest.approx([0.02])
    alone = read_rebounds(written("v,e,sigma_d (%)\n1,0.5,7\n"))
    assert alone.size_scatter == pytest.approx([0.07])
    assert alone.d is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no header"),
        (
            "v,e,d\n1,0.5,30\n",
            "d must be from 1e-09 to 0.005 m where no unit is stated, got 30; give --size-unit",
        ),
        ("v in furlong,e\n1,0.5\n", "the unit of v must be one of m/s, mm/s"),
        ("v,e\nmph,-\n1,0.5\n", "line 2: v must be a number, or one of the units m/s, mm/s"),
        ("v (m/s),e\nmm/s,-\n1,0.5\n", "the units of v must be the same twice"),
        ("v,velocity,e\n1,1,0.5\n", "v stands there twice, 'v' and 'velocity'; choose by"),
        ("v,e,d (um),R (um)\n1,0.5,30,15\n", "either d or radius must be given, got both"),
        ("v,e\n-1,0.5\n1,0.5\n", "v must be positive, got -1"),
        ("v,e,sigma\n1,1.07,0.02\n", "e must be from 0 to 1, or above by at most 3 sigma"),
        (
            "v,e\n1,1.4\n2,0.5\n3,-0.1\n4\n",
            "line 2: e must be from 0 to 1, got 1.4; line 4: e must be from 0 to 1, got -0.1; "
            "line 5: 1 cells, but 2 columns in the header; 3 bad rows; --skip-bad-rows",
        ),
        ("v,e,d (um)\n1,0.5,0\n", "line 2: d must be positive, got 0"),
        ("v,e,sigma_d (um)\n1,0.5,2\n", "sigma_d needs the column d, or is in %: 'sigma_d (%)'"),
        ("v,e,sigma_v (%)\n1,0.5,50\n", "sigma_v must be from 0 to half of v, got 50"),
        ("v,e\n", "no data"),
        ("v,f\n1,2\n", "e or V are needed, got 'v', 'f'"),
        ("w,e\n1,2\n", "needed, got 'e', 'w'; other names go by --columns"),
        ("v,v\n1,2\n", "stands there twice"),
        ('v,e\n"1,0.5\n2,0.6\n', "line 2: unexpected end of data"),
        ("v,sigma\n1,2\n", "e or V are needed"),
        ("v,e,V\n1,0.5,0.6\n", "line 2: V must be e times the normal speed, got 0.6"),
        ("v (furlong),e\n1,0.5\n", "the unit of v must be one of"),
        ("v,e (J)\n1,50\n", "the unit of e must be one of 1, -, %, got 'J'"),
        ("v;e\n1,0;0.5\n", "numbers have commas ('1,0') and points ('0.5')"),
        ("v,e\n1,n.d.\n", "no data below the header"),
        ("v,e\n1,1.01\n", "e must be from 0 to 1, got 1.01"),
        ("v,e,angle\n1,0.5,91\n", "angle must be above 0 and at most 90 degrees, got 91"),
        ("v,e\n1,0.5\n2\n", "line 3: 1 cells, but 2 columns"),
        ("v,e\n1_0,0.5\n", "line 2: v must be a number, got '1_0'"),
        ("v,e\n1,fast\n", "line 2: e must be a number, got 'fast'"),
        ("v,e\n0,0.5\n", "v must be positive, got 0"),
        ("v,V,sigma_v\n0,0.5,0.1\n", "v must be positive, got 0"),
        ("v,e\n1,70\n", "line 2: e must be from 0 to 1, got 70; are these percent?"),
        ("v,e\n1,-0.1\n", "e must be from 0 to 1"),
        ("v,V\n1,1.5\n", "V/v = 1.5"),
        ("v,e,sigma\n1,0.5,0\n", "sigma must be above 0"),
        ("v,e,captured\n1,0.5,yes\n", "e must be 0 or empty for a captured sphere, got 0.5"),
        ("v,e,captured\n1,0.5,maybe\n", "captured must be yes or no, got 'maybe'"),
    ],
)
def test_bad_files_are_refused(written, text, message):
    with pytest.raises(ValueError, match=r"mine\.csv") as refused:
        read_rebounds(written(text))
    assert message in str(refused.value)


def test_a_spreadsheet_of_a_german_laboratory(tmp_path):
    """Latin-1, semicolons, decimal commas, comments, names and columns of its own, missing rows."""
    lines = (
        "% Rückprall, Düse 3",
        "  # glass on steel",
        "Nr;Dp [µm];Impact speed [cm/s];Rebound [mm/s];Remark",
        '1;30,1;50;300;"good; really"',
        "2;29,8;40,0;n.d.;dirt",
        "3;30,0;;-120;",
        "4;30,0;10;0,0;stuck;;",
    )
    path = tmp_path / "german.csv"
    path.write_bytes("\r\n".join(lines).encode("latin-1"))
    data = read_rebounds(path, columns={"v": "Impact speed [cm/s]", "V": "Rebound"})
    assert data.v == pytest.approx([0.5, 0.1], rel=1e-15)
    assert data.e == pytest.approx([0.6, 0.0], rel=1e-15)
    ignored, skipped = data.notes
    assert data.d == pytest.approx([30.1e-6, 30e-6], rel=1e-15)
    assert ignored == "german.csv: columns not used: 'Nr', 'Remark'"
    assert "2 of 4 rows lack a number and are skipped: line 5, line 6" in skipped


def test_a_frame_and_a_mapping_are_read_as_a_file():
    columns = {"v (cm/s)": [50.0, 30.0, 10.0], "e": [0.6, np.nan, 0.0], "run": [1, 2, 3]}
    for table in (columns, pd.DataFrame(columns)):
        data = read_rebounds(table)
        assert data.v == pytest.approx([0.5, 0.1], rel=1e-15)
        assert data.e.tolist() == [0.6, 0.0]
        assert "row 1" in data.notes[1]
    with pytest.raises(ValueError, match="columns must be of one length, got v 2, e 1"):
        read_rebounds({"v": [1.0, 2.0], "e": [0.5]})
    with pytest.raises(TypeError, match="a file, a data frame or a mapping of arrays, got 3"):
        read_rebounds(3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"columns": {"speed": "v"}}, "columns: 'speed' is none of v, e"),
        ({"size_unit": "ft"}, "unit of sizes must be one of m, mm, um, nm, cm, got 'ft'"),
        ({"columns": {"v": "Speed"}}, r"mine.csv: no column 'Speed' \(known here: e, v\)"),
        ({"delimiter": "/"}, "delimiter must be one of comma, semicolon"),
        ({"decimal": "/"}, "decimal must be '.' or ','"),
    ],
)
def test_wrong_options_are_refused(written, options, message):
    with pytest.raises(ValueError, match=message):
        read_rebounds(written("# \u00b5\nv,e\n1,0.5\n"), **options)


def test_forms_that_are_stated_are_taken(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("v;e\n1,5;0,5\n", encoding="utf-16")
    data = read_rebounds(path, delimiter="semicolon", decimal=",")
    assert data.v.tolist() == [1.5]
    assert read_rebounds(path).v.tolist() == [1.5]


def test_a_workbook_is_refused(tmp_path):
    (tmp_path / "mine.xlsx").write_bytes(b"PK\x03\x04rest")
    with pytest.raises(ValueError, match=r"mine\.xlsx: must be a text, got a workbook"):
        read_rebounds(tmp_path / "mine.xlsx")


def test_an_unknown_unit_is_refused(written):
    with pytest.raises(ValueError, match="unit of speeds must be one of"):
        read_rebounds(written("v,e\n1,0.5\n"), "mph")


MINE = "0.15,0\n0.20,0.19\n0.23,0.30\n"


def test_a_captured_sphere_needs_no_sigma(written):
    """Neither where it is said to be captured, nor where e is 0; 0 is no sigma."""
    rows = "0.1,,,yes\n0.11,0,,no\n0.12,,0,yes\n0.20,0.19,0.02,no\n0.23,0.30,0.04,no\n"
    data = read_rebounds(written("v,e,sigma,captured\n" + rows))
    assert data.e.tolist() == [0.0, 0.0, 0.0, 0.19, 0.30]
    assert data.sigma == pytest.approx([0.03, 0.03, 0.03, 0.02, 0.04])
    assert not data.notes


def test_sizes_are_of_the_unit_that_is_stated_somewhere(written):
    bare = written(f"v,e,R,sigma_d\n{MINE.replace(chr(10), ',15,0.6' + chr(10))}")
    named = {"columns": {"radius": "R"}, "size_unit": "µm"}
    half = written(f"v,e,R (um),sigma_d\n{MINE.replace(chr(10), ',15,0.6' + chr(10))}")
    for data in (read_rebounds(bare, **named), read_rebounds(half)):
        assert data.d == pytest.approx([30e-6] * 3)
        assert data.size_scatter == pytest.approx([0.02] * 3)
    in_memory = read_rebounds({"v": [0.2], "e": [0.2], "d": [30e-6]})
    assert in_memory.d == pytest.approx([30e-6])


@pytest.mark.parametrize("speed", [0.22, 0.3, 1.0])
def test_the_error_of_a_speed_is_in_a_ratio_of_speeds(speed):
    """Residuals of e^2 = 0.64 (1 - (0.2/v)^2) at a measured v, with the share that a fit has."""

    def curve(v):
        return 0.8 * np.sqrt(1.0 - (0.2 / v) ** 2)

    rng, share = np.random.default_rng(5), 0.01
    after = curve(speed) * speed
    v = speed * (1.0 + share * rng.standard_normal(100_000))
    e = after / v + 0.01 * rng.standard_normal(v.size)
    columns = {"v": [speed, 50.0], "V": [after, 40.0]}
    data = read_rebounds(columns, sigma=0.01, sigma_v="1%")
    slope = 0.64 * 0.2**2 / speed**3 / curve(speed)
    expected = np.hypot(data.sigma[0], slope * data.sigma_v[0])
    assert np.std(e - curve(v)) == pytest.approx(expected, rel=0.04)
    restitutions = {"v": columns["v"], "e": [0.5, 0.8]}
    assert read_rebounds(restitutions, sigma=0.01, sigma_v=0.01).sigma.tolist() == [0.01, 0.01]


def test_a_speed_is_not_in_the_unit_of_its_error(written):
    data = read_rebounds(written("v,e,sigma_v (mm/s)\n0.5,0.6,5\n"))
    assert (data.v, data.sigma_v) == (pytest.approx([0.5]), pytest.approx([0.005]))
    data = read_rebounds(written("v (mm/s),V,sigma_v\n500,300,5\n"))
    assert (data.e, data.sigma_v) == (pytest.approx([0.6]), pytest.approx([0.005]))


def test_noise_above_one_is_data(written):
    assert read_rebounds(written("v,e\n1,1.03\n"), sigma=0.02).e == [1.03]


def test_bad_rows_can_be_left_out(written):
    data = read_rebounds(written("v,e\n1,1.4\n2,0.5\n3\n"), skip_bad_rows=True)
    assert data.e.tolist() == [0.5]
    assert "bad rows are left out: mine.csv, line 2: e must be from 0 to 1" in data.notes[0]


@pytest.mark.parametrize(
    ("text", "doubt"),
    [
        ("v,e\n200,0.3\n3000,0.7\n", "normal_speed = 200 m/s is not from 0.0001 to 150 m/s"),
        ("v,e,angle\n1,0.3,0.8\n2,0.3,1.5\n", "angle = 1.5 degrees is not from 1.5708 to 90"),
        ("v,e,d (m)\n1,0.3,30\n", "diameter = 30 m is not from 1e-09 to 0.005 m: in um?"),
        ("v,e\n-1,0.5\n-2,0.5\n", "all speeds v are negative; their amounts are taken"),
    ],
)
def test_what_is_hardly_meant_is_doubted(written, text, doubt):
    assert doubt in " ".join(read_rebounds(written(text)).notes)


def test_what_was_read_is_said_in_a_line(written):
    text = "v (cm/s),e,angle,d (um)\n50,0.6,30,80\n10,0,90,40\n"
    assert str(read_rebounds(written(text))) == (
        "mine.csv: 2 rows, 1 captured; v in cm/s; normal speeds 0.1 to 0.25 m/s (v times the sine "
        "of the angle); diameters 40 to 80 um"
    )
    assert "v in m/s, which is not stated" in read_rebounds(written("v,e\n1,0.5\n")).read


def test_what_is_read_goes_into_every_fit(written):
    rows = "0.30,0.45\n0.40,0.56\n0.55,0.64\n0.80,0.68\n1.20,0.72\n1.70,0.71\n2.50,0.66\n"
    data = read_rebounds(written("v,e\n" + MINE + rows), sigma=0.02)
    fit = fit_restitution(**data, q=0.5)
    assert fit.v_c == fit_restitution(data.v, data.e, data.sigma, q=0.5).v_c
    found = compare_models(**data, models=["fixed loss"])
    assert found.v_c == compare_models(data.v, data.e, 0.02, models=["fixed loss"]).v_c
    assert data.keys() == ("v", "e", "sigma")


SIZED = "v (m/s),e,d (um),batch\n0.5,0.6,20,a\n0.4,0.5,40,b\n0.1,0,60,\n"


@pytest.mark.parametrize(
    ("classes", "names"),
    [
        ("batch", ["a", "b"]),
        ("d", ["20 um", "40 um", "60 um"]),
        ("d=10,30,50", ["10 to 30 um", "30 to 50 um"]),
    ],
)
def test_classes_by_a_column_a_size_or_bins(written, classes, names):
    data = read_rebounds(written(SIZED), classes=classes)
    assert data.classes.tolist() == names
    assert data.v.size == len(names)
    assert any("lack a number" in note for note in data.notes) == (len(names) < 3)


@pytest.mark.parametrize(
    ("classes", "words"),
    [
        ("lot", "no column 'lot'"),
        ("d=50,10", "--classes must be as d=20,40,80"),
        ("batch=1,2", "bins are of d or radius"),
        ("radius", "needs the column radius"),
    ],
)
def test_refused_classes(written, classes, words):
    with pytest.raises(ValueError, match=words):
        read_rebounds(written(SIZED), classes=classes)
