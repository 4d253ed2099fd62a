"""The command line: readable tables, JSON in SI units, one line for bad input."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from microimpact import Contact, Material, cli, simulate
from microimpact.core.materials import declared_file

ROOT = Path(__file__).parents[2]
STEEL = ("--particle", "stainless-steel-316", "--surface", "silicon")
FLUORESCEIN = ("--particle", "ammonium-fluorescein", "--surface", "molybdenum")
UNDECLARED = ("--particle", "stainless-steel-316", "--surface", "mica", "--diameter-um", "10")


@pytest.fixture
def microimpact(capsys, monkeypatch):
    """Return a function that runs the command in this process."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["microimpact", *arguments])
        try:
            cli.main()
            code = 0
        except SystemExit as end:
            code = end.code
        printed = capsys.readouterr()
        return SimpleNamespace(returncode=code, stdout=printed.out, stderr=printed.err)

    return run


def test_it_is_installed_as_a_command():
    command = Path(sys.executable).with_name("microimpact")
    done = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("microimpact, version")


def test_simulate_as_table_and_as_json_agree(microimpact):
    arguments = ("simulate", *STEEL, "--diameter-um", "62", "--speed", "1.66", "--angle", "50")
    table, found = microimpact(*arguments), microimpact(*arguments, "--json")
    assert table.returncode == found.returncode == 0, table.stderr + found.stderr
    values = json.loads(found.stdout)
    assert values["diameter"] == pytest.approx(62e-6)
    assert values["speed"] == 1.66
    assert f"{values['coefficient_of_restitution']:.6g}" in table.stdout
    assert values["captured"] is False
    assert values["rolling"] is True


def test_capture_uses_the_declared_pair_and_its_overrides(microimpact):
    declared = json.loads(microimpact("capture", *STEEL, "--json").stdout)
    weaker = json.loads(
        microimpact("capture", *STEEL, "--work-of-adhesion", "0.2", "--json").stdout
    )
    assert 0 < weaker["capture_velocity"] < declared["capture_velocity"]
    assert weaker["adhesion_damping"] == declared["adhesion_damping"]
    assert declared["in_place_of"] == {}
    assert weaker["in_place_of"] == {"work_of_adhesion": 0.7}
    words = microimpact("capture", *STEEL, "--work-of-adhesion", "0.2").stdout
    assert "work_of_adhesion 0.2 in place of 0.7; hertz_damping, adhesion_damping," in words


def test_the_answer_names_the_contact_and_repeats_all_inputs(microimpact):
    arguments = ("simulate", *STEEL, "--speed", "1.66", "--angle", "50", "--spin", "5000")
    text, found = (
        microimpact(*arguments).stdout,
        json.loads(microimpact(*arguments, "--json").stdout),
    )
    assert "62 um: w_A = 0.7 J/m2, c_H = 0.2148 s/m, c_A = 1.612 s/m, n = 1" in text
    assert (found["spin"], found["speed"], found["angle"]) == (5000.0, 1.66, 50.0)
    assert found["spin_after"] != found["spin"]
    materials = json.loads(microimpact("materials", "--json").stdout)["materials"]
    bodies = {
        role: Material(name=found[role], **materials[found[role]])
        for role in ("particle", "surface")
    }
    fields = ("diameter", "work_of_adhesion", "hertz_damping", "adhesion_damping", "friction",
              "adhesion_rate_exponent", "reference_velocity", "stiffness_model")  # fmt: skip
    again = simulate(
        Contact(**bodies, **{name: found[name] for name in fields}),
        found["speed"], found["angle"], found["spin"], found["friction_basis"], found["tangential"],
    )  # fmt: skip
    assert float(again.spin) == found["spin_after"]


def test_compliance_along_the_surface_is_an_option(microimpact):
    arguments = ("simulate", *STEEL, "--speed", "1.66", "--angle", "60")
    rigid, compliant = (
        json.loads(microimpact(*arguments, "--tangential", law, "--json").stdout)
        for law in ("rigid", "mindlin")
    )
    assert compliant["coefficient_of_restitution"] == rigid["coefficient_of_restitution"]
    assert compliant["spin_after"] > 1.1 * rigid["spin_after"]
    assert "compliance mindlin" in microimpact(*arguments, "--tangential", "mindlin").stdout


def test_the_declared_pairs_are_the_calibrated_cases():
    """One case of each pair, to the digits that contacts.csv gives."""
    table = pd.read_csv(ROOT / "tests/reference/tables/calibration.csv")
    table = table[table["role"] == "parameter"].set_index(["case", "quantity"])["value"]
    rows = pd.read_csv(declared_file("contacts.csv"))
    calibrated = rows[rows["evidence"] == "calibrated"]
    assert set(zip(calibrated["particle"], calibrated["surface"], strict=True)) == set(
        zip(rows["particle"], rows["surface"], strict=True)
    )
    for row in calibrated.itertuples():
        case = row.source.removeprefix("table calibration, case ")
        assert table[case, row.property] == pytest.approx(row.value, rel=4e-4)


def test_an_overdamped_contact_never_rebounds(microimpact):
    found = microimpact("capture", *STEEL, "--hertz-damping", "30")
    assert "inf" in found.stdout
    assert "No speed rebounds" in found.stdout
    as_json = microimpact("capture", *STEEL, "--hertz-damping", "30", "--json")
    assert json.loads(as_json.stdout)["capture_velocity"] is None


def test_captured_impact_prints_an_infinite_contact_time(microimpact):
    found = microimpact("simulate", *STEEL, "--speed", "0.05", "--json")
    values = json.loads(found.stdout)
    assert values["captured"] is True
    assert values["contact_time"] is None


def test_an_undeclared_pair_works_with_its_numbers_given(microimpact):
    numbers = ("--work-of-adhesion", "0.2", "--hertz-damping", "0", "--adhesion-damping", "0.3")
    assert microimpact("simulate", *UNDECLARED, *numbers, "--speed", "1").returncode == 0


def test_materials_lists_materials_and_pairs(microimpact):
    found = microimpact("materials")
    assert "ammonium-fluorescein" in found.stdout
    listed = json.loads(microimpact("materials", "--json").stdout)
    assert listed["materials"]["silicon"]["density"] == 2330.0
    assert {"particle", "surface", "friction"} <= set(listed["pairs"][0])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("simulate", "--particle", "steel", "--surface", "silicon", "--speed", "1"), "'steel'"),
        (
            ("simulate", *UNDECLARED, "--speed", "1"),
            "is not declared; give --work-of-adhesion, --hertz-damping, --adhesion-damping",
        ),
        (
            ("simulate", *STEEL, "--speed", "-1"),
            "speed must be finite and in (0, 2.99792e+08), got -1",
        ),
        (("simulate", *STEEL, "--speed", "nan"), "speed"),
        (("simulate", *STEEL, "--speed", "abc"), "abc"),
        (("simulate", *STEEL, "--speed", "1", "--angle", "91"), "angle"),
        (("simulate", *STEEL, "--speed", "1", "--friction-basis", "x"), "friction_basis"),
        (("simulate", *STEEL, "--speed", "1", "--tangential", "x"), "tangential must be one of"),
        (("capture", *STEEL, "--ring-force", "3", "--work-of-adhesion", "1"), "got both"),
        (("capture", *FLUORESCEIN, "--adhesion-rate-exponent", "1"), "reference_velocity"),
        (("capture", *STEEL, "--diameter-um", "0"), "diameter"),
        (("capture", *STEEL, "--friction", "-0.1"), "friction"),
        (("fly",), "fly"),
    ],
)
def test_bad_input_ends_with_one_clear_line(microimpact, arguments, words):
    found = microimpact(*arguments)
    assert found.returncode == 2
    assert found.stdout == ""
    assert words in found.stderr
    assert "Traceback" not in found.stderr


def test_export_writes_what_it_names(microimpact, tmp_path):
    folder = tmp_path / "law"
    done = microimpact("export", *STEEL, "--format", "openfoam", "-o", str(folder), "--json")
    written = json.loads(done.stdout)["files"]
    assert sorted(written) == sorted(str(path) for path in folder.iterdir())
    assert written[0] in microimpact("export", *STEEL, "-o", str(folder)).stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--format", "matlab"), "format must be one of"),
        (("--fastest", "0.01"), "fastest must be above the capture velocity"),
        (("--fastest", "-1"), "fastest must be"),
        (("--tolerance", "0"), "tolerance must be"),
        (("--friction-basis", "all"), "friction_basis must be one of"),
    ],
)
def test_export_refuses_and_writes_nothing(microimpact, tmp_path, options, message):
    done = microimpact("export", *STEEL, "-o", str(tmp_path / "law"), *options)
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "law").exists()


@pytest.fixture
def own_data(tmp_path):
    """Rebounds of the constant loss e = 0.9 sqrt(1 - (0.8/v)^2), some captured."""
    v = [0.5 * 1.13**i for i in range(20)]
    e = [0.9 * max(1.0 - (0.8 / speed) ** 2, 0.0) ** 0.5 for speed in v]
    rows = [f"{a:.5g},{b:.4f},0.02" for a, b in zip(v, e, strict=True)]
    path = tmp_path / "own.csv"
    path.write_text("\n".join(["v (m/s),e,sigma", *rows]), encoding="utf-8")
    return path


def test_fit_prints_draws_and_writes_json(microimpact, own_data, tmp_path):
    plot = tmp_path / "own.svg"
    text = microimpact("fit", str(own_data), "--plot", str(plot)).stdout
    found = json.loads(microimpact("fit", str(own_data), "--json").stdout)
    low, high = found["v_c_interval"]
    assert low < 0.8 < high
    assert set(found["models"]) >= {"fixed loss", "Eq. 34, q free", "ring force, n = 0"}
    assert f"v_c = {found['v_c']:.4g} m/s, 95 %: {low:.4g} to {high:.4g} m/s" in text
    assert "weight" in text
    assert plot.read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--unit", "mph"), "unit must be one of"),
        (("--sigma", "0.02"), "sigma stands in the file"),
        (("--confidence", "95"), "confidence must be"),
        (("--plot", "x.bmp"), "plot must end in"),
    ],
)
def test_fit_refuses_in_one_line(microimpact, own_data, options, message):
    done = microimpact("fit", str(own_data), *options)
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1


def test_fit_names_a_missing_file(microimpact):
    done = microimpact("fit", "nowhere.csv")
    assert done.returncode == 2
    assert "nowhere.csv" in done.stderr
