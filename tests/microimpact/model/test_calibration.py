"""Parameters estimated from impacts: the two-stage method and its kin."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact import capture_velocity, simulate
from microimpact.model.calibration import (
    NoSolutionError,
    adhesion_damping_for,
    damping_factor_for,
    dissipation_ratio_for,
    hertz_damping_for,
    hertz_damping_for_adhesion_ratio,
    law_for,
    peak_ratios,
    two_stage,
    work_of_adhesion_for,
)

HIGH, E, CAPTURE = 1.66, 0.70, 0.18


@pytest.fixture
def bare(contact):
    """Steel on silicon of 62 um, without damping, normalised at the high speed."""
    return contact.replace(
        diameter=62e-6, hertz_damping=0.0, adhesion_damping=0.0, reference_velocity=HIGH
    )


@pytest.mark.parametrize(("exponent", "work"), [(0.0, 4.0), (0.5, 2.0), (1.0, 0.7), (1.0, 0.1)])
def test_two_stages_meet_both_targets(bare, exponent, work):
    wanted = bare.replace(adhesion_rate_exponent=exponent, work_of_adhesion=work)
    found = two_stage(wanted, HIGH, E, CAPTURE).contact
    assert simulate(found, HIGH).coefficient_of_restitution == pytest.approx(E, abs=1e-8)
    assert capture_velocity(found) == pytest.approx(CAPTURE, rel=1e-9)
    assert found.hertz_damping >= 0.0
    assert found.adhesion_damping >= 0.0
    assert found.adhesion_rate_exponent == exponent


def test_they_recover_the_parameters_of_a_known_contact(bare):
    known = bare.replace(work_of_adhesion=2.0, hertz_damping=0.05, adhesion_damping=1.5)
    e, limit = simulate(known, HIGH).coefficient_of_restitution, capture_velocity(known)
    found = two_stage(known, HIGH, float(e), float(limit)).contact
    assert found.hertz_damping == pytest.approx(0.05, rel=1e-6)
    assert found.adhesion_damping == pytest.approx(1.5, rel=1e-6)


def test_the_first_turn_is_not_the_answer(bare):
    # Stage one alone leaves adhesion out, so stage two spoils its target: hence the iteration.
    wanted = bare.replace(work_of_adhesion=4.0)
    once = adhesion_damping_for(hertz_damping_for(wanted, HIGH, E), CAPTURE)
    assert simulate(once, HIGH).coefficient_of_restitution < E - 0.01
    assert two_stage(wanted, HIGH, E, CAPTURE).turns > 2


def test_a_small_work_of_adhesion_cannot_capture_at_the_printed_speed(bare):
    # What adhesion must dissipate to capture at 0.18 m/s brings e at 1.66 m/s far below 0.70.
    with pytest.raises(
        NoSolutionError,
        match=r"alone lowers e at .* raise the work of adhesion or the rate exponent",
    ):
        two_stage(bare.replace(work_of_adhesion=0.2), HIGH, E, CAPTURE)


def test_material_damping_alone_may_capture_too_much(bare):
    with pytest.raises(NoSolutionError, match="without adhesion damping"):
        two_stage(bare.replace(work_of_adhesion=50.0), HIGH, 0.3, CAPTURE)


def test_arrays_are_calibrated_each_by_itself(bare):
    sizes, limits = np.array([[60e-6], [62e-6]]), np.array([0.17, 0.175, 0.18])
    family = bare.replace(diameter=sizes, work_of_adhesion=3.8)
    found = two_stage(family, HIGH, E, limits).contact
    assert found.shape == (2, 3)
    np.testing.assert_allclose(capture_velocity(found), np.tile(limits, (2, 1)), rtol=1e-9)
    alone = two_stage(bare.replace(diameter=62e-6, work_of_adhesion=3.8), HIGH, E, 0.17).contact
    assert found.hertz_damping[1, 0] == alone.hertz_damping
    assert found.adhesion_damping[1, 0] == alone.adhesion_damping
    with pytest.raises(NoSolutionError, match=r"raise the work of adhesion .*; at index \(1,\)"):
        two_stage(bare.replace(work_of_adhesion=[3.5, 0.2]), HIGH, E, CAPTURE)
    with pytest.raises(ValueError, match=r"below high_speed 1.66, got 2"):
        two_stage(family, HIGH, E, [0.1, 2.0])
    with pytest.raises(ValueError, match="shape"):
        two_stage(bare.replace(diameter=[5e-5, 6e-5]), HIGH, E, [0.1, 0.1, 0.1])


def test_work_of_adhesion_for_a_capture_velocity(bare):
    damped = bare.replace(adhesion_damping=1.5)
    found = work_of_adhesion_for(damped, 0.1)
    assert capture_velocity(found) == pytest.approx(0.1, rel=1e-9)
    with pytest.raises(NoSolutionError, match="up to 1000"):
        work_of_adhesion_for(bare.replace(adhesion_damping=1e-9), 5.0)


def test_force_ratios_are_met_together(bare):
    wanted = bare.replace(work_of_adhesion=0.5)
    adhesion, _ = peak_ratios(wanted, HIGH)
    found = hertz_damping_for_adhesion_ratio(wanted, HIGH, 1.02 * adhesion, 0.1)
    np.testing.assert_allclose(peak_ratios(found, HIGH), (1.02 * adhesion, 0.1), rtol=1e-6)
    with pytest.raises(NoSolutionError, match="even without material damping"):
        hertz_damping_for_adhesion_ratio(wanted, HIGH, 0.9 * adhesion, 0.1)


def test_dissipation_ratio(bare):
    found = dissipation_ratio_for(bare.replace(work_of_adhesion=0.5), HIGH, 0.2)
    assert peak_ratios(found, HIGH)[1] == pytest.approx(0.2, rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((0.0, E, CAPTURE), "high_speed"),
        ((HIGH, 1.0, CAPTURE), "restitution"),
        ((HIGH, E, -0.1), "capture_speed"),
        ((HIGH, E, 2.0), "capture_speed must be below"),
    ],
)
def test_targets_out_of_range(bare, arguments, name):
    with pytest.raises(ValueError, match=name):
        two_stage(bare, *arguments)


def test_a_target_that_is_no_number(bare):
    with pytest.raises(TypeError, match="restitution"):
        two_stage(bare, HIGH, "0.7", CAPTURE)


def test_one_factor_on_both_dampings_meets_a_restitution(contact):
    found = damping_factor_for(contact, HIGH, 0.55)
    assert simulate(found, HIGH).coefficient_of_restitution == pytest.approx(0.55, abs=1e-10)
    assert found.adhesion_damping / found.hertz_damping == pytest.approx(
        contact.adhesion_damping / contact.hertz_damping, rel=1e-12
    )
    with pytest.raises(NoSolutionError):
        damping_factor_for(contact.replace(hertz_damping=0.0, adhesion_damping=0.0), HIGH, 0.55)


def test_a_loss_that_no_law_has_is_refused(bare):
    # JKR without viscosity still loses what breaking the contact costs
    with pytest.raises(NoSolutionError, match="jkr: e at 1"):
        law_for(bare, "jkr", HIGH, 0.9999, CAPTURE)
