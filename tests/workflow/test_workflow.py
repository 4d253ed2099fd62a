"""The workflow: what it builds, what it builds again, what it refuses."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
from contextlib import ExitStack

import pytest
import yaml
from tests.workflow.conftest import Project

SMALL = ("--configfile", "config/ci.yaml")
OUT = "build/ci"

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


def commented(text):
    return text + "\n# edited\n"


def figures(project):
    return set(yaml.safe_load((project.root / "config/figures.yaml").read_text()))


def test_everything_is_built_in_its_own_results_root(project):
    built = project.files(under=OUT)
    for name in figures(project):
        for file in (f"figures/{name}.svg", f"figures/{name}.png", f"logs/{name}.log"):
            assert f"{OUT}/{file}" in built
    assert f"{OUT}/tables/inputs.csv" in built
    assert f"{OUT}/data/fig14.csv" in built
    assert not (project.root / "results").exists()
    assert not [name for name in built if "/." in name]


def test_a_second_call_does_nothing_whatever_the_dates(project):
    for part in ("Snakefile", "config", "profiles", "src", "workflow"):
        path = project.root / part
        for file in [path, *path.rglob("*")]:
            os.utime(file)
    assert "Nothing to be done" in project.snakemake(*SMALL).text


def test_every_table_has_a_reader(project):
    """A rule, a page of its own, or the page of a figure that says what it holds."""
    record = json.loads((project.root / "build/ci/report/record.json").read_text())
    made = {file for rule in record["rules"] for file in rule["outputs"] if "tables/" in file}
    read = {file for rule in record["rules"] for file in rule["inputs"]}
    beside = {
        f"tables/{name}.csv": words
        for figure in record["figures"].values()
        for name, words in figure.get("tables", {}).items()
    }
    assert made - read - set(beside) == {
        f"tables/{page}.csv" for page in ("claims", "equations", "inputs")
    }
    assert set(beside) <= made


def test_the_run_stamp(project):
    stamp = json.loads((project.root / OUT / "run.json").read_text())
    assert stamp["config"]["pathvars"] == {"results": OUT}
    assert stamp["config"]["coulomb_friction"]["points"] == 36
    assert stamp["seed"] == stamp["config"]["seed"]["value"]
    assert stamp["git"] == {"commit": None, "dirty": None}
    assert stamp["python"] == platform.python_version()
    assert stamp["packages"]["numpy"]
    assert all(stamp[key].endswith("+00:00") for key in ("started", "ended"))
    assert stamp["started"] < stamp["ended"]


@pytest.mark.parametrize(
    ("path", "reruns", "spares"),
    [
        (
            "src/microimpact/figures/models/restitution.py",
            {"fig14"},
            {"fig17", "restitution_trends"},
        ),
        (
            "src/microimpact/model/rigid_body/algebra.py",
            {"coulomb_friction", "fig17"},
            {"restitution_trends", "fig14", "declared_inputs"},
        ),
        (
            "src/microimpact/model/empirical/equations.py",
            {"restitution_trends", "fig14"},
            {"coulomb_friction", "fig17", "declared_inputs"},
        ),
        (
            "src/microimpact/figures/microimpact.mplstyle",
            {"fig14", "fig17"},
            {"restitution_trends", "coulomb_friction", "declared_inputs"},
        ),
        (
            "workflow/scripts/draw_figure.py",
            {"fig14", "fig17"},
            {"restitution_trends", "coulomb_friction", "declared_inputs"},
        ),
        (
            "src/microimpact/core/tables.py",
            {"restitution_trends", "coulomb_friction", "declared_inputs", "fig14", "fig17"},
            set(),
        ),
    ],
)
def test_an_edit_reruns_what_it_can_affect(project, path, reruns, spares):
    with project.edited(path, commented):
        planned = project.planned(*SMALL)
    assert reruns <= planned
    assert not spares & planned


def test_code_that_decides_no_number_reruns_nothing(project):
    with ExitStack() as edits:
        for name in ("cli.py", "config.py", "schema.py", "summary.py", "closure.py"):
            if (project.root / "src/microimpact" / name).exists():
                edits.enter_context(project.edited(f"src/microimpact/{name}", commented))
        assert project.planned(*SMALL) == set()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        # a value: its study, what is drawn from it, and the table of inputs
        (
            "adhesion_exponent: {value: 1.0,",
            "adhesion_exponent: {value: 1.1,",
            {"restitution_trends", "fig14", "declared_inputs", "report"},
        ),
        # words of provenance: the table of inputs, and the report that shows it
        ("schematic: R level at low speed", "schematic", {"declared_inputs", "report"}),
        # one number written otherwise: nothing
        ("body_speed_m_per_s: {value: 30.0,", "body_speed_m_per_s: {value: 30,", set()),
    ],
)
def test_a_change_of_configuration_reruns_its_chain(project, old, new, expected):
    with project.edited("config/analyses/models.yaml", lambda text: text.replace(old, new)):
        assert project.planned(*SMALL) == expected


@pytest.mark.parametrize(
    ("path", "row", "value", "reruns", "spares"),
    [
        (
            "config/materials.csv",
            "molybdenum,density",
            "10000",
            {"force_history", "fig20"},
            {"oblique_impact", "fig18", "fig21"},
        ),
        (
            "config/materials.csv",
            "silicon,youngs_modulus",
            "150",
            {"oblique_impact", "fig18", "fig21"},
            {"force_history", "fig20"},
        ),
        (
            "config/contacts.csv",
            "stainless-steel-316,silicon,friction",
            "0.2",
            {"oblique_impact", "fig18", "fig21"},
            {"force_history", "fig20"},
        ),
        (
            "config/printed_values.csv",
            "impulse_ratio_normal_incidence_no_spin",
            "0.01",
            {"coulomb_friction", "fig17"},
            {"oblique_impact", "force_history", "contact_properties"},
        ),
    ],
)
def test_a_declared_row_reruns_the_analyses_that_name_it(project, path, row, value, reruns, spares):
    def edit(text):
        return re.sub(rf"^({row},)[^,]*", rf"\g<1>{value}", text, flags=re.MULTILINE)

    with project.edited(path, edit):
        planned = project.planned(*SMALL)
    assert reruns | {"declared_inputs"} <= planned
    assert not (spares | {"restitution_trends"}) & planned


def test_a_change_of_the_registry_redraws_one_figure(project):
    with project.edited("config/figures.yaml", lambda t: t.replace("Coefficient\n", "Value\n", 1)):
        assert project.planned(*SMALL) == {"fig14", "report"}


def test_a_parameter_in_the_words_of_a_figure_redraws_it(project, tmp_path):
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text("coulomb_friction: {spin_friction: 0.3}\n")
    planned = project.planned("--configfile", "config/ci.yaml", str(overlay))
    assert planned == {"coulomb_friction", "fig17", "declared_inputs", "report"}


def test_one_figure_has_a_target_of_its_own(project):
    planned = project.planned("fig14", "--config", "pathvars={results: build/other}")
    assert planned == {"restitution_trends", "fig14"}


def test_the_number_of_parts_changes_no_byte(built, forked, tmp_path):
    project = Project(tmp_path / "copy", forked)
    shutil.copytree(built, project.root)
    names = ("data/coverage_by_angle.csv", "tables/interval_coverage.csv")
    before = [(project.root / OUT / name).read_bytes() for name in names]
    parts = tmp_path / "parts.yaml"
    parts.write_text("chunks: 3\n")
    text = project.snakemake("interval_coverage", *SMALL, str(parts)).text
    assert re.search(r"^interval_coverage_part +3$", text, flags=re.MULTILINE)
    assert [(project.root / OUT / name).read_bytes() for name in names] == before
    assert not list((project.root / OUT / "chunks").glob("*"))


def test_every_example_is_valid(project):
    for path in sorted((project.root / "config/examples").glob("*.yaml")):
        assert project.planned("--configfile", str(path))


@pytest.mark.parametrize(
    ("overlay", "expected"),
    [
        (
            {"coulomb_frction": {}, "coulomb_friction": {"spin_fricton": 1}, "seed": "x"},
            [
                "\ncoulomb_frction: unknown key (did you mean 'coulomb_friction'?)\n",
                "\ncoulomb_friction.spin_fricton: unknown key (did you mean 'spin_friction'?)\n",
                "\nseed: 'x' must be a valid integer\n",
            ],
        ),
        ({"materials": "config/contacts.csv"}, ["config/contacts.csv: the header is"]),
        ({"contacts": "config/nothing.csv"}, ["config/nothing.csv"]),
        (
            {"oblique_impact": {"surface": "silicn"}},
            ["no rows for 'silicn' (did you mean 'silicon'?)"],
        ),
    ],
)
def test_bad_input_is_one_line_a_problem_and_writes_nothing(project, tmp_path, overlay, expected):
    path = tmp_path / "overlay.yaml"
    path.write_text(yaml.safe_dump({**overlay, "pathvars": {"results": "build/refused"}}))
    done = project.snakemake("--configfile", str(path), check=False)
    assert done.returncode
    for line in expected:
        assert line in done.text
    assert "Traceback" not in done.text
    assert not (project.root / "build/refused").exists()


def test_a_wrong_unit_is_one_clear_error_and_writes_nothing(project):
    root = ("--config", "pathvars={results: build/refused}")
    with project.edited("config/materials.csv", lambda text: text.replace("193,GPa", "193,GN")):
        done = project.snakemake(*root, check=False)
    assert done.returncode
    assert "youngs_modulus: unit 'GN' must be one of" in done.text
    assert not (project.root / "build/refused").exists()


def test_a_nested_number_on_the_command_line_is_explained(project):
    argument = "coulomb_friction={spin_friction: 0.3}"
    done = project.snakemake("--dry-run", "--config", argument, check=False)
    assert done.returncode
    assert "coulomb_friction.spin_friction: '0.3' must be a valid number" in done.text
    assert "--configfile" in done.text


def test_a_failing_study_of_the_copy_is_named_and_leaves_no_table(project):
    """The copy runs its own code, not that of the checkout the package is installed from."""
    path = "src/microimpact/studies/models/restitution_trends.py"
    broken = "\n\ndef run(params, inputs):\n    raise ValueError('speed out of reach')\n"
    root = ("--config", "pathvars={results: build/broken}")
    with project.edited(path, lambda text: text + broken):
        done = project.snakemake("fig14", *root, check=False)
    assert done.returncode
    assert "restitution_trends: speed out of reach" in done.text
    assert not (project.root / "build/broken/data").is_dir() or not project.files(
        under="build/broken/data"
    )
    log = project.root / "build/broken/logs/restitution_trends.log"
    assert "speed out of reach" in log.read_text()
