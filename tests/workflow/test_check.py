"""The check against references names the figures and tables that a small change moves."""

from __future__ import annotations

import re
import shutil

import pytest
from tests.workflow.conftest import SMALL, Project, swap

OUT = "build/ci"
# What changes are tried on: they end quickly.
FIGURES = ("fig14", "fig17", "fig20", "doppler_pairs")
TARGETS = (*FIGURES, "declared_inputs")

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@pytest.fixture(scope="module")
def checked(built, tmp_path_factory):
    """A copy of the project with references of its own, made from its small run.

    A check reads all pictures; those that are never drawn again here are left out.
    """
    project = Project(tmp_path_factory.mktemp("checked") / "copy")
    shutil.copytree(built, project.root)
    for path in (project.root / OUT / "figures").iterdir():
        if path.stem not in FIGURES:
            path.unlink()
    done = microimpact(project, "reference", OUT)
    assert done.returncode == 0, done.stderr
    return project


def microimpact(project, *arguments):
    own = {"PYTHONPATH": str(project.root / "src"), "COLUMNS": "120"}
    return project.call("study.report.commands", *arguments, **own)


def raised(found):
    return f"{found[1]}{float(found[2]) * 1.001:g}"


def stiffer_molybdenum(text):
    after, n = re.subn(r"^(molybdenum,youngs_modulus,)(\d+)", raised, text, flags=re.MULTILINE)
    assert n == 1
    return after


def test_the_rule_passes_and_fails_with_the_check(checked):
    # Of everything, what rests on the edited table would be built again.
    with checked.edited(
        "workflow/rules/report.smk", swap("wildcards: results(),", "wildcards: [],")
    ):
        assert "files agree" in checked.snakemake("check", *SMALL).text
        with checked.edited(
            f"{OUT}/tables/inputs.csv", swap("config,seed,20011", "config,seed,20012")
        ):
            done = checked.snakemake("check", *SMALL, check=False)
    assert done.returncode
    assert "Tables: inputs\nData: none\nFigures: none\n" in done.text
    log = (checked.root / OUT / "logs/check.log").read_text()
    assert "config, seed" in log


def test_each_small_change_is_seen_in_its_figures_and_tables_alone(checked):
    """Four at once, in one run and one check: no figure or table is of two of them."""
    trends, pairs = (
        f"config/analyses/{name}.yaml" for name in ("fig14_restitution_trends", "pair_search")
    )
    speed, heading = "body_speed_m_per_s: {value: 30.0,", "\npair_search:\n"
    with (
        # A number by a thousandth.
        checked.edited(trends, swap(speed, speed.replace("30.0", "30.03"))),
        # A stiffness, too: it enters what is calibrated on molybdenum, not on silicon.
        checked.edited("config/materials.csv", stiffer_molybdenum),
        checked.edited(pairs, swap(heading, f"{heading}  seed: 20012\n")),
        # A sign, of the surface of a spinning sphere: only Fig. 17 has initial spin.
        checked.edited(
            "src/microimpact/model/rigid_body/algebra.py",
            swap(
                "mu_0 = rolling_impulse_ratio(v_n, v_t - radius * omega, e)",
                "mu_0 = rolling_impulse_ratio(v_n, v_t + radius * omega, e)",
            ),
        ),
    ):
        checked.snakemake(*TARGETS, *SMALL)
        done = microimpact(checked, "check", OUT)
    assert done.returncode == 1, done.text
    tables, data, figures = (
        set(re.search(rf"^{kind}: (.*)$", done.stdout, flags=re.MULTILINE)[1].split(", "))
        for kind in ("Tables", "Data", "Figures")
    )
    doppler = {"correction_curves", "doppler_stream", "pairing_curves"}
    assert data | figures == {"fig14", "fig17", "fig20", "doppler_pairs", *doppler}
    assert "config, fig14_restitution_trends.body_speed_m_per_s" in done.stdout
    assert re.search(r"body_speed_m_per_s.*value.*30 -> 30\.03", done.stdout)
    calibrated = {"calibration", "force_ratios", "molybdenum_capture"}
    moved = {"inputs", "pairing_quality", *calibrated}
    # Few pairs may make the same rates by chance.
    others = {"surface_correction"}
    assert moved <= tables <= moved | others
