"""The probe as a rival of adhesion, and two capture velocities, against what is printed."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from microimpact.core.constants import gravity
from study.analyses.rival_explanations.compute import uncorrected, weighed

HEIGHT = 1e-3


@pytest.fixture(scope="module")
def inputs(run_study, calibration, made):
    speeds = [0.13, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0]
    known = {**calibration, "evidence_summary": made("inference")["evidence_summary"]}
    piles = run_study(
        "pile_up", known, spheres=300, radii_mm=[5.0], slopes_deg=[2.0], speeds_m_per_s=speeds
    )
    return {**calibration, **piles}


@pytest.fixture(scope="module")
def tables(run_study, inputs):
    return run_study("rival_explanations", inputs)


@pytest.mark.parametrize(
    ("speed", "restitution"), [(1.66, 0.697), (0.75, 0.687), (0.45, 0.66), (0.30, 0.59)]
)
def test_a_probe_without_correction_sees_restitution_fall(speed, restitution):
    _, seen = uncorrected(speed, 0.70, HEIGHT)
    assert seen == pytest.approx(restitution, abs=0.005)


def test_slower_rebounds_do_not_reach_the_probe():
    limit = np.sqrt(2.0 * gravity * HEIGHT) / 0.70
    assert limit == pytest.approx(0.200, abs=5e-4)
    _, seen = uncorrected(limit * np.array([0.999, 1.001]), 0.70, HEIGHT)
    assert np.isnan(seen[0])
    assert seen[1] > 0.0


def test_at_the_surface_the_probe_sees_what_is_there():
    before, seen = uncorrected(np.array([0.2, 1.0]), 0.7, 0.0)
    assert before == pytest.approx([0.2, 1.0])
    assert seen == pytest.approx(0.7)


def test_energies_at_capture_are_those_by_hand(tables):
    table = tables["capture_evidence"].set_index("line")
    energy = table[table.index.str.startswith("kinetic energy")].iloc[0]
    # m v_c^2/2 over the loss of JKR goes with the square of v_c
    ratio = energy["at_printed_capture_velocity"] / energy["at_lower_capture_velocity"]
    assert ratio == pytest.approx((0.18 / 0.02) ** 2)
    assert energy["at_printed_capture_velocity"] > 50 * energy["seen_high"]
    assert energy["at_lower_capture_velocity"] < energy["seen_high"]


def test_no_line_prefers_the_printed_capture_velocity(tables):
    assert not tables["capture_evidence"]["prefers"].str.contains("printed").any()


def test_other_forces_by_hand(tables):
    table = tables["rival_forces"].set_index("force")["value"]
    # Of a sphere of 1 m: kinetic energy, and that of the image, pi sigma^2/epsilon_0.
    image = np.pi * (1e-6 * table["image charge"]) ** 2 / 8.854e-12
    kinetic = 4 * np.pi / 3 * 8000 * 0.18**2 / 2
    assert 0.7**2 * (kinetic + image) == pytest.approx(image, rel=2e-2)
    # In air it would be a hundredth.
    assert table["drag of the air"] < 1e-5
    assert table["capillary bridges"] < 0.3
    assert 0.01 < table["roughness of the sphere"] < 0.5


@pytest.mark.parametrize(
    ("at", "preferred"),
    [([0.25, 0.4], "printed"), ([0.4, 0.25], "lower"), ([0.25, 0.28], "printed and lower")],
)
def test_the_number_nearest_to_what_is_seen_is_preferred(at, preferred):
    numbers = pd.Series(at, index=["printed", "lower"])
    assert weighed("l", "m/s", numbers, (0.2, 0.3))["prefers"] == preferred
