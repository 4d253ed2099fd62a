"""The command line: readable tables, JSON in SI units, one line for bad input."""

from __future__ import annotations

import html
import io
import json
import re
import shlex
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.shared import ROOT, execute

from microimpact import Contact, Material, capture_velocity, cli, contacts, simulate
from microimpact.cli import output
from microimpact.core.materials import declared_file
from microimpact.measured.contacts import write_contacts
from microimpact.model.choices import CALIBRATED
from microimpact.model.contact_laws import JKR

STEEL = ("--particle", "stainless-steel-316", "--surface", "silicon")
STYLE = ROOT / "src/study/figures/microimpact.mplstyle"
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


@pytest.fixture
def answered(microimpact):
    """Return a function that runs the command and returns its answer in JSON."""
    return lambda *arguments: json.loads(microimpact(*arguments, "--json").stdout)


def require_refusal(done, message):
    assert done.returncode == 2
    assert done.stdout == ""
    assert message in done.stderr
    assert done.stderr.startswith("microimpact: ")
    assert len(done.stderr.splitlines()) == 1


def test_it_is_installed_as_a_command():
    command = Path(sys.executable).with_name("microimpact")
    done = execute(command, "--version")
    assert done.stdout.startswith("microimpact, version")


def test_the_study_adds_what_users_need(microimpact):
    listed = re.findall(r"^  (\w+) ", microimpact("--help").stdout, re.MULTILINE)
    assert {"simulate", "claim", "compare"} <= set(listed)
    assert not {"check", "pages", "deviations", "report", "crate"} & set(listed)


def test_simulate_as_table_and_as_json_agree(microimpact):
    arguments = ("simulate", *STEEL, "--diameter-um", "62", "--speed", "1.66", "--angle", "50")
    table, found = microimpact(*arguments), microimpact(*arguments, "--json")
    assert table.returncode == found.returncode == 0, table.stderr + found.stderr
    answer = json.loads(found.stdout)
    assert answer["inputs"]["diameter"] == pytest.approx(62e-6)
    assert answer["inputs"]["speed"] == 1.66
    values = answer["outputs"]
    assert values["captured"] is False
    assert values["rolling"] is True
    rows = (re.split(r"  +", line) for line in table.stdout.splitlines())
    printed = {row[0]: row[1:] for row in rows}
    for label, name, factor, unit in (
        ("coefficient of restitution", "coefficient_of_restitution", 1.0, []),
        ("spin after", "spin", 1.0, ["rad/s"]),
        ("contact time", "contact_time", 1e9, ["ns"]),
        ("maximum compression", "maximum_compression", 1e9, ["nm"]),
    ):
        assert float(printed[label][0]) == pytest.approx(values[name] * factor, rel=5e-4)
        assert printed[label][1:] == unit


def test_two_spheres_have_a_second_spin(microimpact, answered, tmp_path):
    pair = (*STEEL, "--diameter-um", "62", "--partner-diameter-um", "31")
    answer = answered("simulate", *pair, "--speed", "2", "--angle", "50", "--partner-spin", "1e4")
    assert answer["inputs"]["partner_diameter"] == pytest.approx(31e-6)
    assert answer["outputs"]["partner_spin"] > 1e4
    table = microimpact("simulate", *pair, "--speed", "1:2:2").stdout
    assert "partner_spin_after_rad_per_s" in table.splitlines()[0]
    limits = [
        answered("capture", *options)["outputs"]["capture_velocity"]
        for options in (pair, pair[:-2])
    ]
    assert limits[0] != limits[1]


def test_capture_uses_the_declared_pair_and_its_overrides(microimpact, answered):
    declared = answered("capture", *STEEL)
    weaker = answered("capture", *STEEL, "--work-of-adhesion", "0.2")
    limits = [found["outputs"]["capture_velocity"] for found in (weaker, declared)]
    assert 0 < limits[0] < limits[1]
    for name in ("adhesion_damping", "hertz_damping"):
        assert weaker["inputs"][name] == declared["inputs"][name]


def test_the_answer_names_the_contact_and_repeats_all_inputs(microimpact, answered):
    arguments = ("simulate", *STEEL, "--speed", "1.66", "--angle", "50", "--spin", "5000")
    text, found = microimpact(*arguments).stdout, answered(*arguments)
    assert "62 um: w_A = 0.7 J/m2, c_H = 0.2148 s/m, c_A = 1.612 s/m, n = 1" in text
    found, after = found["inputs"], found["outputs"]
    assert (found["spin"], found["speed"], found["angle"]) == (5000.0, 1.66, 50.0)
    assert after["spin"] != found["spin"]
    bodies = {role: Material(**found[role]) for role in ("particle", "surface")}
    fields = ("diameter", "work_of_adhesion", "hertz_damping", "adhesion_damping", "friction",
              "adhesion_rate_exponent", "reference_velocity", "stiffness_model")  # fmt: skip
    again = simulate(
        Contact(**bodies, **{name: found[name] for name in fields}),
        found["speed"], found["angle"], found["spin"], found["friction_basis"], found["tangential"],
    )  # fmt: skip
    assert float(again.spin) == after["spin"]


def test_compliance_along_the_surface_is_an_option(microimpact, answered):
    arguments = ("simulate", *STEEL, "--speed", "1.66", "--angle", "60")
    rigid, compliant = (
        answered(*arguments, "--tangential", law)["outputs"] for law in ("rigid", "mindlin")
    )
    assert compliant["coefficient_of_restitution"] == rigid["coefficient_of_restitution"]
    assert compliant["spin"] > 1.1 * rigid["spin"]
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
        assert table[case, row.property] == pytest.approx(float(row.value), rel=4e-4)


def test_an_overdamped_contact_never_rebounds(microimpact):
    found = microimpact("capture", *STEEL, "--hertz-damping", "30")
    assert "inf" in found.stdout
    assert "overdamped" in found.stderr
    as_json = microimpact("capture", *STEEL, "--hertz-damping", "30", "--json")
    answer = json.loads(as_json.stdout)
    assert answer["outputs"]["capture_velocity"] is None
    assert answer["infinite"] == ["capture_velocity"]
    assert "overdamped" in as_json.stderr


def test_a_contact_needs_no_package_of_the_study():
    absent = "sys.modules |= dict.fromkeys(('pandas', 'pydantic', 'yaml', 'matplotlib'))"
    command = ["microimpact", "capture", *STEEL]
    code = f"import sys; {absent}; sys.argv = {command}; from microimpact.cli import main; main()"
    found = execute(sys.executable, "-c", code)
    assert "capture velocity            0.18 " in found.stdout


def test_materials_lists_materials_and_pairs(microimpact, answered):
    found = microimpact("materials")
    assert "ammonium-fluorescein" in found.stdout
    listed = answered("materials")
    assert listed["materials"]["silicon"]["density"] == 2330.0
    assert {"particle", "surface", "friction"} <= set(listed["pairs"][0])


STEEL_TEXT, UNDECLARED_TEXT = " ".join(STEEL), " ".join(UNDECLARED)
# A command line, and words of the one line that refuses it.
REFUSED = [
    ("fly", "fly"),
    ("claim C58 --results nowhere", "nowhere: no such folder"),
    ("fit nowhere.csv", "nowhere.csv: No such file or directory"),
    ("simulate --speed 1", "give --particle and --surface, or --contact"),
    ("simulate --contact nowhere.json --speed 1", "nowhere.json: No such"),
    ("simulate --particle steel --surface silicon --speed 1", "'steel'"),
    (
        "simulate --particle silicon --surface stainless-steel-316 --speed 1",
        "(did you mean 'stainless-steel-316 on silicon'?)",
    ),
    (
        f"simulate {UNDECLARED_TEXT} --speed 1",
        "is not declared; give --work-of-adhesion, --hertz-damping, --adhesion-damping",
    ),
    (
        "capture --particle clay --surface silicon --particle-density 2000",
        "give --particle-youngs-modulus-gpa, --particle-poissons-ratio",
    ),
    (f"capture {' '.join(FLUORESCEIN)} --adhesion-rate-exponent 1", "reference_velocity"),
    ("fit own.csv --unit mph", "unit of speeds must be one of"),
    ("fit own.csv --size-unit ft", "unit of sizes must be one of"),
    ("fit own.csv --sigma 0.02", "sigma stands in the file"),
    (
        "fit own.csv --sigma-v '2 percent'",
        "--sigma-v must be as '1.5%' or a number in m/s, below 50 %, got '2 perc",
    ),
    (
        "fit own.csv --size-scatter 7",
        "--size-scatter must be as '7%' or 'free', below 50 %, got '7'",
    ),
    ("fit own.csv --confidence 95", "confidence must be"),
    ("fit own.csv --tails heavy", "--tails must be degrees of freedom, 1 or more, or free"),
    ("fit nowhere.csv --plot x.bmp", "plot must end in"),
    ("fit nowhere.csv --report own.csv", "own.csv/index.html: cannot be written: Not a directory"),
    ("fit nowhere.csv --plot own.csv/x.png", "own.csv/x.png: cannot be written: Not a directory"),
    ("capture --particle a --surface b --materials /dev/null", "/dev/null: the header must have"),
    ("reference -o own.csv", "own.csv/adhesive_impacts.csv: cannot be written: Not a directory"),
] + [
    (f"{command} {STEEL_TEXT} {options}", words)
    for command, options, words in (
        ("simulate", "--speed -1", "speed must be finite and in (0, 2.99792e+08), got -1"),
        ("simulate", "--speed nan", "speed"),
        ("simulate", "--speed abc", "abc"),
        ("simulate", "--speed 1 --angle 91", "angle"),
        ("simulate", "--speed 1 --friction-basis x", "'--friction-basis'"),
        ("simulate", "--speed 1 --tangential x", "'--tangential'"),
        ("simulate", "--speed 1,5", "first:last:count"),
        ("simulate", "--speed 1:2", "first:last:count"),
        ("simulate", "--speed 1:2:0", "the count from 1 to 1000000"),
        ("simulate", "--speed 1 --contact nowhere.json", "nowhere.json: No such"),
        ("capture", "--materials nowhere.csv", "nowhere.csv"),
        ("capture", "--ring-force 3 --work-of-adhesion 1", "got both"),
        ("capture", "--diameter-um 0", "diameter"),
        ("capture", "--friction -0.1", "friction"),
        ("capture", "--particle-density -8", "--particle 'stainless-steel-316': density"),
        ("capture", "--law thornton-ning", "give --yield-pressure-gpa"),
        ("capture", "--law jkr --unloading-work 1", "that is of 'hysteresis'"),
        (
            "capture",
            "--law maugis-barquins --edge-speed 1",
            "needs its parameters: law=MaugisBarquins(edge_speed=..., edge_exponent=...)",
        ),
        ("capture", "--viscous-time-ns 1", "law 'ring force' does not know viscous_time"),
        ("capture", "--law jkr --hertz-damping 1", "leave out --hertz-damping"),
        ("export", "--format matlab", "'--format'"),
        ("export", "--fastest 0.01", "fastest must be above the capture velocity"),
        ("export", "--fastest -1", "fastest must be"),
        ("export", "--fastest 1e9", "fastest must be"),
        ("export", "--tolerance 0", "tolerance must be"),
        ("export", "--tolerance 10", "tolerance must be finite and in (0, 1), got 10"),
        ("export", "--friction-basis all", "'--friction-basis'"),
        ("calibrate", "", "give either DATA, or --at-speed, --restitution, --capture-velocity"),
        (
            "calibrate",
            "--restitution 0.7 --at-speed 1.66",
            "without DATA give --capture-velocity, too",
        ),
        ("calibrate own.csv", "--restitution 0.7", "give either DATA"),
        ("calibrate nowhere.csv", "", "nowhere.csv"),
        ("calibrate nowhere.csv", "-o own.csv/x", "own.csv/x: cannot be written"),
        ("calibrate own.csv", "--work-of-adhesion 1", "DATA find adhesion, damping and law; leave"),
        ("export", "-o own.csv", "cannot be written: Not a directory"),
        ("simulate", "--speed 1:inf:3", "first:last:count of finite numbers"),
        (
            "calibrate",
            "--work-of-adhesion 0.01 --restitution 0.9 --at-speed 0.3 --capture-velocity 0.18",
            "raise the work of adhesion or the rate exponent",
        ),
    )
]


@pytest.mark.parametrize(("line", "words"), REFUSED)
def test_bad_input_ends_with_one_clear_line(microimpact, own_data, monkeypatch, line, words):
    monkeypatch.chdir(own_data.parent)
    require_refusal(microimpact(*shlex.split(line)), words)
    assert [*own_data.parent.iterdir()] == [own_data]


@pytest.mark.parametrize(
    ("options", "flags"),
    [
        (STEEL, "--particle, --surface"),
        (("--friction", "0"), "--friction"),
    ],
)
def test_a_file_of_contacts_holds_the_whole_contact(microimpact, tmp_path, options, flags):
    file = tmp_path / "contacts.json"
    targets = ("--restitution", "0.7", "--at-speed", "1.66", "--capture-velocity", "0.18")
    microimpact("calibrate", *STEEL, *targets, "-o", str(file))
    done = microimpact("capture", "--contact", str(file), *options)
    require_refusal(done, f"but the diameter may change; leave out {flags}")


@pytest.mark.parametrize(
    ("options", "replaced"),
    [
        (("--particle-density", "7000"), "particle_density"),
        (("--surface-poissons-ratio", "0.5"), "surface_poissons_ratio"),
        (("--hertz-damping", "0.5"), "hertz_damping"),
        (("--diameter-um", "30"), ""),
    ],
)
def test_a_pair_that_is_no_longer_the_declared_one_says_so(microimpact, options, replaced):
    text = microimpact("capture", *STEEL, *options).stdout
    assert ("No longer the declared contact" in text) == bool(replaced)
    assert f"{replaced} by option, work_of_adhesion, " in text or not replaced


def test_export_writes_what_it_names(microimpact, answered, tmp_path):
    folder = tmp_path / "law"
    written = answered("export", *STEEL, "--format", "openfoam", "-o", str(folder))["files"]
    assert sorted(written) == sorted(str(p) for p in folder.rglob("*") if p.is_file())
    assert written[0] in microimpact("export", *STEEL, "-o", str(folder)).stdout


def test_export_of_several_sizes_and_another_law(microimpact, answered, tmp_path):
    sizes = ("--diameters-um", "20", "40", "-o", str(tmp_path))
    (path,) = answered("export", *STEEL, *sizes, "--format", "csv")["files"]
    text = Path(path).read_text(encoding="utf-8")
    for size in ("20", "40"):
        limit = answered("capture", *STEEL, "--diameter-um", size)["outputs"]["capture_velocity"]
        assert f"{limit:.6g} m/s at {size} um" in text
    jkr = ("--law", "jkr", "--viscous-time-ns", "0.1", "--work-of-adhesion", "0.2")
    limit = answered("capture", *STEEL, *jkr)["outputs"]["capture_velocity"]
    microimpact("export", *STEEL, *jkr, "-o", str(tmp_path))
    text = (tmp_path / "microimpact_rebound.h").read_text(encoding="utf-8")
    assert f"Capture velocity {limit:.6g} m/s" in text
    assert "law jkr, viscous_time = 1e-10" in text


@pytest.fixture
def own_data(tmp_path):
    """Rebounds of the constant loss e = 0.9 sqrt(1 - (0.8/v)^2), some captured."""
    v = [0.5 * 1.13**i for i in range(20)]
    e = [0.9 * max(1.0 - (0.8 / speed) ** 2, 0.0) ** 0.5 for speed in v]
    rows = [f"{a:.5g},{b:.4f},0.02" for a, b in zip(v, e, strict=True)]
    path = tmp_path / "own.csv"
    path.write_text("\n".join(["v (m/s),e,sigma", *rows]), encoding="utf-8")
    return path


def test_fit_prints_draws_and_writes_json(microimpact, answered, own_data, tmp_path):
    plot = tmp_path / "own.svg"
    text = microimpact("fit", str(own_data), "--plot", str(plot)).stdout
    found = answered("fit", str(own_data))
    low, high = found["v_c_interval"]
    assert low < 0.8 < high
    assert set(found["models"]) >= {"fixed loss", "Eq. 34, q free", "ring force"}
    assert f"v_c = {found['v_c']:.4g} m/s, 95 %: {low:.4g} to {high:.4g} m/s" in text
    assert "weight" in text
    drawing = plot.read_text(encoding="utf-8")
    assert drawing.startswith("<?xml")
    palette = re.findall(r'"([0-9A-F]{6})"', STYLE.read_text(encoding="utf-8"))
    colours = {f"#{word}".lower() for word in palette}
    greys = {"#d9d9d9", "#666666", "#ffffff", "#cccccc"}
    assert {*re.findall(r"#[0-9a-f]{6}", drawing)} <= colours | greys


@pytest.mark.parametrize("options", [(), ("--classes", "batch")])
def test_report_is_one_page_with_data_models_and_picture(microimpact, own_data, tmp_path, options):
    odd = tmp_path / "<b>.csv"
    head, *rows = own_data.read_text().splitlines()
    odd.write_text("\n".join([f"{head},batch", *(f"{row},one & only" for row in rows)]))
    folder = tmp_path / "deep" / "report"
    done = microimpact("fit", str(odd), "--model", "fixed loss", "--report", str(folder), *options)
    assert f"Written: {folder}" in done.stdout
    assert [path.name for path in folder.iterdir()] == ["index.html"]
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 1
    assert not re.search(r"""(?:src|href)=["'](?!#)""", page)
    assert "<b>" not in page
    told = done.stdout.splitlines()[1:-1]
    assert all(html.escape(line) in page for line in told)
    assert page.count("<tr>") == 1 + len(rows)
    assert "--report" in page
    assert ("one &amp; only" in page) == bool(options)


def test_a_file_of_a_spreadsheet_needs_one_option(microimpact, answered, own_data, tmp_path):
    table = pd.read_csv(own_data).rename(columns={"v (m/s)": "Speed [m/s]"}).assign(Nr=1)
    german = tmp_path / "german.csv"
    german.write_bytes(
        f"% Düse\n{table.to_csv(index=False, sep=';', decimal=',')}n.d.;;;".encode("latin-1")
    )
    done = microimpact("fit", str(german), "--model", "fixed loss", "--columns", "v=Speed,e=e")
    plain = microimpact("fit", str(own_data), "--model", "fixed loss")
    assert done.stdout.splitlines()[1:] == plain.stdout.splitlines()[1:]
    assert "Warning: german.csv: columns not used: 'Nr'." in done.stderr
    assert "1 of 21 rows lack a number and are skipped: line 23" in done.stderr
    require_refusal(microimpact("fit", str(german), "--columns", "Speed"), "--columns must be")


def test_errors_of_speed_and_scatter_of_size_widen_the_interval(microimpact, answered, own_data):
    alone = ("fit", str(own_data), "--model", "fixed loss")
    exact = answered(*alone)
    assert exact["speeds_and_sizes_exact"]
    assert "speeds and sizes are taken as exact." in microimpact(*alone).stdout
    options = {"--sigma-v": ("2%", "0.02"), "--size-scatter": ("5%", "free")}
    for option, values in options.items():
        for value in values:
            wide = answered(*alone, option, value)
            assert not wide["speeds_and_sizes_exact"]
            assert np.diff(wide["v_c_interval"]) > 1.2 * np.diff(exact["v_c_interval"])
    assert wide["size_scatter"] > 0.0
    text = microimpact(*alone, "--size-scatter", "free").stdout
    assert f"these scatter by {100 * wide['size_scatter']:.2g} %" in text


def test_calibrate_asks_for_all_that_is_missing(microimpact, own_data, tmp_path):
    bare = tmp_path / "bare.csv"
    pd.read_csv(own_data).drop(columns="sigma").to_csv(bare, index=False)
    done = microimpact("calibrate", str(bare), "--particle", "my-glass", "--surface", "silicon")
    require_refusal(
        done,
        "give --particle-youngs-modulus-gpa, --particle-poissons-ratio, --particle-density, "
        "--diameter-um",
    )


def test_a_sweep_is_a_table(microimpact, answered):
    done = microimpact("simulate", *STEEL, "--speed", "0.1:1.66:3", "--angle", "20:50:2")
    table = pd.read_csv(io.StringIO(done.stdout))
    assert table["speed_m_per_s"].tolist() == np.repeat(np.linspace(0.1, 1.66, 3), 2).tolist()
    one = answered("simulate", *STEEL, "--speed", "1.66", "--angle", "50")
    last = table.iloc[-1]
    assert last["coefficient_of_restitution"] == one["outputs"]["coefficient_of_restitution"]
    assert last["spin_after_rad_per_s"] == one["outputs"]["spin"]
    assert "contact_time_s" in table


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--diameter-um", "62e-6"), "diameter = 6.2e-11 m is not from 1e-09 to 0.005 m: in um?"),
        (("--diameter-um", "1e6"), "diameter = 1 m is not from"),
        (("--particle-youngs-modulus-gpa", "193e-9"), "particle: youngs_modulus = 193 Pa is not"),
        (("--surface-density", "8"), "surface: density = 8 kg/m3 is not from 10 to 30000 kg/m3"),
        (("--work-of-adhesion", "250"), "work_of_adhesion = 250 J/m2 is not from"),
        (("--friction", "20"), "friction = 20 is not from 0 to 3: in %?"),
        (("--angle", "0.785"), "angle = 0.785 degrees is not from"),
        (("--hertz-damping", "30"), "overdamped"),
        (("--speed", "1000"), "most materials yield"),
        (("--yield-strength-mpa", "205"), "above 3.28e+08 Pa, 1.6 times the yield strength"),
    ],
)
def test_doubtful_numbers_are_told(microimpact, options, words):
    speed = () if "--speed" in options else ("--speed", "1")
    done = microimpact("simulate", *STEEL, *speed, *options)
    assert done.returncode == 0
    assert words in done.stderr
    assert microimpact("simulate", *STEEL, "--speed", "1").stderr == ""


def test_long_work_is_named_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setattr(output, "PATIENCE", 0.0)
    for terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal, raising=False)
        with output.patience("fitting"):
            time.sleep(0.05)
        assert capsys.readouterr().err == ("microimpact: fitting ...\n" if terminal else "")


def test_materials_of_ones_own(microimpact, answered, tmp_path):
    own = tmp_path / "own.csv"
    rows = ("youngs_modulus,70,GPa", "poissons_ratio,0.22,-", "density,2500,kg/m3")
    lines = [f"my-glass,{row},,,assumed,mine" for row in rows]
    head = "material,property,value,unit,low,high,evidence,source"
    own.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
    contact = ("--work-of-adhesion", "0.1", "--hertz-damping", "0", "--adhesion-damping", "1")
    pair = ("--particle", "my-glass", "--surface", "silicon", "--diameter-um", "20", *contact)
    by_file = answered("capture", *pair, "--materials", str(own))
    options = ("--particle-youngs-modulus-gpa", "70", "--particle-poissons-ratio", "0.22",
               "--particle-density", "2500")  # fmt: skip
    by_option = answered("capture", *pair, *options)
    assert by_file == by_option
    assert by_file["inputs"]["particle"]["density"] == 2500.0
    assert "my-glass" in microimpact("materials", "--materials", str(own)).stdout


def test_calibrated_contacts_go_from_command_to_command(microimpact, answered, tmp_path):
    """From what the declared contact does, without noise, to contacts like it."""
    sweep = microimpact("simulate", *STEEL, "--speed", "0.1:1.66:12").stdout
    table = pd.read_csv(io.StringIO(sweep))
    data, file = tmp_path / "data.csv", tmp_path / "contacts.json"
    names = {"speed_m_per_s": "v", "coefficient_of_restitution": "e"}
    table[list(names)].rename(columns=names).assign(sigma=0.02).to_csv(data, index=False)
    found = answered("calibrate", str(data), *STEEL, "--draws", "50", "-o", str(file))
    limits = found["v_c (m/s)"]
    assert limits["low"] < 0.18 < limits["high"]
    laws = json.loads(file.read_text(encoding="utf-8"))["laws"]
    best = laws["ring force"]["best"]["hertz_damping"]
    assert found["laws"]["ring force"]["c_H"]["best"] == best  # every digit
    assert sum(law["draws"] for law in found["laws"].values()) == 50
    answer = answered("simulate", "--contact", str(file), "--speed", "1:1.5:2")
    e = answer["outputs"]["coefficient_of_restitution"]
    assert np.all(np.less_equal(e["low"], e["value"]))
    assert np.all(np.less(np.subtract(e["high"], e["low"]), 0.2))
    at_other_size = microimpact("capture", "--contact", str(file), "--diameter-um", "20")
    assert re.search(r"extrapolated to 20 um, .* by ring force", at_other_size.stderr)
    capture = answered("capture", "--contact", str(file))
    assert len(capture["outputs"]["capture_velocity"]) == 50
    one = microimpact("simulate", "--contact", str(file), "--speed", "1").stdout
    assert re.search("median +95 % +unit", one)
    folder = tmp_path / "law"
    assert "best of 50" in microimpact("export", "--contact", str(file), "-o", str(folder)).stdout
    sizes = ("--diameters-um", "62", "100", "--tolerance", "1e-3", "-o", str(folder))
    exported = microimpact("export", "--contact", str(file), *sizes)
    assert re.search(r"extrapolated to 100 um, .* by ring force", exported.stderr)
    assert "to 62 um" not in exported.stderr


def test_contacts_by_jkr_go_from_command_to_command(microimpact, answered, tmp_path):
    """The ring force's best is exported; where it has none, that is said."""
    body = Material(name="glass", youngs_modulus=7e10, poissons_ratio=0.22, density=2500.0)
    contact = Contact(
        particle=body, surface=body, diameter=30e-6, work_of_adhesion=0.2,
        law=JKR(viscous_time=np.array([3e-9, 4e-9])),
    )  # fmt: skip
    file, jkr = tmp_path / "jkr.json", "viscous JKR"
    write_contacts(file, {jkr: contact}, {jkr: contact.at(0)})
    outputs = answered("capture", "--contact", str(file))["outputs"]
    assert outputs["capture_velocity"] == pytest.approx(capture_velocity(contact))
    text = microimpact("simulate", "--contact", str(file), "--speed", "1").stdout
    assert "jkr, viscous_time = 3e-09" in text
    plain = contact.by_law(JKR(), 0.2).replace(law=None)
    write_contacts(
        file, {jkr: contact, "ring force": plain}, {jkr: contact.at(0), "ring force": plain}
    )
    done = microimpact("export", "--contact", str(file), "-o", str(tmp_path / "law"))
    assert f"the best by the {jkr} is written" in done.stderr
    header = (tmp_path / "law" / "microimpact_rebound.h").read_text(encoding="utf-8")
    assert "law jkr, viscous_time = 3e-09" in header


def test_two_numbers_calibrate_too(answered):
    targets = ("--restitution", "0.7", "--at-speed", "1.66", "--capture-velocity", "0.18")
    found = answered("calibrate", *STEEL, *targets)["laws"]["ring force"]
    assert found["c_H"]["best"] == pytest.approx(0.2148, rel=1e-3)
    assert found["c_A"]["best"] == pytest.approx(1.612, rel=1e-3)


def test_no_file_brings_a_name_that_is_code(microimpact, answered, tmp_path):
    name = "a */ int b; /*"
    own, file = tmp_path / "own.csv", tmp_path / "contacts.json"
    table = declared_file("materials.csv").read_text(encoding="utf-8")
    own.write_text(table.replace("silicon,", f"{name},"), encoding="utf-8")
    targets = ("--restitution", "0.7", "--at-speed", "1.66", "--capture-velocity", "0.18")
    answered("calibrate", *STEEL, *targets, "-o", str(file))
    file.write_text(file.read_text(encoding="utf-8").replace("silicon", name), encoding="utf-8")
    for options in ((*STEEL, "--materials", str(own)), ("--contact", str(file))):
        done = microimpact("export", *options, "-o", str(tmp_path / "law"))
        require_refusal(done, "name must be one line of printable text")
    assert not (tmp_path / "law").exists()


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"particle": {}}', "v,e"])
def test_a_wrong_file_of_contacts_is_refused(microimpact, tmp_path, content):
    file = tmp_path / "wrong.json"
    file.write_text(content, encoding="utf-8")
    done = microimpact("simulate", "--contact", str(file), "--speed", "1")
    require_refusal(done, "wrong.json must be a file that 'microimpact calibrate -o' wrote")


def test_the_reference_verifies_itself_and_names_a_mistake(microimpact, answered, tmp_path):
    written = microimpact("reference", "-o", str(tmp_path)).stdout.splitlines()
    assert [Path(line).exists() for line in written] == [True] * 3
    table = pd.read_csv(written[0])
    agreed = microimpact("verify", written[0])
    assert agreed.returncode == 0
    assert agreed.stdout.count("agrees") == table["case"].nunique()
    share = 0.49387 * (0.0422718 / table["normal_speed_m_per_s"]) ** 2
    table["restitution"] = np.sqrt(np.maximum(1.0 - share, 0.0))
    half = tmp_path / "half.csv"
    table[table["case"] == "jkr-wall"].to_csv(half, index=False)
    done = microimpact("verify", str(half))
    assert done.returncode == 1
    assert "broken at the pull-off force" in done.stdout
    assert answered("verify", str(half))["verdicts"][0]["agrees"] is False
    half.write_text("case,restitution\njkr-wall,0.5\n")
    require_refusal(microimpact("verify", str(half)), "the columns case, v, e are needed")

    half.write_text("case;v in mm/s;e (%)\njkr-wall;100,0;50\njkr-wall;200;70\n")
    assert "no known mistake" in microimpact("verify", str(half)).stdout
    half.write_text("case,v,e\njkr-wall,0.1,0.9\njkr-wall,0.2,50\njkr-wall,0.5,-1\n")
    done = microimpact("verify", str(half))
    require_refusal(done, "line 3: e must be from 0 to 2, got 50; are these percent?")
    assert "line 4: e must be from 0 to 2, got -1" in done.stderr


def test_fit_says_what_it_read_and_doubts_it(microimpact, answered, own_data, tmp_path):
    other, options = tmp_path / "other.csv", ("--model", "fixed loss", "--sigma", "0.02")
    table = pd.read_csv(own_data)[["v (m/s)", "e"]]
    (table * [100.0, 1.0]).to_csv(other, index=False, header=["v_cm_s", "e"])
    text = microimpact("fit", str(other), *options).stdout
    assert text.startswith("other.csv: 20 rows, 4 captured; v in cm/s; normal speeds 0.5 to 5.099")
    assert answered("fit", str(other), *options)["read"] == text.splitlines()[0]
    (table * [100.0, 1.0]).to_csv(other, index=False, header=["v", "e"])
    doubts = microimpact("fit", str(other), *options).stderr
    assert "normal_speed = 510 m/s is not from 0.0001 to 150 m/s: in mm/s?" in doubts
    assert "capture_velocity = 80 m/s is not from 0 to 10 m/s: in mm/s?" in doubts
    assert "in cm/s" in microimpact("fit", str(other), *options, "--unit", "cm/s").stdout


def test_a_pair_without_a_reference_velocity_is_calibrated(answered, own_data):
    """v_N follows from the data; sigma is not needed."""
    bare = own_data.with_name("bare.csv")
    pd.read_csv(own_data).drop(columns="sigma").to_csv(bare, index=False)
    found = answered("calibrate", str(bare), *FLUORESCEIN, "--draws", "20")
    assert found["v_c (m/s)"]["low"] < 0.85
    assert found["v_c (m/s)"]["high"] > 0.7
    assert found["read"].startswith("bare.csv: 20 rows")


def test_the_declared_contacts_are_in_python_as_on_the_command_line(answered):
    contact = contacts[" on ".join(STEEL[1::2])]
    inputs = answered("capture", *STEEL)["inputs"]
    assert all(getattr(contact, name) == inputs[name] for name in CALIBRATED)
    with pytest.raises(KeyError, match=r"unknown contact .*did you mean 'stainless-steel-316 on"):
        contacts["silicon on stainless-steel-316"]


def test_no_file_brings_control_characters_to_a_terminal(microimpact, tmp_path):
    file, escape = tmp_path / "contacts.json", chr(27) + "[31m"
    contact = contacts[" on ".join(STEEL[1::2])]
    draws = contact.replace(work_of_adhesion=np.array([0.6, 0.7]))
    write_contacts(file, {escape: draws, "two": draws}, {escape: contact, "two": contact})
    done = microimpact("capture", "--contact", str(file), "--diameter-um", "20")
    assert r"by \x1b[31m" in done.stderr
    assert chr(27) not in done.stdout + done.stderr
    file.write_text(file.read_text(encoding="utf-8").replace("work_of_adhesion", r"\u001b"))
    require_refusal(microimpact("capture", "--contact", str(file)), r"x1b")


def test_help_is_whole_and_in_groups(microimpact):
    assert not re.search(r"\w\.\.\.", microimpact("--help").stdout)
    for command in ("simulate", "capture", "fit", "calibrate", "export", "verify"):
        text = microimpact(command, "--help").stdout
        assert max(map(len, text.splitlines())) <= 80
        groups = re.findall(r"^(\w[\w ]*):$", text, re.MULTILINE)
        assert groups[-1] == "Options"
        assert len(groups) > 1


def test_fit_by_classes(microimpact, answered, tmp_path):
    path, rows = tmp_path / "sized.csv", ["v,e,d (um)"]
    for d, count in ((20, 8), (40, 8), (60, 2)):
        limit = 2.0 / d
        ratios = [1.05, 1.15, 1.3, 1.6, 2.0, 3.0, 5.0, 9.0][:count]
        rows += [f"{limit * x:.6f},{0.7 * (1 - x**-2) ** 0.5:.6f},{d}" for x in ratios]
    path.write_text("\n".join(rows))
    options = ("--classes", "d", "--sigma", "0.01", "--model", "fixed loss")
    found = answered("fit", str(path), *options)
    assert found["exponent"] == pytest.approx(-1.0, abs=0.01)
    assert found["classes"]["20 um"]["v_c"] == pytest.approx(0.1, rel=0.01)
    assert "points" in found["classes"]["60 um"]["not_computed"]
    assert "v_c ~ d^n: n = -1.00" in microimpact("fit", str(path), *options).stdout
    assert answered("fit", str(path), *options, "--tails", "4")["classes"]["20 um"]["tails"] == 4.0
    require_refusal(microimpact("fit", str(path), *options, "--plot", "x.svg"), "leave out --plot")


def test_heights_are_reduced_and_the_table_is_one_for_fit(microimpact, tmp_path):
    heights, rebounds = tmp_path / "heights.csv", tmp_path / "rebounds.csv"
    heights.write_text("h0 (mm),h1 (mm)\n100,25\n50,0\n10,20\n", encoding="utf-8")
    done = microimpact("reduce", str(heights), "--sigma-h", "100", "-o", str(rebounds))
    assert done.returncode == 0
    assert done.stdout.startswith("heights.csv: 2 impacts, 1 captured; 1 left out: 1 its rebound")
    table = pd.read_csv(rebounds)
    assert table["e"].tolist()[:2] == [0.5, 0.0]
    assert table["captured"].tolist()[:2] == ["no", "yes"]
    assert "faster than its impact" in table["reason"][2]
    assert microimpact("reduce", str(heights), "--sigma-h", "100").stdout == rebounds.read_text()
    refused = microimpact("reduce", str(heights), "--fps", "1000")
    require_refusal(refused, "heights.csv holds heights; leave out --fps")
