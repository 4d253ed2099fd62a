"""Sobol' indices against closed forms, and many calibrations at once against one by one."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import pytest
from SALib.analyze.sobol import analyze

from microimpact.model.calibration import two_stage
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.statistics.sobol import saltelli_sample, sobol_indices
from study.analyses.sensitivity.compute import Draw, group_tables
from study.analyses.sensitivity.ridge import Targets, calibrated_sample, material_damping


def generator(*key):
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(7, spawn_key=key)))


@pytest.fixture(scope="module")
def ridge(steel, silicon, contact):
    """Steel on silicon, calibrated to e = 0.70 at 1.66 m/s and v_c = 0.18 m/s."""
    bare = contact.replace(work_of_adhesion=4.0, reference_velocity=1.66)
    return two_stage(bare, 1.66, 0.70, 0.18).contact


def indices(response):
    return sobol_indices(response, generator(2), resamples=200, confidence=0.95)


def test_indices_are_those_of_the_library():
    # A few base samples, so that some resamples hold one of them alone.
    response = np.exp(saltelli_sample(3, 4, generator(1)) @ np.array([1.0, 2.0, 3.0])) + 100.0
    found = indices(response)
    known = analyze(
        {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[0.0, 1.0]] * 3},
        response.ravel(),
        calc_second_order=False,
        num_resamples=200,
        keep_resamples=True,
        seed=generator(2),
    )
    for name, key in (("first", "S1"), ("total", "ST")):
        assert getattr(found, name) == pytest.approx(known[key], rel=1e-9)
        for end, share in (("low", 0.025), ("high", 0.975)):
            ends = np.quantile(known[f"{key}_conf_all"], share, axis=0)
            assert getattr(found, f"{name}_{end}") == pytest.approx(ends, rel=1e-9)


def test_groups_of_a_product():
    # y = x_0 (x_1 + x_2): uncertainty is the sum, variability the factor; they interact
    cube = 0.5 + saltelli_sample(3, 2048, generator(1))
    response = cube[..., 0] * (cube[..., 1] + cube[..., 2])
    draw = Draw(case="c", variation="v", response=response)
    find = partial(sobol_indices, draw=generator(3), resamples=50, confidence=0.95)
    groups = pd.concat(group_tables(draw, 0, find)).set_index("input")
    radius, rest = 4.0 / 12.0, 2.0 / 12.0
    both = radius / 4.0 * rest
    variance = radius + rest + both
    wanted = {"variability": (radius, radius + both), "uncertainty": (rest, rest + both)}
    for name, (first, total) in wanted.items():
        assert groups["first"][name] == pytest.approx(first / variance, abs=0.015)
        assert groups["total"][name] == pytest.approx(total / variance, abs=0.015)
    single = find(draw.kept()).total[0]
    assert single == pytest.approx(groups["total"]["variability"], rel=1e-12)


@pytest.mark.parametrize("without", [np.nan, np.inf])
def test_base_samples_without_a_capture_velocity_are_left_out_and_counted(without):
    response = np.arange(20.0).reshape(4, 5)
    response[1, 2] = without
    draw = Draw(case="c", variation="v", response=response)
    np.testing.assert_array_equal(draw.kept(), response[[0, 2, 3]])
    assert draw.label["samples_kept"] == 3
    assert draw.label["points_without_capture_velocity"] == 1
    with pytest.raises(ValueError, match="1 of 2 base samples"):
        draw.kept(2)


def test_material_damping_alone_gives_the_restitution(contact):
    e = np.array([0.3, 0.7, 0.95])
    damped = contact.replace(
        work_of_adhesion=0.0, adhesion_damping=0.0, hertz_damping=material_damping(1.66, e)
    )
    assert simulate(damped, 1.66).coefficient_of_restitution == pytest.approx(e, rel=1e-9)


@pytest.mark.parametrize("rate", [0.0, 1.0])
def test_every_calibration_meets_its_targets(ridge, contact, rate):
    start = ridge
    if rate:
        bare = contact.replace(
            work_of_adhesion=0.7, adhesion_rate_exponent=rate, reference_velocity=1.66
        )
        start = two_stage(bare, 1.66, 0.70, 0.18).contact
    middle = float(start.hertz_damping / material_damping(1.66, np.array([0.70]))[0])
    targets = Targets(
        high_speed=1.66,
        restitution=np.array([0.70, 0.66, 0.73]),
        capture_velocity=np.array([0.18, 0.175, 0.188]),
        damping_share=middle + np.array([0.0, 0.03, -0.03]),
        stiffness=np.array([1.0, 1.2, 0.9]),
    )
    sample, met = calibrated_sample(start, targets)
    assert met.all()
    assert capture_velocity(sample) == pytest.approx(targets.capture_velocity, rel=1e-7)
    e = simulate(sample, 1.66).coefficient_of_restitution
    assert e == pytest.approx(targets.restitution, rel=1e-7)
    # the first is the start itself, found by the two-stage method
    assert sample.work_of_adhesion[0] == pytest.approx(start.work_of_adhesion, rel=1e-6)
    assert sample.adhesion_damping[0] == pytest.approx(float(start.adhesion_damping), rel=1e-6)


def test_a_calibration_without_a_solution_is_told(ridge):
    targets = Targets(
        high_speed=1.66,
        restitution=np.array([0.70, 0.70]),
        capture_velocity=np.array([0.18, 0.18]),
        # almost all loss left to the material: adhesion cannot capture at 0.18 m/s besides
        damping_share=np.array([0.1, 0.999]),
        stiffness=np.ones(2),
    )
    assert calibrated_sample(ridge, targets)[1].tolist() == [True, False]


def test_calibration_absorbs_the_stiffness(ridge):
    targets = Targets(
        high_speed=1.66,
        restitution=np.full(2, 0.70),
        capture_velocity=np.full(2, 0.18),
        damping_share=np.full(2, 0.1),
        stiffness=np.array([1.0, 1.5]),
    )
    sample, _ = calibrated_sample(ridge, targets)
    smaller = capture_velocity(sample.replace(diameter=30e-6))
    assert smaller[0] == pytest.approx(smaller[1], rel=1e-8)
    # V stays, so w_A goes with K^(2/5)
    ratio = sample.work_of_adhesion[1] / sample.work_of_adhesion[0]
    assert ratio == pytest.approx(1.5**0.4, rel=1e-7)
