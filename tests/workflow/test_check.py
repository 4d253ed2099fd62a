"""The check against references names the figures and tables that a small change moves."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from tests.workflow.conftest import ROOT, SMALL, Project

OUT = "build/ci"
# What changes are tried on: they end quickly.
LIGHT = ("fig14", "fig17", "fig20", "declared_inputs")

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@pytest.fixture(scope="module")
def referenced(built, tmp_path_factory):
    """A project with references of its own, made from a small run; nobody edits it."""
    project = Project(tmp_path_factory.mktemp("referenced") / "copy")
    shutil.copytree(built, project.root)
    done = microimpact(project, "reference", OUT)
    assert done.returncode == 0, done.stderr
    return project


@pytest.fixture
def checked(referenced, forked, tmp_path):
    """A copy of the project with references, as built: no test finds what another left."""
    project = Project(tmp_path / "copy", forked)
    shutil.copytree(referenced.root, project.root)
    return project


def microimpact(project, *arguments):
    own = {"PYTHONPATH": str(project.root / "src"), "COLUMNS": "120"}
    return project.call("microimpact.cli", *arguments, **own)


def named(project, targets=LIGHT):
    """Build again, check, and return which figures and which tables are named."""
    project.snakemake(*targets, *SMALL)
    done = microimpact(project, "check", OUT)
    assert done.returncode == 1, done.stdout + done.stderr
    (figures,) = re.findall(r"^Figures: (.*)$", done.stdout, flags=re.MULTILINE)
    (tables,) = re.findall(r"^Tables: (.*)$", done.stdout, flags=re.MULTILINE)
    project.told = done.stdout
    return figures.split(", "), tables.split(", ")


def swap(old, new):
    def edit(text):
        assert text.count(old) == 1, f"{old!r} must occur once"
        return text.replace(old, new)

    return edit


def test_an_unchanged_run_agrees(checked):
    assert checked.planned(*SMALL) == set()
    done = microimpact(checked, "check", OUT)
    assert done.returncode == 0, done.stdout


def test_one_number_changed_by_a_thousandth(checked):
    old = "body_speed_m_per_s: {value: 30.0,"
    with checked.edited("config/analyses/models.yaml", swap(old, old.replace("30.0", "30.03"))):
        assert named(checked) == (["fig14"], ["inputs"])
    assert "config, restitution_trends.body_speed_m_per_s" in checked.told
    assert re.search(r"\| value +\| 30 +\| 30\.03 +\| 1\.0e-03 +\|", checked.told)


def test_one_property_of_one_material_changed_by_a_thousandth(checked):
    def edit(text):
        after, n = re.subn(r"^(molybdenum,youngs_modulus,)(\d+)", raised, text, flags=re.MULTILINE)
        assert n == 1
        return after

    def raised(found):
        return f"{found[1]}{float(found[2]) * 1.001:g}"

    # The stiffness of molybdenum enters what is calibrated and admitted on it, not on silicon.
    with checked.edited("config/materials.csv", edit):
        figures, tables = named(checked, (*LIGHT, "ridge"))
    assert figures == ["admissible_bands", "fig20"]
    calibrated = {"calibration", "force_ratios", "inputs", "molybdenum_capture"}
    admitted = {"contacts", "diagnostics", "statements", "summary"}
    assert set(tables) == calibrated | {f"admissible_{table}" for table in admitted}


def test_one_sign_of_one_equation_is_seen_in_its_figure_alone(checked):
    """Two equations at once, in one run: each is that of one figure."""
    with (
        # Slip of the surface of a spinning sphere: only Fig. 17 has initial spin.
        checked.edited(
            "src/microimpact/model/rigid_body/algebra.py",
            swap(
                "mu_0 = rolling_impulse_ratio(v_n, v_t - radius * omega, e)",
                "mu_0 = rolling_impulse_ratio(v_n, v_t + radius * omega, e)",
            ),
        ),
        # Speed in excess of the capture velocity.
        checked.edited(
            "src/microimpact/model/empirical/equations.py",
            swap(
                "_share(scale, np.maximum(speed - capture, 0.0), exponent)",
                "_share(scale, np.maximum(speed + capture, 0.0), exponent)",
            ),
        ),
    ):
        assert named(checked) == (["fig14", "fig17"], ["none"])


def test_one_seed(checked):
    heading = "\npair_search:\n"
    with checked.edited(
        "config/analyses/experiments.yaml", swap(heading, f"{heading}  seed: 20012\n")
    ):
        figures, tables = named(checked, ("doppler_pairs", "declared_inputs"))
    assert figures == ["doppler_pairs"]
    assert {"inputs", "pairing_quality"} <= set(tables)
    assert not {"calibration", "force_ratios", "molybdenum_capture"} & set(tables)


def test_the_rule_rests_on_everything_and_is_not_part_of_all(checked):
    assert {"oblique_impact_figures", "check"} <= checked.planned(
        "check", *SMALL, "--forcerun", "oblique_impact_figures"
    )
    assert "check" not in checked.planned(*SMALL)


def test_the_rule_fails_with_the_check(checked):
    # Of everything, what rests on the edited table would be built again.
    with checked.edited(
        "workflow/rules/report.smk", swap("wildcards: everything()", "wildcards: []")
    ):
        assert "files agree" in checked.snakemake("check", *SMALL).text
        with checked.edited(
            f"{OUT}/tables/inputs.csv", swap("config,seed,20011", "config,seed,20012")
        ):
            done = checked.snakemake("check", *SMALL, check=False)
    assert done.returncode
    assert "Figures: none\nTables: inputs\n" in done.text
    log = (checked.root / OUT / "logs/check.log").read_text()
    assert "config, seed" in log


def test_make_offers_check_and_reference():
    for arguments, expected in (
        (["check", "RESULTS=build/x"], "microimpact check build/x\n"),
        (["reference", "RESULTS=build/x"], "microimpact reference build/x"),
        (["check"], "rm -rf build/ci\n"),
    ):
        done = subprocess.run(
            ["make", "--dry-run", *arguments], cwd=ROOT, capture_output=True, text=True, check=True
        )
        assert expected in done.stdout
