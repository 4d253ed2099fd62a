"""Figs. 18 and 21: impulse ratio and energy loss against angle, steel on silicon."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import pytest

from microimpact.model.dynamics.normal import normal_impact
from study.contacts import calibrated_contact

E = 0.70  # Section 2.4.1
F = 0.15  # Section 2.4.1: plateau of the impulse ratio
MOLYBDENUM = {"case": "fluorescein-molybdenum, nominal", "diameter_um": 4.9, "speed_m_per_s": 5.2}


@pytest.fixture(scope="module")
def study(run_study, calibration, admitted):
    """The function that runs the study with some parameters of its own."""
    bases = {0.12: "net", 0.15: "compressive", 0.18: "compressive"}
    drawn = [{"friction": f, "friction_basis": basis} for f, basis in bases.items()]
    inputs = {
        **calibration,
        "posterior_contacts": admitted("fig18_21_oblique_impact", drawn),
        **run_study("fig06_12_oblique_experiments", calibration, angles_deg=[85, 45], points=10),
    }
    return partial(run_study, "fig18_21_oblique_impact", inputs)


@pytest.fixture(scope="module")
def tables(study):
    return study()


@pytest.fixture(scope="module")
def contact(calibration, settings):
    branch = settings.branches["fig18_21_oblique_impact"]
    inputs = {**calibration, "materials": pd.DataFrame(settings.tables.materials.rows)}
    return calibrated_contact(inputs, branch["case"], diameter=branch["diameter_um"] * 1e-6)


@pytest.fixture(scope="module")
def curve(tables):
    def get(figure, panel, series):
        table = tables[figure]
        rows = table[(table["panel"] == panel) & (table["series"] == series)]
        return rows["x_deg"].to_numpy(), rows["y_1"].to_numpy()

    return get


def at(curve, angle):
    return float(np.interp(angle, *curve))


def test_rolling_is_the_same_in_both_models(curve):
    for angle in (60.0, 75.0):
        rolling = 2 / 7 / np.tan(np.radians(angle)) / (1 + E)
        assert at(curve("fig18", "adhesion", "rigid body"), angle) == pytest.approx(
            rolling, rel=1e-3
        )
        assert at(curve("fig18", "adhesion", "simulation"), angle) == pytest.approx(
            rolling, rel=0.01
        )


@pytest.mark.parametrize("basis", ["compressive", "hertz"])
def test_a_sliding_sphere_has_the_friction_of_the_impulse_that_presses(curve, contact, basis):
    """Friction acts on one impulse, the ratio counts the momentum changed: f P / (m v (1 + e))."""
    angle, ratio = curve("fig18", "basis", basis)
    speed = 1.66 * np.sin(np.radians(angle))
    normal = normal_impact(contact, speed, ledger=True)
    impulse = normal.compressive_impulse if basis == "compressive" else normal.ledger.hertz_impulse
    change = 1 + normal.coefficient_of_restitution
    sliding = F * impulse / (contact.mass * speed * change)
    rolling = 2 / 7 / np.tan(np.radians(angle)) / change
    slides = sliding < rolling
    assert angle[slides].max() > 40.0
    assert ratio == pytest.approx(np.minimum(sliding, rolling), rel=1e-9, abs=1e-12)
    # adhesion takes more of the impulse the slower the impact: the ratio rises to the end
    assert (np.diff(ratio[slides]) < 0.0).all()


def test_captured_impacts_are_not_on_the_curves(curve):
    (limit,) = curve("fig18", "adhesion", "capture")[0]
    # the assumed contact has the printed capture velocity
    assert np.sin(np.radians(limit)) * 1.66 == pytest.approx(0.18, abs=0.005)
    for figure, panel, series in (
        ("fig18", "adhesion", "simulation"),
        ("fig18", "basis", "net"),
        ("fig21", "loss", "total"),
    ):
        angle, _ = curve(figure, panel, series)
        assert limit < angle.min() < limit + 0.2
    assert curve("fig21", "loss", "capture")[0] == pytest.approx([limit])


def test_losses(curve):
    total, translational = curve("fig21", "loss", "total"), curve("fig21", "loss", "translational")
    # normal incidence without spin: both are 1 - e^2, with the printed e = 0.70
    assert total[1][-1] == pytest.approx(translational[1][-1], rel=1e-12)
    assert total[1][-1] == pytest.approx(1 - E**2, rel=0.02)
    # rotation takes up energy that the mass centre loses
    assert (translational[1] >= total[1] - 1e-12).all()
    # the two expressions of the rolling sphere differ by the rotational energy
    rotation = 0.4 * (5 / 7 * np.cos(np.radians(60.0))) ** 2
    difference = at(translational, 60.0) - at(total, 60.0)
    assert difference == pytest.approx(rotation, rel=1e-4)


def test_always_captured_leaves_empty_curves(study):
    with pytest.raises(ValueError, match="captured at every angle"):
        study(speed_m_per_s=0.1)


def test_band_of_drawn_contacts(tables, curve):
    """Where spheres slide the band has their friction, where they roll none; sizes are as drawn."""
    band = tables["fig18"].query("series == 'posterior'").set_index("x_deg")
    assert set(band["evidence"]) == {"calibrated"}
    simulation = curve("fig18", "adhesion", "simulation")
    for angle in (10.0, 30.0):
        row = band.loc[angle]
        assert row["y_1"] == pytest.approx(at(simulation, angle), rel=1e-9)
        # Of three values the quantiles lie a twentieth of the way from the outer to the middle one.
        outer = 0.12 + 0.05 * (row["y_1"] - 0.12), 1.19 * row["y_1"]
        assert (row["y_low"], row["y_high"]) == pytest.approx(outer, rel=1e-9)
    rolling = band.loc[60.0]
    assert rolling["y_low"] == pytest.approx(rolling["y_high"], rel=1e-3)
    loss = tables["fig21"].query("series == 'posterior'").set_index("x_deg")
    assert loss.loc[30.0, "y_1"] == pytest.approx(at(curve("fig21", "loss", "translational"), 30.0))


def test_the_rigid_body_has_the_restitution_of_the_pair(study):
    """At 60 deg both roll: 2 cot/(7 (1 + e)), with e of the contact, not that of steel."""
    drawn = study(points=90, **MOLYBDENUM)["fig18"]
    drawn = drawn[drawn["panel"] == "adhesion"].set_index(["series", "x_deg"])["y_1"]
    assert drawn["rigid body", 75.0] == pytest.approx(drawn["simulation", 75.0], rel=0.02)


@pytest.mark.parametrize(
    ("impact", "left"),
    [
        ({}, ["posterior", "printed plateau", "virtual experiment"]),
        ({"speed_m_per_s": 1.7}, ["posterior"]),
        ({"diameter_um": 63.0}, ["posterior"]),
        ({"friction": 0.3}, ["posterior", "printed plateau"]),
        ({"case": "steel-silicon, n = 0"}, ["posterior", "printed plateau"]),
        ({"spin_rad_per_s": 1.0e4}, ["posterior", "printed plateau"]),
        (MOLYBDENUM, []),
    ],
    ids=str,
)
def test_what_is_printed_drawn_or_measured_stands_beside_its_own_impact_alone(study, impact, left):
    tables = study(points=40, **impact)
    both = pd.concat([tables["fig18"], tables["fig21"]])
    beside = {*both["series"], *both["evidence"]}
    assert sorted(beside & {"printed plateau", "posterior", "virtual experiment"}) == left
