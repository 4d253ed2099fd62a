"""Monte Carlo program: generators, correlation, sampling, facets, rules, bad inputs."""

from __future__ import annotations

import json
import re
import sys
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from scipy import integrate, special, stats
from tests.shared import ROOT, STILL, facet_rebound

from microimpact.declared.parameters import build, explain
from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.experiment import Drop, Target
from microimpact.lab.surface import LABORATORY, Rules, Surface, facets, rough
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate
from microimpact.model.rigid_body.roughness import rough_rebound
from microimpact.statistics.distributions import (
    Constant,
    HalfNormal,
    Histogram,
    LogNormal,
    Normal,
    Sample,
    SampleFile,
    TruncatedNormal,
    Uniform,
    generator,
)
from microimpact.statistics.sampling import Correlation, joint_shares, unit_points
from microimpact.studies.analyses.monte_carlo import Params, stream
from microimpact.studies.analyses.monte_carlo.ensembles import (
    BLOCK,
    TOGETHER,
    Ensemble,
    Plan,
    Process,
    Struck,
    deterministic,
    estimate,
    long_run,
    progress,
    replicate_shares,
    replicate_sums,
    summary,
)
from microimpact.studies.analyses.monte_carlo.impacts import RigidBody, Simulation, require_meaning
from microimpact.studies.analyses.monte_carlo.slope_inference import SlopeInference, infer_slope

N = 2**16
SEED = 20011


def constants(**changes):
    names = ("angle_offset_deg", "slope", "cross_slope", "spin_ratio", "restitution_offset")
    ones = ("restitution_factor", "work_of_adhesion_factor", "hertz_damping_factor")
    fixed = {name: Constant(at=0.0) for name in names}
    fixed |= {name: Constant(at=1.0) for name in (*ones, "adhesion_damping_factor")}
    fixed |= {"speed_m_per_s": Constant(at=1.66), "diameter_um": Constant(at=62.0)}
    return Process(**{**fixed, "friction": Constant(at=0.15), **changes})


ARTICLE = Rules(facets="facing", must_leave=True, most_contacts=1)
SIZES = Uniform(low=45.0, high=76.0)


def law(normal_speed):
    """e of a sphere that is captured below 0.18 m/s and loses half its energy far above."""
    return 0.7 * np.sqrt(np.maximum(1.0 - (0.18 / normal_speed) ** 2, 0.0))


@dataclass(frozen=True)
class Rigid(Struck):
    """Contacts of rigid spheres; restitution at normal speeds, captured where it is zero."""

    restitution: Callable

    def __call__(self, draws):
        def strike(which, velocity, spin, normal):
            radius = 0.5e-6 * draws["diameter_um"][which, None]
            e = self.restitution(-np.vecdot(velocity, normal))
            friction = draws["friction"][which]
            after = facet_rebound(velocity, radius * spin, normal, e, friction)
            return after[0], after[1] / radius, e == 0.0

        return strike


lawful = Rigid(law)


def constant_e(e):
    return Rigid(lambda normal_speed: np.full(normal_speed.shape, e))


def ensemble(
    process=None, *, rules=ARTICLE, impact=lawful, method="plain", replicates=16, events=1024
):
    return Ensemble(
        process=process or constants(slope=Normal(sd=0.2)),
        rules=rules,
        impact=impact,
        plan=Plan(replicates=replicates, events=events, method=method),
        seed=(SEED,),
    )


# Generators


def drawn(distribution, **options):
    shares = joint_shares({"x": distribution}, N, generator(SEED, 1), **options)
    return distribution.quantile(shares["x"])


@pytest.mark.parametrize("method", ["plain", "antithetic", "quasi_random"])
@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Uniform(low=-1.0, high=3.0), stats.uniform(-1.0, 4.0)),
        (Normal(mean=2.0, sd=0.5), stats.norm(2.0, 0.5)),
        (Normal(), stats.norm()),
        (LogNormal(median=3.0, geometric_sd=1.5), stats.lognorm(np.log(1.5), 0.0, 3.0)),
        (HalfNormal(sd=0.15), stats.halfnorm(0.0, 0.15)),
        (
            TruncatedNormal(mean=62.0, sd=4.5, low=45.0, high=76.0),
            stats.truncnorm(-17.0 / 4.5, 14.0 / 4.5, 62.0, 4.5),
        ),
        (
            Histogram(edges=(0.0, 1.0, 3.0), counts=(1.0, 3.0)),
            None,  # two uniform bins of masses 1/4 and 3/4
        ),
    ],
)
def test_moments_of_draws(distribution, reference, method):
    x = drawn(distribution, method=method)
    mean, variance, kurtosis = (
        (1.625, 0.25 / 3 + 0.75 * 13 / 3 - 1.625**2, -1.0)
        if reference is None
        else reference.stats("mvk")
    )
    error = np.sqrt(variance / N)
    assert x.mean() == pytest.approx(mean, abs=5 * error)
    assert x.var() == pytest.approx(variance, rel=5 * np.sqrt((kurtosis + 2) / N))


def test_sum_of_twelve_uniforms_lacks_a_tenth_of_kurtosis_and_has_no_tails():
    exact, summed = (drawn(Normal(), generator=g) for g in ("exact", "central_limit"))
    assert summed.mean() == pytest.approx(0.0, abs=5 / np.sqrt(N))
    assert summed.var() == pytest.approx(1.0, abs=5 * np.sqrt(1.9 / N))
    # excess kurtosis of a uniform variable is -6/5, of a sum of twelve a twelfth of it
    error = np.sqrt(24 / N)
    assert stats.kurtosis(exact) == pytest.approx(0.0, abs=4 * error)
    assert stats.kurtosis(summed) == pytest.approx(-1.2 / 12, abs=4 * error)
    assert abs(stats.kurtosis(summed) - stats.kurtosis(exact)) > 0.02
    # every variable far out is a matter of rounding alone: 6 is the greatest sum
    assert np.abs(summed).max() < 6.0


def test_other_distributions_take_their_uniform_number_in_either_generator():
    for distribution in (Uniform(low=0.0, high=1.0), Sample(values_seen=(1.0, 2.0, 4.0))):
        assert np.array_equal(
            drawn(distribution, generator="exact"), drawn(distribution, generator="central_limit")
        )


@pytest.mark.parametrize("method", ["plain", "antithetic", "quasi_random"])
@pytest.mark.parametrize("by", ["exact", "central_limit"])
def test_correlation_is_that_of_the_normal_scores(method, by):
    matrix = ((1.0, 0.6, -0.3), (0.6, 1.0, 0.2), (-0.3, 0.2, 1.0))
    distributions = {
        "a": Normal(mean=1.0, sd=2.0),
        "free": Normal(),
        "b": LogNormal(median=2.0, geometric_sd=1.3),
        "c": Uniform(low=-1.0, high=1.0),
    }
    shares = joint_shares(
        distributions,
        N,
        generator(SEED, 2),
        correlation=Correlation(names=("a", "b", "c"), matrix=matrix),
        method=method,
        generator=by,
    )
    scores = np.stack([special.ndtri(shares[name]) for name in ("a", "b", "c", "free")])
    expected = np.eye(4)
    expected[:3, :3] = matrix
    assert np.corrcoef(scores) == pytest.approx(expected, abs=5 / np.sqrt(N))
    # a bivariate normal has r = 2 sin(pi/6 rho_s): between normal and lognormal ranks alone count
    values = [distributions[name].quantile(shares[name]) for name in ("a", "b")]
    spearman = stats.spearmanr(*values).statistic
    assert spearman == pytest.approx(6 / np.pi * np.arcsin(0.3), abs=5 / np.sqrt(N))
    assert stats.kstest(shares["c"], "uniform").statistic < 2.0 / np.sqrt(N)


def test_antithetic_points_come_in_opposite_pairs():
    points = unit_points(64, 3, generator(SEED, 3), "antithetic")
    assert points[:32] + points[32:] == pytest.approx(1.0)
    assert len(np.unique(points[:32])) == 96


def test_quasi_random_points_fill_every_interval_alike():
    points = unit_points(256, 4, generator(SEED, 4), "quasi_random")
    for column in points.T:
        assert np.array_equal(np.sort((column * 256).astype(int)), np.arange(256))
    other = unit_points(256, 4, generator(SEED, 5), "quasi_random")
    assert not np.any(points == other)


# Facets

# Their slopes are their own quantiles.
GIVEN = Surface(
    slope=Uniform(low=0.0, high=1.0),
    cross_slope=Uniform(low=0.0, high=1.0),
    rules=replace(LABORATORY, facets="facing"),
)


def planar(angle, slope, e, friction, spin):
    n = len(angle)
    zero = np.zeros(n)
    velocity = np.stack([np.cos(angle), zero, -np.sin(angle)], axis=1)
    normal = facets(GIVEN, velocity, np.tan(slope), zero)
    spin_speed = np.stack([zero, spin, zero], axis=1)
    return velocity, *facet_rebound(velocity, spin_speed, normal, e, friction)


def test_planar_facets_reproduce_the_measured_coefficients():
    rng = generator(SEED, 8)
    angle = rng.uniform(0.05, 1.5, 500)
    slope = rng.uniform(-0.9, 1.0, 500) * angle
    e, friction, spin = rng.uniform(0, 1, 500), rng.uniform(0, 0.5, 500), rng.normal(0, 0.3, 500)
    before, after, _ = planar(angle, slope, e, friction, spin)
    expected = rough_rebound(angle, slope, e, friction, spin)
    change = after - before
    assert -after[:, 2] / before[:, 2] == pytest.approx(expected.measured_restitution, abs=1e-10)
    assert change[:, 0] / change[:, 2] == pytest.approx(
        expected.measured_impulse_ratio, rel=1e-9, abs=1e-9
    )
    assert after[:, 1] == pytest.approx(0.0, abs=1e-15)


def test_facets_in_three_dimensions_obey_mechanics():
    rng = generator(SEED, 9)
    n = 500
    velocity = rng.normal(size=(n, 3)) * [1.0, 1.0, 0.1] - [0.0, 0.0, 1.0]
    velocity[:, 2] = -np.abs(velocity[:, 2])
    spin, e, friction = rng.normal(size=(n, 3)), rng.uniform(0, 1, n), rng.uniform(0, 0.6, n)
    normal = facets(GIVEN, velocity, rng.uniform(0, 0.3, n), rng.normal(0, 0.2, n))
    into = np.vecdot(velocity, normal)
    keep = into < 0
    velocity, spin, normal, into = velocity[keep], spin[keep], normal[keep], into[keep]
    e, friction = e[keep], friction[keep]
    after, turned = facet_rebound(velocity, spin, normal, e, friction)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    assert np.vecdot(after, normal) == pytest.approx(-e * into)
    # angular momentum about the point of contact: r n x m v + I omega
    before_l = np.cross(normal, velocity) + 0.4 * spin
    assert np.cross(normal, after) + 0.4 * turned == pytest.approx(before_l, abs=1e-13)
    energy = [
        np.vecdot(v, v) + 0.4 * np.vecdot(w, w) for v, w in ((velocity, spin), (after, turned))
    ]
    assert np.all(energy[1] <= energy[0] * (1 + 1e-12))
    slip = [v - np.vecdot(v, normal)[:, None] * normal - np.cross(w, normal)
            for v, w in ((velocity, spin), (after, turned))]  # fmt: skip
    along = np.vecdot(slip[0], slip[1])
    assert np.all(along >= -1e-12)
    rolls = np.linalg.norm(slip[1], axis=1) < 1e-12
    impulse = after - velocity
    across = impulse - np.vecdot(impulse, normal)[:, None] * normal
    ratio = np.linalg.norm(across, axis=1) / np.vecdot(impulse, normal)
    assert np.all(ratio[rolls] <= friction[rolls] + 1e-12)
    assert ratio[~rolls] == pytest.approx(friction[~rolls])
    assert 0.05 < rolls.mean() < 0.95


def test_a_facet_that_faces_the_motion_turns_its_normal_against_it():
    velocity = np.array([[0.6, 0.8, -1.0]])
    facing = facets(GIVEN, velocity, np.array([0.2]), np.zeros(1))
    flat = facets(GIVEN, velocity, np.zeros(1), np.zeros(1))
    assert np.vecdot(velocity, facing)[0] < np.vecdot(velocity, flat)[0] == -1.0


# Estimates


@pytest.mark.parametrize("facets", ["facing", "seen"])
@pytest.mark.parametrize("must_leave", [False, True])
@pytest.mark.parametrize("angle_deg", [10.0, 20.0, 45.0, 85.0])
def test_mean_over_slopes_alone_is_a_known_integral(facets, must_leave, angle_deg):
    # frictionless, constant e: e_m = ((1 + e) sin(alpha + 2 phi)/sin(alpha) - (1 - e)) / 2
    e, sd, alpha = 0.7, 0.2, np.radians(angle_deg)

    def measured(x):
        return 0.5 * ((1 + e) * np.sin(alpha + 2 * np.arctan(x)) / np.sin(alpha) - (1 - e))

    def weight(x):
        hit = np.tan(alpha) + x if facets == "seen" else 1.0
        return hit * stats.norm.pdf(x, 0.0, sd)

    low = -min(np.tan(alpha), 8 * sd)
    if must_leave:
        # alpha + 2 phi at which V_n = 0
        low = np.tan(0.5 * (np.arcsin(0.3 / 1.7 * np.sin(alpha)) - alpha))
    limits = {"limit": 500, "epsabs": 1e-12}
    high = 8 * sd
    if must_leave:
        high = min(high, np.tan(0.5 * (np.pi - np.arcsin(0.3 / 1.7 * np.sin(alpha)) - alpha)))
    top = integrate.quad(lambda x: measured(x) * weight(x), low, high, **limits)[0]
    bottom = integrate.quad(weight, low, high, **limits)[0]
    process = constants(slope=Normal(sd=sd), friction=Constant(at=0.0))
    rules = replace(ARTICLE, facets=facets, must_leave=must_leave)
    found = estimate(
        ensemble(process, rules=rules, impact=constant_e(e), method="quasi_random"), angle_deg
    )
    assert found.restitution == pytest.approx(top / bottom, abs=5 * found.restitution_error + 2e-4)
    assert found.restitution_error < 2e-3
    assert found.captured == 0.0


def replicate(one, key, number):
    return replicate_sums(one, 20.0, [replicate_shares(one, key, number)])[0]


def test_ensembles_may_share_what_is_drawn():
    one = ensemble(constants(slope=Normal(sd=0.2)))
    other = replace(one, process=replace(one.process, slope=Normal(sd=0.3)))
    shares = [replicate_shares(one, 2, number) for number in range(one.plan.replicates)]
    assert estimate(other, 20.0, 2, shares=shares) == estimate(other, 20.0, 2)
    assert estimate(other, 20.0, 2, shares=shares) != estimate(other, 20.0, 3)


def test_replicates_do_not_depend_on_when_or_where_they_are_computed():
    one = ensemble(constants(slope=Normal(sd=0.2), diameter_um=Uniform(low=50.0, high=70.0)))
    forward = [replicate(one, 3, number) for number in range(8)]
    backward = [replicate(one, 3, number) for number in reversed(range(8))][::-1]
    assert np.array_equal(forward, backward)
    # fewer replicates are the first ones of more, bit for bit
    short = estimate(replace(one, plan=replace(one.plan, replicates=8)), 20.0, 3)
    assert short == summary(np.stack(forward), one.plan.events)
    assert len({tuple(sums) for sums in forward}) == 8
    assert not np.array_equal(replicate(one, 4, 0), forward[0])


def test_threads_change_no_digit_and_longer_runs_begin_with_shorter_ones():
    base = ensemble(constants(slope=Normal(sd=0.2)), replicates=70, events=64)
    counted = []
    one = estimate(base, 20.0, done=counted.append)
    assert estimate(base, 20.0, threads=3) == one
    assert counted == [70 * 64]
    short, long = long_run(base, BLOCK + 1), long_run(base, 3 * BLOCK)
    assert (short.plan.replicates, long.plan.replicates) == (2, 3)
    assert np.array_equal(replicate(short, 0, 1), replicate(long, 0, 1))


def test_memory_does_not_grow_with_the_events():
    base = ensemble(constants(slope=Normal(sd=0.2)), replicates=2, events=64)
    peaks = []
    for events in (2 * TOGETHER, 12 * TOGETHER):
        tracemalloc.start()
        estimate(long_run(base, events), 20.0)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0] < 50e6


def test_progress_is_shown_on_a_terminal_only(capsys, monkeypatch):
    with progress("events", 2) as done:
        done(1)
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    with progress("events", 2) as done:
        done(2)
    shown = capsys.readouterr()
    assert "events" in shown.err
    assert shown.out == ""


def test_estimates_of_all_methods_agree_and_quasi_random_ones_are_closer():
    process = constants(slope=Normal(sd=0.2), diameter_um=Normal(mean=62.0, sd=4.5))
    found = {
        method: estimate(ensemble(process, method=method, replicates=32), 20.0)
        for method in ("plain", "antithetic", "quasi_random")
    }
    best = found["quasi_random"]
    for one in found.values():
        error = np.hypot(one.restitution_error, best.restitution_error)
        assert abs(one.restitution - best.restitution) < 4 * error + 1e-12
    assert best.restitution_error < 0.2 * found["plain"].restitution_error
    assert found["antithetic"].restitution_error < 1.2 * found["plain"].restitution_error


def test_standard_error_is_that_of_repeated_estimates():
    # 40 independent estimates scatter as each of them says
    one = ensemble(replicates=16, events=128)
    found = [estimate(one, 20.0, key) for key in range(40)]
    scatter = np.std([f.restitution for f in found], ddof=1)
    claimed = np.sqrt(np.mean([f.restitution_error**2 for f in found]))
    assert scatter == pytest.approx(claimed, rel=0.35)
    # and as the scatter of events over the root of their number
    accepted = np.mean([f.accepted for f in found]) * 16 * 128
    assert claimed == pytest.approx(found[0].restitution_sd / np.sqrt(accepted), rel=0.15)


def test_small_spreads_give_the_deterministic_rebound():
    narrow = constants(
        slope=Normal(sd=1e-7),
        cross_slope=Normal(sd=1e-7),
        speed_m_per_s=Normal(mean=1.66, sd=1e-7),
        diameter_um=Normal(mean=62.0, sd=1e-6),
        spin_ratio=Normal(mean=0.1, sd=1e-8),
    )
    for rules in (ARTICLE, replace(ARTICLE, facets="seen", most_contacts=3)):
        one = ensemble(narrow, rules=rules)
        for angle in (10.0, 45.0, 90.0):
            found, exact = estimate(one, angle), estimate(deterministic(one), angle)
            assert found.restitution == pytest.approx(exact.restitution, abs=1e-6)
            assert found.impulse_ratio == pytest.approx(exact.impulse_ratio, abs=1e-6)
    bare = rough_rebound(np.radians(45.0), 0.0, law(1.66 * np.sin(np.radians(45.0))), 0.15, 0.1)
    exact = estimate(deterministic(ensemble(narrow)), 45.0)
    assert exact.restitution == pytest.approx(float(bare.measured_restitution), rel=1e-9)
    assert exact.impulse_ratio == pytest.approx(-float(bare.measured_impulse_ratio), rel=1e-6)
    assert exact.restitution_error == 0.0


def test_shares_of_events_add_up_and_rules_reject_what_they_say():
    strict = estimate(ensemble(), 15.0)
    assert strict.accepted + strict.facing_away + strict.captured + strict.not_leaving == 1.0
    assert min(strict[-4:]) > 0.0
    # P(slope < -tan alpha)
    expected = stats.norm.cdf(-np.tan(np.radians(15.0)) / 0.2)
    assert strict.facing_away == pytest.approx(expected, abs=0.01)
    flux = estimate(ensemble(rules=replace(ARTICLE, facets="seen")), 15.0)
    assert flux.facing_away == 0.0
    assert flux.not_leaving < strict.not_leaving
    twice = estimate(ensemble(rules=replace(ARTICLE, most_contacts=5)), 15.0)
    assert twice.not_leaving < strict.not_leaving
    assert twice.accepted > strict.accepted
    lax = estimate(ensemble(rules=replace(ARTICLE, must_leave=False)), 15.0)
    assert lax.not_leaving == 0.0
    assert lax.restitution < strict.restitution


def test_without_rules_roughness_does_not_raise_restitution():
    # frictionless: over even slopes the mean of sin(alpha + 2 phi) is below sin(alpha)
    none = Rules(facets="every", must_leave=False, most_contacts=1)
    process = constants(slope=Normal(sd=0.15), friction=Constant(at=0.0))
    found = estimate(
        ensemble(process, rules=none, impact=constant_e(0.7), method="quasi_random"), 20.0
    )
    even = integrate.quad(
        lambda x: np.cos(2 * np.arctan(x)) * stats.norm.pdf(x, 0, 0.15), -1.5, 1.5
    )[0]
    assert found.restitution == pytest.approx(0.5 * (1.7 * even - 0.3), abs=1e-3)
    assert found.restitution < 0.7
    assert found.accepted == 1.0


def test_no_event_accepted_gives_no_mean():
    found = estimate(deterministic(ensemble(constants())), 3.0)  # v_n below capture
    assert np.isnan(found.restitution)
    assert found.captured == 1.0


# Models of an impact


@pytest.fixture(scope="module")
def contact(steel, silicon):
    return Contact(
        particle=steel,
        surface=silicon,
        diameter=62e-6,
        work_of_adhesion=3.5,
        hertz_damping=0.0029476912213941297,
        adhesion_damping=1.3915651324806888,
    )


def restitution(model, normal_speed, draws):
    unit, place = model.scales(draws)
    return model.law.restitution(normal_speed / unit, place)


@pytest.mark.parametrize("exponent", [0.0, 1.0])
def test_the_rigid_body_has_the_restitution_of_the_simulation_at_every_size(contact, exponent):
    rated = contact.replace(adhesion_rate_exponent=exponent, reference_velocity=1.66)
    process = constants(
        diameter_um=SIZES,
        work_of_adhesion_factor=Uniform(low=0.9, high=1.1),
        speed_m_per_s=Uniform(low=1.6, high=1.7),
    )
    model = RigidBody.of(rated, process)
    rng = generator(SEED, 10)
    diameter, factor = rng.uniform(45.0, 76.0, 400), rng.uniform(0.9, 1.1, 400)
    speed = np.geomspace(0.15, 1.7, 400)
    sphere = rated.replace(diameter=diameter * 1e-6, work_of_adhesion=factor * 3.5)
    expected = simulate(sphere, speed).coefficient_of_restitution
    draws = {"diameter_um": diameter, "work_of_adhesion_factor": factor}
    found = restitution(model, speed, draws)
    assert np.array_equal(found == 0.0, expected == 0.0)
    assert 0 < np.sum(expected == 0.0) < 300
    # Near capture e is as sensitive to rounding as it is steep.
    assert found == pytest.approx(expected, rel=2e-9, abs=1e-12)
    assert model.law.error <= 1e-9


def test_very_wide_sizes_get_wider_tables(contact):
    process = constants(diameter_um=LogNormal(median=62.0, geometric_sd=1.12))
    model = RigidBody.of(contact, process)
    diameter = np.geomspace(25.0, 150.0, 300)
    draws = {"diameter_um": diameter, "work_of_adhesion_factor": np.ones(300)}
    expected = simulate(contact.replace(diameter=diameter * 1e-6, work_of_adhesion=3.5), 1.2)
    found = restitution(model, np.full(300, 1.2), draws)
    assert found == pytest.approx(expected.coefficient_of_restitution, rel=1e-6)


def test_the_rigid_body_wants_a_plane(contact):
    with pytest.raises(ValueError, match="surface_radius: must be infinite"):
        RigidBody.of(contact.replace(surface_radius=1e-3), constants(diameter_um=SIZES))


def test_the_rigid_body_serves_sizes_it_was_not_made_for_too(contact):
    model = RigidBody.of(contact, constants(diameter_um=SIZES))
    diameter = np.array([30.0, 40.0, 90.0])
    draws = {"diameter_um": diameter, "work_of_adhesion_factor": np.ones(3)}
    expected = simulate(contact.replace(diameter=diameter * 1e-6, work_of_adhesion=3.5), 1.0)
    assert restitution(model, np.ones(3), draws) == pytest.approx(
        expected.coefficient_of_restitution, rel=1e-9
    )
    with pytest.raises(ValueError, match="have no capture velocity"):
        RigidBody.of(contact, constants(diameter_um=Uniform(low=5.0, high=62.0)))


@dataclass(frozen=True)
class OneByOne(Struck):
    """The rigid body's contacts one after the other, in arrays."""

    model: RigidBody

    def __call__(self, draws):
        def strike(which, velocity, spin, normal):
            own = {name: values[which] for name, values in draws.items()}
            radius = 0.5e-6 * own["diameter_um"][:, None]
            bare = restitution(self.model, -np.vecdot(velocity, normal), own)
            e = np.clip(own["restitution_factor"] * bare + own["restitution_offset"], 0.0, 1.0)
            after, turned = facet_rebound(velocity, radius * spin, normal, e, own["friction"])
            return after, turned / radius, bare == 0.0

        return strike


@pytest.mark.parametrize("facets", ["seen", "facing", "every"])
@pytest.mark.parametrize("most_contacts", [1, 5])
@pytest.mark.parametrize("must_leave", [False, True])
def test_one_pass_is_what_contacts_one_after_the_other_are(
    contact, facets, most_contacts, must_leave
):
    process = constants(
        speed_m_per_s=Uniform(low=0.5, high=1.7),
        angle_offset_deg=Normal(sd=3.0) if most_contacts == 1 else Constant(at=1.0),
        diameter_um=SIZES,
        slope=Sample(values_seen=(-0.2, 0.1, 0.1, 0.4)) if must_leave else Normal(sd=0.3),
        cross_slope=Histogram(edges=(-0.2, 0.0, 0.1), counts=(1.0, 3.0)),
        spin_ratio=Normal(sd=0.3),
        friction=Sample(values_seen=(0.0, 0.1, 0.3)),
        restitution_factor=Uniform(low=0.8, high=1.2),
        restitution_offset=Constant(at=0.02),
        work_of_adhesion_factor=Uniform(low=0.9, high=1.1),
    )
    rules = Rules(facets=facets, must_leave=must_leave, most_contacts=most_contacts)
    model = RigidBody.of(contact, process)
    for angle in (8.0, 40.0, 90.0):
        one, other = (
            ensemble(process, rules=rules, impact=impact) for impact in (model, OneByOne(model))
        )
        shares = [replicate_shares(one, 0, number) for number in range(4)]
        found, expected = (replicate_sums(e, angle, shares) for e in (one, other))
        assert found.shape == (4, 8)
        assert np.array_equal(found[:, :4], expected[:, :4])
        assert found[:, 4:] == pytest.approx(expected[:, 4:], rel=1e-9)
        assert expected[:, 3].sum() > 0


def test_the_simulation_of_an_ensemble_is_that_of_single_impacts(contact):
    process = constants(friction=Constant(at=0.1), spin_ratio=Constant(at=0.05))
    found = estimate(deterministic(ensemble(process, impact=Simulation(contact=contact))), 30.0)
    single = simulate(contact.replace(friction=0.1), 1.66, 30.0, 0.05 * 1.66 / 31e-6)
    assert found.restitution == pytest.approx(float(single.coefficient_of_restitution), rel=1e-9)
    assert found.impulse_ratio == pytest.approx(float(single.impulse_ratio), rel=1e-9)
    rough = replace(process, slope=Normal(sd=0.1), cross_slope=Normal(sd=0.1))
    spread = estimate(
        ensemble(rough, impact=Simulation(contact=contact), replicates=4, events=64), 30.0
    )
    assert spread.restitution_sd > 0.05


class Given:
    """A source of the random numbers that it is given."""

    def __init__(self, parts):
        self.parts = iter(parts)

    def random(self, shape):
        part = next(self.parts)
        assert part.shape == shape
        return part


def as_in_the_laboratory(contact, events):
    process = constants(slope=Normal(sd=0.16), cross_slope=Normal(sd=0.16))
    simulation = Simulation(contact=contact)
    return ensemble(process, rules=LABORATORY, impact=simulation, replicates=16, events=events)


def test_ensembles_by_the_rules_of_the_laboratory_are_its_own_draw_by_draw(contact):
    one, angle = as_in_the_laboratory(contact, 512), 20.0
    shares = replicate_shares(one, 0, 0)
    sums = replicate_sums(one, angle, [shares])[0]
    names = [("slope", "cross_slope")]
    names += [tuple(f"{a}, contact {k}" for a in names[0]) for k in range(2, 6)]
    rng = Given(np.stack([shares[name] for name in pair]) for pair in names)
    alpha = np.radians(angle)
    before = np.tile([1.66 * np.cos(alpha), 0.0, -1.66 * np.sin(alpha)], (512, 1))
    steel = contact.replace(friction=0.15)
    target = Target(contact=steel, surface=rough(0.16))
    found = target.hit(np.full(512, 62e-6), before, np.zeros((512, 3)), rng)
    free = ~found.captured
    e = -found.velocity[free, 2] / before[free, 2]
    assert found.contacts.max() > 1
    assert 0 < free.sum() == sums[3] < 512
    assert e.sum() == pytest.approx(sums[4], rel=1e-12)


def test_ensembles_by_the_rules_of_the_laboratory_agree_with_its_samples(contact):
    steel = contact.replace(friction=0.15)
    for angle in (45.0, 20.0):
        drop = Drop(
            target=Target(contact=steel, surface=rough(0.16)),
            diameter_um=Constant(at=62.0),
            angle=angle,
            speed=1.66,
            speed_range=(1.6, 1.7),
            dispenser=STILL,
            spin=NO_SPIN,
        )
        impacts = drop.impacts(8192, generator(SEED, 30))
        e = impacts.in_plane.coefficient_of_restitution[~impacts.captured]
        found = estimate(as_in_the_laboratory(contact, 512), angle)
        error = np.hypot(found.restitution_error, e.std() / np.sqrt(e.size))
        assert abs(e.mean() - found.restitution) < 4.0 * error < 0.05
        share = np.mean(impacts.captured)
        assert share == pytest.approx(1.0 - found.accepted, abs=4 * np.sqrt(0.25 / 8192))


# Slope inference


def test_inferred_slope_gives_back_the_restitution_it_was_inferred_from():
    settings = SlopeInference(
        angle_deg=20.0,
        restitution=1.0,
        angle_half_width_deg=2.5,
        restitution_half_width=0.05,
        events_measured=40,
        smallest_sd=0.02,
        largest_sd=0.5,
        laboratory_sd=0.16,
        plan=Plan(replicates=4, events=512, method="quasi_random"),
    )
    flux = ensemble(rules=replace(ARTICLE, facets="seen"))
    row = infer_slope(flux, settings, two_axes=False)
    assert row["reached"]
    again = replace(flux, process=replace(flux.process, slope=Normal(sd=row["slope_sd"])))
    found = estimate(replace(again, plan=replace(settings.plan, replicates=32)), 20.0)
    assert found.restitution == pytest.approx(1.0, abs=5e-3)
    assert row["u_slope_sd"] > row["u_events_measured"] > 10 * row["u_events_drawn"]
    none = replace(ARTICLE, facets="every", must_leave=False)
    missed = infer_slope(ensemble(rules=none), settings, two_axes=False)
    assert not missed["reached"]
    assert missed["largest_restitution"] < 1.0
    assert "slope_sd" not in missed


# Bad inputs


def plain_process(**changes):
    process = constants()
    values = {name: {"kind": "constant", "at": d.at} for name, d in process.distributions.items()}
    return {**values, **changes}


def complaint(kind, values):
    with pytest.raises(ValidationError) as caught:
        build(kind, values)
    lines = explain(caught.value, kind, "monte_carlo.process")
    assert len(lines) == 1, lines
    return lines[0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"slop": {"kind": "constant", "at": 0}}, r"process\.slop: unknown key.*slope"),
        ({"slope": {"kind": "normal", "sd": -0.1}}, r"process\.slope\.sd: -0\.1 .*greater than"),
        ({"slope": {"kind": "uniform", "low": 2.0, "high": 1.0}}, "slope: low must be below high"),
        (
            {"slope": {"kind": "histogram", "edges": [0, 1], "counts": [0]}},
            "slope: counts must not",
        ),
        ({"slope": {"kind": "histogram", "edges": [], "counts": []}}, "slope: edges must be one"),
        ({"slope": {"kind": "sample_file", "path": "no.txt"}}, r"slope\.path: no\.txt: cannot"),
        ({"slope": {"kind": "cauchy"}}, "slope.*cauchy"),
        (
            {"diameter_um": {"kind": "normal", "mean": 62.0, "sd": 20.0}},
            "diameter_um: normal reach",
        ),
        ({"friction": {"kind": "uniform", "low": -0.1, "high": 0.1}}, "friction: uniform reaches"),
    ],
)
def test_bad_processes_are_refused_in_one_line(changes, message):
    assert re.search(message, complaint(Process, plain_process(**changes)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "at least one number"),
        ("# slopes\n\n", "at least one number"),
        ("1.0\n2.0 3.0\n", r"line 2: '2\.0 3\.0' must be one finite number"),
        ("0.1\nabc\n", "line 2: 'abc'"),
        ("nan\n", "line 1: 'nan'"),
    ],
)
def test_malformed_sample_files_are_refused(tmp_path, text, message):
    path = tmp_path / "slopes.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        SampleFile(path=str(path))


def test_sample_file_draws_its_values(tmp_path):
    path = tmp_path / "slopes.txt"
    path.write_text("# tangents of the slope\n0.3\n-0.1  # a scratch\n\n0.1\n")
    found = SampleFile(path=str(path))
    assert found.quantile(np.array([0.1, 0.5, 0.9])).tolist() == [-0.1, 0.1, 0.3]
    values = json.loads(json.dumps(plain_process(slope={"kind": "sample_file", "path": str(path)})))
    assert build(Process, values).slope == found


@pytest.mark.parametrize(
    ("names", "matrix", "message"),
    [
        (("a", "b"), ((1.0, 0.5),), r"2 rows of 2 numbers.*rows of \[2\]"),
        (("a", "b"), ((1.0,), (0.5, 1.0)), r"rows of \[1, 2\]"),
        (("a", "b"), ((1.0, 0.5), (0.4, 1.0)), "symmetric"),
        (("a", "b"), ((2.0, 0.5), (0.5, 1.0)), "ones on its diagonal"),
        (("a", "b"), ((1.0, 1.0), (1.0, 1.0)), "positive definite"),
        (("a", "b"), ((1.0, 1.5), (1.5, 1.0)), "positive definite.*-0.5"),
        (("a", "a"), ((1.0, 0.5), (0.5, 1.0)), "'a' is given more than once"),
    ],
)
def test_bad_correlations_are_refused(names, matrix, message):
    with pytest.raises(ValueError, match=message):
        Correlation(names=names, matrix=matrix)


@pytest.mark.parametrize(
    ("name", "message"), [("slop", "'slop' must be one of"), ("friction", "'friction' is constant")]
)
def test_correlated_parameters_must_be_there_and_vary(name, message):
    correlation = Correlation(names=("slope", name), matrix=((1.0, 0.5), (0.5, 1.0)))
    with pytest.raises(ValueError, match=message):
        replace(ensemble(), correlation=correlation)


@pytest.mark.parametrize("events", [1, 3, 1000])
def test_events_of_a_replicate_are_a_power_of_two(events):
    with pytest.raises(ValueError, match="power of two"):
        Plan(replicates=2, events=events)


def test_a_model_refuses_parameters_it_does_not_have():
    damped = constants(hertz_damping_factor=Uniform(low=0.5, high=1.5))
    with pytest.raises(ValueError, match="hertz_damping_factor: without meaning in the model 'ri"):
        require_meaning("rigid_body", damped)
    require_meaning("simulation", damped)
    moved = constants(restitution_offset=Constant(at=0.1))
    with pytest.raises(ValueError, match=r"restitution_offset: .* must be the constant 0"):
        require_meaning("simulation", moved)


@pytest.fixture(scope="module")
def branch(settings):
    return settings.branches["monte_carlo"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"ablation": {"angles_deg": [20.0], "sources": [{"parameter": "slop"}]}},
            "ablation.sources: 'slop' must be one of speed_m_per_s",
        ),
        (
            {"correlation": {"names": ["slope", "speed"], "matrix": [[1, 0.5], [0.5, 1]]}},
            "correlation.names: 'speed' must be one of speed_m_per_s",
        ),
        (
            {"correlation": {"names": ["slope", "friction"], "matrix": [[1, 0.5], [0.5, 1]]}},
            "correlation.names: 'friction' is constant",
        ),
        (
            {"correlation": {"names": ["slope"], "matrix": [[1, 0.5], [0.5, 1]]}},
            "correlation: matrix must have 1 rows of 1 numbers",
        ),
        ({"model": "simulation"}, "slope_inference.restitution_half_width: must be 0"),
        ({"reference_angle_deg": 84.0}, "reference_angle_deg: 84 must be one of angles_deg, "),
        ({"variants": []}, r"variants: \[\] must hold at least 1"),
    ],
)
def test_bad_parameters_of_the_study_are_refused_in_one_line(branch, changes, message):
    with pytest.raises(ValidationError) as caught:
        build(Params, {**branch, **changes})
    (line,) = explain(caught.value, Params, "monte_carlo")
    assert re.search(message, line), line


@pytest.fixture(scope="module")
def inputs():
    root = ROOT
    return {
        "calibration": pd.read_csv(root / "tests/reference/tables/calibration.csv"),
        "materials": pd.read_csv(root / "config/materials.csv", comment="#"),
    }


def test_a_stream_of_events_estimates_what_the_study_does(branch, inputs):
    params = build(Params, branch)
    arguments = {"variant": "facets by area seen", "angle_deg": 25.0, "events": 3 * BLOCK}
    found = stream(params, inputs, **arguments)
    assert stream(params, inputs, **arguments, threads=2) == found
    table = pd.read_csv(ROOT / "tests/reference/tables/monte_carlo.csv")
    row = table[(table["variant"] == "facets by area seen") & (table["angle_deg"] == 25.0)].iloc[0]
    for name in ("restitution", "impulse_ratio"):
        error = np.hypot(getattr(found, f"{name}_error"), row[f"{name}_error"])
        assert abs(getattr(found, name) - row[name]) < 5.0 * error < 0.05
    assert found.captured == pytest.approx(row["captured_share"], abs=0.01)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variant": "smooth"}, "variant must be one of equal weights, .*, got 'smooth'"),
        ({"events": 0}, "events and threads must be 1 or more, got 0 and 1"),
        ({"threads": 0}, "events and threads must be 1 or more, got 10 and 0"),
    ],
)
def test_bad_streams_are_refused(branch, inputs, changes, message):
    good = {"variant": "equal weights", "angle_deg": 25.0, "events": 10}
    with pytest.raises(ValueError, match=message):
        stream(build(Params, branch), inputs, **good | changes)
