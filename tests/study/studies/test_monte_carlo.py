"""Monte Carlo analysis: facets, estimates, both models of an impact, slopes, bad inputs."""

from __future__ import annotations

import re
import tracemalloc
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from scipy import integrate, stats
from tests.shared import ROOT, facet_rebound

from microimpact.lab.experiment import Target
from microimpact.lab.surface import LABORATORY, Rules, Surface, facets, rough
from microimpact.model import passes
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate
from microimpact.model.rigid_body.roughness import rough_rebound
from microimpact.statistics.distributions import (
    Constant,
    Histogram,
    LogNormal,
    Normal,
    Sample,
    SampleFile,
    Uniform,
    generator,
)
from study.declared.parameters import build, explain
from study.studies.analyses.monte_carlo import Params, stream
from study.studies.analyses.monte_carlo.ensembles import (
    BLOCK,
    Ensemble,
    Plan,
    Process,
    Struck,
    deterministic,
    estimate,
    long_run,
    replicate_shares,
    replicate_sums,
)
from study.studies.analyses.monte_carlo.impacts import RigidBody, Simulation, require_meaning
from study.studies.analyses.monte_carlo.slope_inference import SlopeInference, infer_slope

SEED = 20011
ARTICLE = Rules(facets="facing", must_leave=True, most_contacts=1)
ROUGH = Normal(sd=0.2)


def constants(**changes):
    zeros = ("angle_offset_deg", "slope", "cross_slope", "spin_ratio", "restitution_offset")
    ones = ("restitution_factor", "work_of_adhesion_factor", "hertz_damping_factor")
    fixed = dict.fromkeys(zeros, Constant(at=0.0))
    fixed |= dict.fromkeys((*ones, "adhesion_damping_factor"), Constant(at=1.0))
    fixed |= {"speed_m_per_s": Constant(at=1.66), "diameter_um": Constant(at=62.0)}
    return Process(**{**fixed, "friction": Constant(at=0.15), **changes})


@pytest.fixture(scope="module")
def contact(steel, silicon):
    """Steel on silicon with v_c = 0.18 m/s."""
    return Contact(
        particle=steel,
        surface=silicon,
        diameter=62e-6,
        work_of_adhesion=3.5,
        hertz_damping=0.0029476912213941297,
        adhesion_damping=1.3915651324806888,
    )


@pytest.fixture(scope="module")
def ensemble(contact):
    """The function that gives ensembles of rigid bodies, or of simulated impacts."""

    def made(process=None, *, rules=ARTICLE, simulation=False, method="plain", size=(16, 1024)):
        process = process or constants(slope=ROUGH)
        impact = Simulation(contact=contact) if simulation else RigidBody.of(contact, process)
        plan = Plan(replicates=size[0], events=size[1], method=method)
        return Ensemble(process=process, rules=rules, impact=impact, plan=plan, seed=(SEED,))

    return made


@pytest.fixture(scope="module")
def frictionless(contact):
    """The function that gives ensembles without capture, friction, or dependence of e on speed."""

    def made(e, sd, rules):
        fixed = {"restitution_factor": 0.0, "restitution_offset": e, "friction": 0.0}
        varied = {name: Constant(at=value) for name, value in fixed.items()}
        process = constants(slope=Normal(sd=sd), **varied)
        impact = RigidBody.of(contact.replace(work_of_adhesion=1e-6), process)
        plan = Plan(replicates=16, events=1024, method="quasi_random")
        return Ensemble(process=process, rules=rules, impact=impact, plan=plan, seed=(SEED,))

    return made


# Facets, whose slopes are their own quantiles.
GIVEN = Surface(
    slope=Uniform(low=0.0, high=1.0),
    cross_slope=Uniform(low=0.0, high=1.0),
    rules=replace(LABORATORY, facets="facing"),
)


def test_planar_facets_reproduce_the_measured_coefficients():
    rng, n = generator(SEED, 8), 500
    angle, zero = rng.uniform(0.05, 1.5, n), np.zeros(n)
    slope = rng.uniform(-0.9, 1.0, n) * angle
    e, friction, spin = rng.uniform(0, 1, n), rng.uniform(0, 0.5, n), rng.normal(0, 0.3, n)
    before = np.stack([np.cos(angle), zero, -np.sin(angle)], axis=1)
    normal = facets(GIVEN, before, np.tan(slope), zero)
    after, _ = facet_rebound(before, np.stack([zero, spin, zero], axis=1), normal, e, friction)
    exact = rough_rebound(angle, slope, e, friction, spin)
    change = after - before
    assert -after[:, 2] / before[:, 2] == pytest.approx(exact.measured_restitution, abs=1e-10)
    ratio = change[:, 0] / change[:, 2]
    assert ratio == pytest.approx(exact.measured_impulse_ratio, rel=1e-9, abs=1e-9)
    assert after[:, 1] == pytest.approx(0.0, abs=1e-15)


def test_facets_in_three_dimensions_obey_mechanics():
    rng, n = generator(SEED, 9), 500
    velocity = rng.normal(size=(n, 3)) * [1.0, 1.0, 0.1] - [0.0, 0.0, 1.0]
    velocity[:, 2] = -np.abs(velocity[:, 2])
    spin, e, friction = rng.normal(size=(n, 3)), rng.uniform(0, 1, n), rng.uniform(0, 0.6, n)
    normal = facets(GIVEN, velocity, rng.uniform(0, 0.3, n), rng.normal(0, 0.2, n))
    hit = np.vecdot(velocity, normal) < 0
    velocity, spin, normal, e, friction = (
        values[hit] for values in (velocity, spin, normal, e, friction)
    )
    after, turned = facet_rebound(velocity, spin, normal, e, friction)
    assert np.vecdot(after, normal) == pytest.approx(-e * np.vecdot(velocity, normal))
    # angular momentum about the point of contact: r n x m v + I omega
    before_l = np.cross(normal, velocity) + 0.4 * spin
    assert np.cross(normal, after) + 0.4 * turned == pytest.approx(before_l, abs=1e-13)
    energy = [
        np.vecdot(v, v) + 0.4 * np.vecdot(w, w) for v, w in ((velocity, spin), (after, turned))
    ]
    assert np.all(energy[1] <= energy[0] * (1 + 1e-12))
    slip = [v - np.vecdot(v, normal)[:, None] * normal - np.cross(w, normal)
            for v, w in ((velocity, spin), (after, turned))]  # fmt: skip
    assert np.all(np.vecdot(*slip) >= -1e-12)
    rolls = np.linalg.norm(slip[1], axis=1) < 1e-12
    impulse = after - velocity
    across = impulse - np.vecdot(impulse, normal)[:, None] * normal
    ratio = np.linalg.norm(across, axis=1) / np.vecdot(impulse, normal)
    assert np.all(ratio[rolls] <= friction[rolls] + 1e-12)
    assert ratio[~rolls] == pytest.approx(friction[~rolls])
    assert 0.05 < rolls.mean() < 0.95


# Estimates


@pytest.mark.parametrize("facets", ["facing", "seen"])
@pytest.mark.parametrize("must_leave", [False, True])
@pytest.mark.parametrize("angle_deg", [10.0, 20.0, 45.0, 85.0])
def test_mean_over_slopes_alone_is_a_known_integral(frictionless, facets, must_leave, angle_deg):
    # e_m = ((1 + e) sin(alpha + 2 phi)/sin(alpha) - (1 - e)) / 2
    e, sd, alpha = 0.7, 0.2, np.radians(angle_deg)

    def measured(x):
        return 0.5 * ((1 + e) * np.sin(alpha + 2 * np.arctan(x)) / np.sin(alpha) - (1 - e))

    def weight(x):
        hit = np.tan(alpha) + x if facets == "seen" else 1.0
        return hit * stats.norm.pdf(x, 0.0, sd)

    low, high = -min(np.tan(alpha), 8 * sd), 8 * sd
    if must_leave:  # alpha + 2 phi at which V_n = 0
        edge = np.arcsin(0.3 / 1.7 * np.sin(alpha))
        low, high = np.tan(0.5 * (edge - alpha)), min(high, np.tan(0.5 * (np.pi - edge - alpha)))
    limits = {"limit": 500, "epsabs": 1e-12}
    top = integrate.quad(lambda x: measured(x) * weight(x), low, high, **limits)[0]
    bottom = integrate.quad(weight, low, high, **limits)[0]
    mean = estimate(
        frictionless(e, sd, replace(ARTICLE, facets=facets, must_leave=must_leave)), angle_deg
    )
    assert mean.restitution == pytest.approx(top / bottom, abs=5 * mean.restitution_error + 2e-4)
    assert mean.restitution_error < 2e-3
    assert mean.captured == 0.0


def test_without_rules_roughness_does_not_raise_restitution(frictionless):
    # over even slopes the mean of sin(alpha + 2 phi) is below sin(alpha)
    none = Rules(facets="every", must_leave=False, most_contacts=1)
    mean = estimate(frictionless(0.7, 0.15, none), 20.0)
    even = integrate.quad(
        lambda x: np.cos(2 * np.arctan(x)) * stats.norm.pdf(x, 0, 0.15), -1.5, 1.5
    )[0]
    assert mean.restitution == pytest.approx(0.5 * (1.7 * even - 0.3), abs=1e-3)
    assert mean.restitution < 0.7
    assert mean.accepted == 1.0


def test_threads_change_no_digit_and_keys_change_the_draws(ensemble):
    base = ensemble(constants(slope=ROUGH, diameter_um=Uniform(low=50.0, high=70.0)), size=(70, 64))
    counted = []
    whole = estimate(base, 20.0, done=counted.append)
    assert estimate(base, 20.0, threads=3) == whole
    assert counted == [70 * 64]
    assert estimate(base, 20.0, 4) != whole


def test_longer_runs_begin_with_shorter_ones_whatever_the_threads(ensemble):
    base = ensemble(size=(2, 64))
    short, long = long_run(base, 4 * BLOCK + 1), long_run(base, 6 * BLOCK)
    assert (short.plan.replicates, long.plan.replicates) == (5, 6)
    shares = [replicate_shares(short, 0, number) for number in range(5)]
    assert estimate(short, 20.0, shares=shares) == estimate(short, 20.0)
    whole = estimate(long, 20.0, shares=[*shares, replicate_shares(long, 0, 5)])
    assert estimate(long, 20.0) == whole
    assert estimate(long, 20.0, threads=2) == whole


def test_memory_does_not_grow_with_the_events(ensemble):
    base = ensemble(size=(2, 64))
    peaks = []
    for events in (8 * BLOCK, 48 * BLOCK):
        tracemalloc.start()
        estimate(long_run(base, events), 20.0)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0] < 50e6


def test_estimates_of_all_methods_agree_and_quasi_random_ones_are_closer(ensemble):
    process = constants(slope=ROUGH, diameter_um=Normal(mean=62.0, sd=2.0))
    means = {
        method: estimate(ensemble(process, method=method, size=(32, 1024)), 20.0)
        for method in ("plain", "antithetic", "quasi_random")
    }
    best, plain = means["quasi_random"], means["plain"]
    for mean in means.values():
        error = np.hypot(mean.restitution_error, best.restitution_error)
        assert abs(mean.restitution - best.restitution) < 4 * error + 1e-12
    assert best.restitution_error < 0.2 * plain.restitution_error
    assert means["antithetic"].restitution_error < 1.2 * plain.restitution_error


def test_standard_error_is_that_of_repeated_estimates(ensemble):
    # 40 independent estimates scatter as each of them says
    means = [estimate(ensemble(size=(16, 128)), 20.0, key) for key in range(40)]
    claimed = np.sqrt(np.mean([mean.restitution_error**2 for mean in means]))
    assert np.std([mean.restitution for mean in means], ddof=1) == pytest.approx(claimed, rel=0.35)
    # and as the scatter of events over the root of their number
    accepted = np.mean([mean.accepted for mean in means]) * 16 * 128
    assert claimed == pytest.approx(means[0].restitution_sd / np.sqrt(accepted), rel=0.15)


def test_small_spreads_give_the_deterministic_rebound(ensemble, contact):
    narrow = constants(
        slope=Normal(sd=1e-7),
        cross_slope=Normal(sd=1e-7),
        speed_m_per_s=Normal(mean=1.66, sd=1e-7),
        diameter_um=Normal(mean=62.0, sd=1e-6),
        spin_ratio=Normal(mean=0.1, sd=1e-8),
    )
    for rules in (ARTICLE, replace(ARTICLE, facets="seen", most_contacts=3)):
        for angle in (10.0, 45.0, 90.0):
            mean, exact = (
                estimate(of, angle)
                for of in (ensemble(narrow, rules=rules), deterministic(ensemble(narrow)))
            )
            assert mean.restitution == pytest.approx(exact.restitution, abs=1e-6)
            assert mean.impulse_ratio == pytest.approx(exact.impulse_ratio, abs=1e-6)
    e = float(simulate(contact, 1.66 * np.sin(np.radians(45.0))).coefficient_of_restitution)
    bare = rough_rebound(np.radians(45.0), 0.0, e, 0.15, 0.1)
    exact = estimate(deterministic(ensemble(narrow)), 45.0)
    assert exact.restitution == pytest.approx(float(bare.measured_restitution), rel=1e-7)
    assert exact.impulse_ratio == pytest.approx(-float(bare.measured_impulse_ratio), rel=1e-6)
    assert exact.restitution_error == 0.0


def test_shares_of_events_add_up_and_rules_reject_what_they_say(ensemble):
    strict, flux, twice, lax = (
        estimate(ensemble(rules=replace(ARTICLE, **changes)), 15.0)
        for changes in ({}, {"facets": "seen"}, {"most_contacts": 5}, {"must_leave": False})
    )
    assert strict.accepted + strict.facing_away + strict.captured + strict.not_leaving == 1.0
    assert min(strict[-4:]) > 0.0
    # P(slope < -tan alpha)
    facing_away = stats.norm.cdf(-np.tan(np.radians(15.0)) / 0.2)
    assert strict.facing_away == pytest.approx(facing_away, abs=0.01)
    assert flux.facing_away == 0.0
    assert max(flux.not_leaving, twice.not_leaving) < strict.not_leaving
    assert twice.accepted > strict.accepted
    assert lax.not_leaving == 0.0
    assert lax.restitution < strict.restitution
    below_capture = estimate(deterministic(ensemble(constants())), 3.0)
    assert np.isnan(below_capture.restitution)
    assert below_capture.captured == 1.0


# Models of an impact


@pytest.mark.parametrize(
    "changes",
    [
        {"diameter_um": Uniform(low=45.0, high=76.0)},
        {"diameter_um": LogNormal(median=62.0, geometric_sd=1.12)},
        {
            "speed_m_per_s": Uniform(low=0.3, high=1.7),
            "work_of_adhesion_factor": Uniform(low=0.9, high=1.1),
            "angle_offset_deg": Normal(sd=3.0),
        },
        {
            "slope": Sample(values_seen=(-0.2, 0.1, 0.1, 0.4)),
            "cross_slope": Histogram(edges=(-0.2, 0.0, 0.1), counts=(1.0, 3.0)),
        },
    ],
)
@pytest.mark.parametrize("facets", ["seen", "facing", "every"])
def test_rigid_bodies_without_friction_are_the_simulation_event_by_event(ensemble, changes, facets):
    """One compiled pass over a table of e, against impacts integrated contact by contact."""
    process = constants(**{"slope": ROUGH, "friction": Constant(at=0.0), **changes})
    for most_contacts, must_leave in ((1, True), (5, True), (5, False)):
        rules = Rules(facets=facets, must_leave=must_leave, most_contacts=most_contacts)
        rigid, simulated = (
            estimate(ensemble(process, rules=rules, simulation=which, size=(4, 256)), 12.0)
            for which in (False, True)
        )
        assert rigid[-4:] == simulated[-4:]
        assert rigid[:6] == pytest.approx(simulated[:6], rel=1e-6, abs=1e-9)


@dataclass(frozen=True)
class Sequential(Struck):
    """Contacts of rigid bodies one after the other: Coulomb's law and the balance of momentum."""

    model: RigidBody

    def __call__(self, draws):
        def strike(which, velocity, spin, normal):
            drawn = {name: values[which] for name, values in draws.items()}
            unit, place = self.model.scales(drawn)
            into = np.vecdot(velocity, normal)
            bare = self.model.law.restitution(-into / unit, place)
            e = np.clip(drawn["restitution_factor"] * bare + drawn["restitution_offset"], 0.0, 1.0)
            radius, friction = 0.5e-6 * drawn["diameter_um"][:, None], drawn["friction"][:, None]
            into, support = into[:, None], (-(1.0 + e) * into)[:, None]
            slip = velocity - into * normal - np.cross(radius * spin, normal)
            speed = np.linalg.norm(slip, axis=1, keepdims=True)
            impulse = support * normal
            impulse -= np.minimum(friction * support, 2.0 / 7.0 * speed) * slip / speed
            turned = spin - 2.5 * np.cross(normal, impulse) / radius
            return velocity + impulse, turned, bare == 0.0

        return strike


@pytest.mark.parametrize("facets", ["seen", "facing", "every"])
@pytest.mark.parametrize("most_contacts", [1, 5])
@pytest.mark.parametrize("must_leave", [False, True])
def test_rigid_bodies_with_friction_and_spin_obey_mechanics_over_all_their_contacts(
    ensemble, facets, most_contacts, must_leave
):
    process = constants(
        speed_m_per_s=Uniform(low=0.5, high=1.7),
        angle_offset_deg=Normal(sd=3.0) if most_contacts == 1 else Constant(at=1.0),
        diameter_um=Uniform(low=45.0, high=76.0),
        slope=Sample(values_seen=(-0.2, 0.1, 0.1, 0.4)) if must_leave else Normal(sd=0.3),
        cross_slope=Histogram(edges=(-0.2, 0.0, 0.1), counts=(1.0, 3.0)),
        spin_ratio=Normal(sd=0.3),
        friction=Sample(values_seen=(0.0, 0.1, 0.3)),
        restitution_factor=Uniform(low=0.8, high=1.2),
        restitution_offset=Constant(at=0.02),
        work_of_adhesion_factor=Uniform(low=0.9, high=1.1),
    )
    rules = Rules(facets=facets, must_leave=must_leave, most_contacts=most_contacts)
    compiled = ensemble(process, rules=rules, size=(4, 1024))
    sequential = replace(compiled, impact=Sequential(compiled.impact))
    for angle in (8.0, 40.0, 90.0):
        found, expected = (estimate(of, angle) for of in (compiled, sequential))
        assert found[-4:] == expected[-4:]
        assert found[:6] == pytest.approx(expected[:6], rel=1e-9)
        assert expected.accepted > 0.0


@pytest.mark.parametrize("exponent", [0.0, 1.0])
def test_the_rigid_body_has_the_restitution_of_the_simulation_at_every_size(contact, exponent):
    rated = contact.replace(adhesion_rate_exponent=exponent, reference_velocity=1.66)
    for diameter in (45.0, 62.0, 76.0):
        for speed in (0.19, 0.4, 1.7):
            process = constants(
                diameter_um=Uniform(low=45.0, high=76.0), speed_m_per_s=Constant(at=speed)
            )
            model = RigidBody.of(rated, process)
            sphere = constants(diameter_um=Constant(at=diameter), speed_m_per_s=Constant(at=speed))
            plan = Plan(replicates=2, events=2)
            of_sphere = Ensemble(
                process=sphere, rules=ARTICLE, impact=model, plan=plan, seed=(SEED,)
            )
            e = simulate(rated.replace(diameter=diameter * 1e-6), speed).coefficient_of_restitution
            mean = estimate(of_sphere, 90.0)
            if e == 0.0:
                assert mean.captured == 1.0
            else:
                assert mean.restitution == pytest.approx(float(e), rel=2e-9)


def test_the_rigid_body_wants_a_plane_and_a_capture_velocity(contact):
    sizes = constants(diameter_um=Uniform(low=45.0, high=76.0))
    with pytest.raises(ValueError, match="surface_radius: must be infinite"):
        RigidBody.of(contact.replace(surface_radius=1e-3), sizes)
    with pytest.raises(ValueError, match="have no capture velocity"):
        RigidBody.of(contact, constants(diameter_um=Uniform(low=5.0, high=62.0)))


def test_the_simulation_of_an_ensemble_is_that_of_single_impacts(ensemble, contact):
    process = constants(friction=Constant(at=0.1), spin_ratio=Constant(at=0.05))
    mean = estimate(deterministic(ensemble(process, simulation=True)), 30.0)
    single = simulate(contact.replace(friction=0.1), 1.66, 30.0, 0.05 * 1.66 / 31e-6)
    assert mean.restitution == pytest.approx(float(single.coefficient_of_restitution), rel=1e-9)
    assert mean.impulse_ratio == pytest.approx(float(single.impulse_ratio), rel=1e-9)


def test_ensembles_by_the_rules_of_the_laboratory_are_its_own_draw_by_draw(ensemble, contact):
    varied = {name: Normal(sd=0.16) for name in ("slope", "cross_slope")}
    process = constants(**varied, spin_ratio=Constant(at=0.1))
    of_laboratory = ensemble(process, rules=LABORATORY, simulation=True, size=(2, 512))
    shares = replicate_shares(of_laboratory, 0, 0)
    sums = replicate_sums(of_laboratory, 20.0, [shares])[0]
    slopes = iter(
        np.stack([shares[name + later] for name in varied])
        for later in ("", *(f", contact {k}" for k in range(2, 6)))
    )
    rng = SimpleNamespace(random=lambda _: next(slopes))
    angle = np.radians(20.0)
    before = np.tile([1.66 * np.cos(angle), 0.0, -1.66 * np.sin(angle)], (512, 1))
    spin = np.tile([0.0, 0.1 * 1.66 / 31e-6, 0.0], (512, 1))
    target = Target(contact=contact.replace(friction=0.15), surface=rough(0.16))
    rebound = target.hit(np.full(512, 62e-6), before, spin, rng)
    change = (rebound.velocity - before)[~rebound.captured]
    e = change[:, 2] / (1.66 * np.sin(angle)) - 1.0
    assert rebound.contacts.max() > 1
    assert 0 < e.size == sums[passes.ACCEPTED] < 512
    assert e.sum() == pytest.approx(sums[passes.E], rel=1e-12)
    assert -np.sum(change[:, 0] / change[:, 2]) == pytest.approx(sums[passes.MU], rel=1e-12)


def test_inferred_slope_gives_back_the_restitution_it_was_inferred_from(ensemble):
    settings = SlopeInference(
        angle_deg=20.0,
        restitution=1.0,
        angle_half_width_deg=2.5,
        restitution_half_width=0.05,
        events_measured=40,
        laboratory_sd=0.16,
        plan=Plan(replicates=4, events=512, method="quasi_random"),
    )
    flux = ensemble(rules=replace(ARTICLE, facets="seen"))
    row = infer_slope(flux, settings, two_axes=False)
    assert row["reached"]
    again = ensemble(
        constants(slope=Normal(sd=row["slope_sd"])),
        rules=flux.rules,
        method="quasi_random",
        size=(32, 512),
    )
    assert estimate(again, 20.0).restitution == pytest.approx(1.0, abs=5e-3)
    assert row["u_slope_sd"] > row["u_events_measured"] > 10 * row["u_events_drawn"]
    none = replace(ARTICLE, facets="every", must_leave=False)
    missed = infer_slope(ensemble(rules=none), settings, two_axes=False)
    assert not missed["reached"]
    assert missed["largest_restitution"] < 1.0
    assert "slope_sd" not in missed


# Bad inputs


def plain_process(**changes):
    laws = constants().distributions
    return {name: {"kind": "constant", "at": law.at} for name, law in laws.items()} | changes


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"slop": {"kind": "constant", "at": 0}}, r"process\.slop: unknown key.*slope"),
        ({"slope": {"kind": "normal", "sd": -0.1}}, r"process\.slope\.sd: -0\.1 .*greater than"),
        ({"slope": {"kind": "uniform", "low": 2.0, "high": 1.0}}, "slope: low must be below high"),
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
    with pytest.raises(ValidationError) as caught:
        build(Process, plain_process(**changes))
    (line,) = explain(caught.value, Process, "monte_carlo.process")
    assert re.search(message, line), line


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# slopes\n\n", "at least one number"),
        ("1.0\n2.0 3.0\n", r"line 2: '2\.0 3\.0' must be one finite number"),
        ("nan\n", "line 1: 'nan'"),
    ],
)
def test_malformed_sample_files_are_refused(tmp_path, text, message):
    path = tmp_path / "slopes.txt"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        SampleFile(path=str(path))


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
            {"ablation": {"angles_deg": [20.0], "sources": {"slop": {}}}},
            "ablation.sources: 'slop' must be one of speed_m_per_s",
        ),
        (
            {"correlation": {"names": ["slope", "speed"], "matrix": [[1, 0.5], [0.5, 1]]}},
            "correlation.names: 'speed' must be one of speed_m_per_s",
        ),
        ({"model": "simulation"}, "slope_inference.restitution_half_width: must be 0"),
        ({"reference_angle_deg": 84.0}, "reference_angle_deg: 84 must be one of angles_deg, "),
        ({"variants": {}}, r"variants: \{\} must hold at least 1"),
    ],
)
def test_bad_parameters_of_the_study_are_refused_in_one_line(branch, changes, message):
    with pytest.raises(ValidationError) as caught:
        build(Params, {**branch, **changes})
    (line,) = explain(caught.value, Params, "monte_carlo")
    assert re.search(message, line), line


@pytest.fixture(scope="module")
def inputs():
    return {
        "calibration": pd.read_csv(ROOT / "tests/reference/tables/calibration.csv"),
        "materials": pd.read_csv(ROOT / "config/materials.csv", comment="#"),
    }


def test_a_stream_of_events_estimates_what_the_study_does(branch, inputs):
    params = build(Params, branch)
    arguments = {"variant": "facets by area seen", "angle_deg": 25.0, "events": 3 * BLOCK}
    mean = stream(params, inputs, **arguments)
    assert stream(params, inputs, **arguments, threads=2) == mean
    table = pd.read_csv(ROOT / "tests/reference/tables/monte_carlo.csv")
    row = table[(table["variant"] == "facets by area seen") & (table["angle_deg"] == 25.0)].iloc[0]
    for name in ("restitution", "impulse_ratio"):
        error = np.hypot(getattr(mean, f"{name}_error"), row[f"{name}_error"])
        assert abs(getattr(mean, name) - row[name]) < 5.0 * error < 0.05
    assert mean.captured == pytest.approx(row["captured_share"], abs=0.01)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variant": "smooth"}, "variant must be one of equal weights, .*, got 'smooth'"),
        ({"events": 0}, "events and threads must be 1 or more, got 0 and 1"),
    ],
)
def test_bad_streams_are_refused(branch, inputs, changes, message):
    good = {"variant": "equal weights", "angle_deg": 25.0, "events": 10}
    with pytest.raises(ValueError, match=message):
        stream(build(Params, branch), inputs, **good | changes)
