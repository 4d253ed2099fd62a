"""The workflow: what it builds, what it builds again, what it refuses."""

from __future__ import annotations

import json
import os
import re
import shutil
from contextlib import ExitStack

import pytest
import yaml
from tests.shared import PARTS
from tests.workflow.conftest import SMALL, Project, swap

from study.figures.declaration import all_figures

OUT = "build/ci"
TRENDS, COULOMB = "fig14_restitution_trends", "fig17_coulomb_friction"
MONTE_CARLO = "fig23_monte_carlo"

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


def commented(text):
    return text + "\n# edited\n"


def extended(text):
    return text + "\nEDITED = True\n"


def test_everything_is_built_in_its_own_results_root(built):
    project = Project(built)
    made = project.files(under=OUT)
    figures = all_figures()
    wanted = {f"figures/{name}.{end}" for name in figures for end in ("svg", "png")}
    wanted |= {"tables/inputs.csv", "data/fig14.csv", f"logs/{COULOMB}.log"}
    assert {f"{OUT}/{file}" for file in wanted} <= made
    assert not (project.root / "results").exists()
    stamp = json.loads((built / OUT / "run.json").read_text())
    assert stamp["config"]["pathvars"] == {"results": OUT}
    assert stamp["config"][COULOMB]["points"] == 36
    assert stamp["seed"] == stamp["config"]["seed"]["value"]
    assert stamp["git"] == {"commit": None, "dirty": None}
    assert stamp["packages"]["numpy"]
    assert stamp["started"] < stamp["ended"]


def row_changed(row, value):
    return lambda text: re.sub(rf"^({row},)[^,]*", rf"\g<1>{value}", text, flags=re.MULTILINE)


TRENDS_FILE, COULOMB_FILE = (f"config/analyses/{name}.yaml" for name in (TRENDS, COULOMB))
# Parts of the package that decide no number, and words beside code that does.
IDLE = [(f"src/study/run/{name}.py", extended) for name in ("config", "schema", "summary")]
IDLE += [(f"src/microimpact/{name}.py", commented) for name in ("core/files", "model/contact")]
TOLD = {"declared_inputs", "report"}
RULES_OF = {name: {name, f"{name}_figures"} for name in (COULOMB, TRENDS)}


@pytest.mark.parametrize(
    ("edits", "overlay", "expected"),
    [
        # A value: its study, what is drawn from it, and the table of inputs. One number written
        # otherwise, and code that decides no number: nothing.
        (
            [
                (
                    TRENDS_FILE,
                    swap("adhesion_exponent: {value: 1.0", "adhesion_exponent: {value: 1.1"),
                ),
                (
                    TRENDS_FILE,
                    swap("body_speed_m_per_s: {value: 30.0", "body_speed_m_per_s: {value: 30"),
                ),
                *IDLE,
            ],
            {},
            {*RULES_OF[TRENDS], *TOLD},
        ),
        # What draws: figures of one analysis. A parameter in the words of a figure redraws it.
        (
            [(f"src/study/analyses/{TRENDS}/draw.py", swap('"Coefficient"', '"Value"'))],
            {"fig17_coulomb_friction": {"spin_friction": 0.3}},
            {*RULES_OF[COULOMB], f"{TRENDS}_figures", *TOLD},
        ),
        # Words of provenance: the table of inputs, and the report that shows it.
        ([(TRENDS_FILE, swap("schematic: R level at low speed", "schematic"))], {}, TOLD),
    ],
)
def test_changes_rerun_their_chains_and_nothing_else(project, tmp_path, edits, overlay, expected):
    path = tmp_path / "overlay.yaml"
    path.write_text(yaml.safe_dump(overlay))
    with ExitStack() as context:
        for file, edit in edits:
            context.enter_context(project.edited(file, edit))
        assert project.planned(*SMALL, str(path)) == expected


@pytest.mark.parametrize(
    ("path", "edit", "reruns", "spares"),
    [
        (
            "src/microimpact/model/rigid_body/algebra.py",
            extended,
            RULES_OF[COULOMB],
            {f"{TRENDS}_figures", "declared_inputs"},
        ),
        (
            "config/contacts.csv",
            row_changed("stainless-steel-316,silicon,work_of_adhesion", "0.71"),
            {
                "calibration",
                "contact_properties",
                "fig18_21_oblique_impact",
                "fig18_21_oblique_impact_figures",
            },
            {*RULES_OF[COULOMB], "roughness_expansions"},
        ),
        (
            "config/printed_values.csv",
            row_changed("impulse_ratio_normal_incidence_no_spin", "0.01"),
            RULES_OF[COULOMB],
            {"fig18_21_oblique_impact", "fig20_force_history", "contact_properties"},
        ),
    ],
)
def test_an_edit_reruns_what_it_can_affect(project, path, edit, reruns, spares):
    with project.edited(path, edit):
        planned = project.planned(*SMALL)
    assert reruns <= planned
    assert ("declared_inputs" in planned) == path.startswith("config")
    assert not ((spares | {TRENDS}) & planned)


def test_the_number_of_parts_changes_no_byte(built, tmp_path):
    project = Project(tmp_path / "copy")
    shutil.copytree(built, project.root)
    names = ("data/fig23.csv", "tables/monte_carlo.csv")
    before = [(project.root / OUT / name).read_bytes() for name in names]
    parts = ("--set-scatter", f"{MONTE_CARLO}=3", "--forcerun", MONTE_CARLO)
    text = project.snakemake(MONTE_CARLO, *SMALL, *parts, "--verbose").text
    assert re.search(rf"^{MONTE_CARLO}_part +3$", text, flags=re.MULTILINE)
    assert [(project.root / OUT / name).read_bytes() for name in names] == before
    assert not list((project.root / OUT / "parts").glob("*"))


def test_bad_input_is_one_line_a_problem_and_writes_nothing(project, tmp_path):
    path = tmp_path / "overlay.yaml"
    overlay = {"seed": "x", "coulomb_frction": {}, "fig17_coulomb_friction": {"spin_fricton": 1}}
    path.write_text(yaml.safe_dump({**overlay, "pathvars": {"results": "build/refused"}}))
    # Nested values on the command line always arrive as text.
    nested = "fig17_coulomb_friction={points: x, spin_friction: 0.3}"
    done = project.snakemake("--configfile", str(path), "--config", nested, check=False)
    assert done.returncode
    for line in (
        "\nseed: 'x' must be a valid integer\n",
        "\ncoulomb_frction: unknown key (did you mean 'fig17_coulomb_friction'?)\n",
        "\nfig17_coulomb_friction.spin_fricton: unknown key (did you mean 'spin_friction'?)\n",
        "\nfig17_coulomb_friction.points: 'x' must be a valid integer\n",
        "\nfig17_coulomb_friction.spin_friction: '0.3' must be a valid number (it is text: ",
    ):
        assert line in done.text
    assert "--configfile" in done.text
    assert "Traceback" not in done.text
    assert not (project.root / "build/refused").exists()


def test_an_unknown_target_is_told_with_the_nearest_name(project):
    done = project.snakemake("sobl", check=False)
    assert done.returncode
    told = done.text.strip().splitlines()[-1]
    assert told.startswith("sobl: no figure, rule or file of the study")
    assert "did you mean 'sobol'?" in told


def test_an_analysis_that_cannot_be_imported_is_named(project):
    file = "src/study/analyses/fig17_coulomb_friction/compute.py"
    wrong = "from numpy import nothing_such\nimport numpy as np\n"
    with project.edited(file, lambda text: text.replace("import numpy as np\n", wrong, 1)):
        told = project.snakemake("fig17", check=False).text
    assert f"{file}, line " in told
    assert "cannot import name 'nothing_such'" in told
    assert "Traceback" not in told


def test_a_failing_study_of_the_copy_is_named_and_leaves_no_table(project):
    """The copy runs its own code, not that of the checkout the package is installed from."""
    path = "src/study/analyses/fig14_restitution_trends/compute.py"
    broken = "\n\ndef run(params, inputs):\n    raise TypeError('speed out of reach')\n"
    root = ("--config", "pathvars={results: build/broken}")
    with project.edited(path, lambda text: text + broken):
        done = project.snakemake("fig14", *root, check=False)
    assert done.returncode
    assert f"{TRENDS}: speed out of reach" in done.text
    assert not (project.root / "build/broken/data").is_dir() or not project.files(
        under="build/broken/data"
    )
    assert json.loads((project.root / "build/broken/run.json").read_text())["ended"] is None
    log = project.root / "build/broken/logs" / f"{TRENDS}.log"
    # No error of the program passes for a result that cannot be computed.
    assert log.read_text().startswith("Traceback")
    assert "speed out of reach" in log.read_text()


def test_the_account_on_the_terminal_is_brief_and_the_full_one_stands_in_a_file(project):
    root = ("--config", "pathvars={results: build/brief}")
    said = project.snakemake("fig14", "declared_inputs", *root).text.splitlines()
    assert {line.split("  ")[0] for line in said if "  " in line} == {
        "declared_inputs",
        TRENDS,
        "figures",
    }
    assert "  3 of 3" in said[-2]
    assert said[-1] == ("In build/brief: data/fig14.csv, tables/inputs.csv, figures/fig14.svg.")
    assert len(said) <= 6
    logs = sorted((project.root / ".snakemake/log").glob("*.log"))
    assert f"rule {TRENDS}:" in logs[-1].read_text()
    stamp = json.loads((project.root / "build/brief/run.json").read_text())
    assert stamp["ended"] is not None
    assert (project.root / "build/brief/tables/inputs.csv").is_file()


def test_versions_decide_results(project, tmp_path):
    """After an upgrade nothing old is shown beside the new version."""
    path = tmp_path / "numpy-9.9.9.dist-info"
    path.mkdir()
    (path / "METADATA").write_text("Metadata-Version: 2.1\nName: numpy\nVersion: 9.9.9\n")
    again = project.planned("fig17", *SMALL, PYTHONPATH=str(tmp_path))
    assert again == {"declared_inputs", COULOMB, f"{COULOMB}_figures"}


def test_results_deleted_by_hand_are_made_again_by_the_same_command(project):
    for name in ("data/fig17.csv", "figures/fig17.svg"):
        file = project.root / OUT / name
        before = file.read_bytes()
        file.unlink()
        project.snakemake("fig17", *SMALL)
        assert file.read_bytes() == before


def test_what_snakemake_itself_refuses_is_one_line(project):
    for arguments, told in (
        (("--configfile", "config/ci.yaml", "fig20"), "fig20: no such file (targets stand before"),
        (
            ("fig20", "--config", "fig20_force_history.diameter_um=3"),
            "must start with a valid identifier",
        ),
    ):
        said = project.snakemake(*arguments, check=False).text.strip().splitlines()
        assert told in said[-1]
        assert len(said) <= 2


def test_an_overlay_that_changes_inputs_does_not_write_among_the_shipped_results(project, tmp_path):
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text("fig17_coulomb_friction: {spin_friction: 0.3}\n")
    told = project.snakemake("fig17", "--configfile", str(overlay), check=False).text
    assert "overlay changes fig17_coulomb_friction.spin_friction, so its results need a" in told
    assert not (project.root / "results").exists()


def test_figures_are_drawn_in_the_formats_of_an_overlay_and_none_stays_behind(project, tmp_path):
    overlay, figures = tmp_path / "overlay.yaml", project.root / "build/print/figures"
    run = ("fig17", *SMALL, str(overlay), "--config", "pathvars={results: build/print}")
    overlay.write_text("figures: {formats: [png]}\n")
    project.snakemake(*run)
    for name in ("fig14.svg", "mine.png"):
        (figures / name).touch()
    overlay.write_text("figures: {formats: [pdf], leave_out: [fig14]}\n")
    project.snakemake(*run)
    drawn = {f"fig17.{kind}" for kind in ("csv", "pdf", "svg")}
    assert {path.name for path in figures.iterdir()} == {*drawn, "mine.png"}
    told = project.snakemake("fig14", *run[1:], check=False).text
    assert "fig14: left out by figures.leave_out\n" in told


def test_one_target_with_other_inputs_leaves_nothing_that_tells_the_old_ones(project):
    """The analysis of Fig. 14 has changed, too; it is not made again, and no report shows it."""
    out = project.root / OUT
    friction, speed = (
        "spin_friction: {from: frictions.steel on silicon}",
        "body_speed_m_per_s: {value: ",
    )
    with (
        project.edited(COULOMB_FILE, swap(friction, "spin_friction: 0.3")),
        project.edited(TRENDS_FILE, swap(speed, f"{speed}1")),
    ):
        project.snakemake("fig17", *SMALL)
        stamp = json.loads((out / "run.json").read_text())
        assert stamp["config"][TRENDS]["body_speed_m_per_s"]["value"] == 130.0
        assert (
            "fig14_restitution_trends.body_speed_m_per_s,130,"
            in (out / "tables/inputs.csv").read_text()
        )
        assert not (out / "report/run.html").exists()
        # Made by the run itself; its rule need not run again.
        assert COULOMB not in project.planned("fig17", *SMALL)
    project.snakemake(*SMALL)
    assert (out / "report/run.html").exists()
    # A second call does nothing, whatever the dates.
    for part in PARTS:
        path = project.root / part
        for file in [path, *path.rglob("*")]:
            os.utime(file)
    said = project.snakemake(*SMALL).text.splitlines()
    assert "Everything is up to date." in said
    assert said[-1] == f"Open {OUT}/report/index.html"
    assert len(said) <= 7
