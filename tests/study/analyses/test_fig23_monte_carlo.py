"""Fig. 23: Monte Carlo analysis of impacts on a rough surface, its ensembles and slopes."""

from __future__ import annotations

import re
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import integrate, stats
from tests.shared import facet_rebound

from microimpact.lab.surface import LABORATORY, Rules, Surface, collide, facets
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate
from microimpact.model.rigid_body.roughness import rough_rebound
from microimpact.statistics.distributions import Constant, Normal, Uniform, generator
from study.analyses.fig23_monte_carlo.compute import Params
from study.analyses.fig23_monte_carlo.ensembles import (
    Ensemble,
    Plan,
    Process,
    RigidBody,
    estimate,
    replicate_shares,
    replicate_sums,
    smooth_at_means,
)
from study.analyses.fig23_monte_carlo.slope_inference import SlopeInference, infer_slope
from study.declared.parameters import build, explain

VARIANTS = ("equal weights", "facets by area seen")


@pytest.fixture(scope="module")
def tables(run_study, calibration, settings):
    branch = settings.branches["fig23_monte_carlo"]
    fewer = {"plan": {**branch["plan"], "events": 1024}}
    return run_study("fig23_monte_carlo", calibration, **fewer)


@pytest.fixture(scope="module")
def means(tables):
    return {
        name: part.set_index("angle_deg") for name, part in tables["monte_carlo"].groupby("variant")
    }


def test_subtraction_hides_what_roughness_takes_at_steep_incidence(tables, means):
    # e_m = e - (e + 5/7) phi^2 at normal incidence; the slope is of the order 0.2
    equal = means["equal weights"]
    lost = equal["smooth_restitution"][90.0] - equal["restitution"][90.0]
    slope = tables["slope_inference"].set_index("variant")["slope_sd"]["equal weights"]
    assert lost == pytest.approx((0.7 + 5 / 7) * slope**2, rel=0.15)
    assert equal["relative_restitution"][90.0] == pytest.approx(0.0, abs=0.002)


def test_errors_of_the_curves_are_below_what_can_be_seen(means):
    for name in VARIANTS:
        assert means[name]["relative_restitution_error"].max() < 0.003
        assert means[name]["impulse_ratio_error"].max() < 3e-4
        shares = means[name][[c for c in means[name] if c.endswith("_share")]]
        assert shares.sum(axis=1).to_numpy() == pytest.approx(1.0)


def test_slopes_are_drawn_as_inferred(tables, means):
    found = tables["slope_inference"].set_index("variant")
    # of other random numbers, and from more events than the inference
    for name in VARIANTS:
        assert means[name].loc[20.0, "restitution"] == pytest.approx(1.0, abs=0.005)
    # weighting by area, which favours facets that face the sphere, needs less roughness
    weighted = found.loc["facets by area seen", "slope_sd"]
    assert weighted < 0.8 * found.loc["equal weights", "slope_sd"]
    laboratory = found.loc["as in the virtual laboratory"]
    # 0.16 per axis in the virtual laboratory
    assert laboratory["slope_sd_low"] < 0.16 < laboratory["slope_sd_high"]
    assert laboratory["slope_sd"] > weighted
    # a program that accepts everything finds no roughness that would do
    none = found.loc["equal weights, no rule"]
    assert not none["reached"]
    assert none["largest_restitution"] < 0.85
    assert np.isnan(none["slope_sd"])


def test_declared_slopes_take_the_place_of_inferred_ones(run_study, calibration, tables, settings):
    plan = {**settings.branches["fig23_monte_carlo"]["plan"], "events": 1024}
    sd = tables["slope_inference"].set_index("variant")["slope_sd"]["equal weights"]
    slope = {"kind": "normal", "sd": float(sd)}
    declared = run_study("fig23_monte_carlo", calibration, plan=plan, process={"slope": slope})
    assert declared["slope_inference"].equals(tables["slope_inference"])
    assert set(declared["fig23"]["evidence"]) == {"computed"}
    assert "calibrated" in set(tables["fig23"]["evidence"])
    name = "variant == 'equal weights'"
    same, wider = (
        declared["monte_carlo"].query(f"variant {is_} 'equal weights'") for is_ in ("==", "!=")
    )
    assert same.equals(tables["monte_carlo"].query(name))
    assert wider["restitution"].iloc[0] > 1.2 * tables["monte_carlo"]["restitution"].iloc[21]


def test_the_smooth_surface_is_smooth_whatever_the_slopes(run_study, calibration, tables):
    slope = {"kind": "lognormal", "median": 0.1, "geometric_sd": 1.5}
    plan = {"replicates": 2, "events": 64}
    declared = run_study("fig23_monte_carlo", calibration, plan=plan, process={"slope": slope})
    smooth, same = (each["fig23"].query("series == 'smooth'") for each in (tables, declared))
    assert same["y_1"].to_numpy() == pytest.approx(smooth["y_1"].to_numpy(), rel=1e-12)


# Ensembles: facets, estimates, contacts of rigid spheres, slopes, bad inputs

SEED = 20011
ARTICLE = Rules(facets="facing", must_leave=True, most_contacts=1)
ROUGH = Normal(sd=0.2)


def fixed(**changes):
    """A process in which nothing varies but what is given."""
    at = {"speed_m_per_s": Constant(at=1.66), "diameter_um": Constant(at=62.0)}
    return Process(**at | {"spin_ratio": 0.0, "friction": 0.15} | changes)


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
    """The function that gives ensembles of rigid spheres."""

    def made(process=None, *, of=contact, size=(16, 1024), **changes):
        process = process or fixed()
        fields = {"slope": ROUGH, "two_axes": False, "rules": ARTICLE, "seed": (SEED,)}
        return Ensemble(
            process=process,
            body=RigidBody.of(of, process),
            plan=Plan(replicates=size[0], events=size[1]),
            **fields | changes,
        )

    return made


@pytest.fixture(scope="module")
def frictionless(contact, ensemble):
    """The function that gives ensembles without capture, friction, with one e at all speeds."""
    # Without damping e is 1; the shift makes it any other.
    elastic = contact.replace(work_of_adhesion=1e-6, hertz_damping=0.0, adhesion_damping=1e-9)

    def made(e, sd, rules):
        process = fixed(friction=0.0)
        shift = e - 1.0
        return ensemble(
            process, of=elastic, slope=Normal(sd=sd), rules=rules, restitution_shift=shift
        )

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
    bottom, top, square = (
        integrate.quad(lambda x, n=n: measured(x) ** n * weight(x), low, high, **limits)[0]
        for n in range(3)
    )
    mean = estimate(
        frictionless(e, sd, replace(ARTICLE, facets=facets, must_leave=must_leave)), angle_deg
    )
    assert mean.restitution == pytest.approx(top / bottom, abs=5 * mean.restitution_error + 2e-4)
    sd = np.sqrt(square / bottom - (top / bottom) ** 2)
    assert mean.restitution_sd == pytest.approx(sd, rel=0.01)
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


def test_memory_does_not_grow_with_the_events(ensemble):
    peaks = []
    for replicates in (4, 24):
        many = ensemble(size=(replicates, 2**14))
        tracemalloc.start()
        estimate(many, 20.0)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0] < 50e6


def test_standard_error_is_that_of_repeated_estimates(ensemble):
    # 40 independent estimates scatter as each of them says
    means = [estimate(ensemble(size=(16, 128)), 20.0, key) for key in range(40)]
    claimed = np.sqrt(np.mean([mean.restitution_error**2 for mean in means]))
    assert np.std([mean.restitution for mean in means], ddof=1) == pytest.approx(claimed, rel=0.35)
    # and less than those of independent events, by the root of whose number these would
    accepted = np.mean([mean.accepted for mean in means]) * 16 * 128
    assert claimed < 0.5 * means[0].restitution_sd / np.sqrt(accepted)


def test_small_spreads_give_the_deterministic_rebound(ensemble, contact):
    narrow = fixed(
        speed_m_per_s=Normal(mean=1.66, sd=1e-7),
        diameter_um=Normal(mean=62.0, sd=1e-6),
        spin_ratio=0.1,
    )
    slopes = {"slope": Normal(sd=1e-7), "two_axes": True}
    for rules in (ARTICLE, replace(ARTICLE, facets="seen", most_contacts=3)):
        for angle in (10.0, 45.0, 90.0):
            drawn = ensemble(narrow, rules=rules, **slopes)
            mean, exact = estimate(drawn, angle), estimate(smooth_at_means(drawn), angle)
            assert mean.restitution == pytest.approx(exact.restitution, abs=1e-6)
            assert mean.impulse_ratio == pytest.approx(exact.impulse_ratio, abs=1e-6)
    e = float(simulate(contact, 1.66 * np.sin(np.radians(45.0))).coefficient_of_restitution)
    bare = rough_rebound(np.radians(45.0), 0.0, e, 0.15, 0.1)
    exact = estimate(smooth_at_means(ensemble(narrow, **slopes)), 45.0)
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
    below_capture = estimate(smooth_at_means(ensemble()), 3.0)
    assert np.isnan(below_capture.restitution)
    assert below_capture.captured == 1.0


# Contacts of rigid spheres


def by_mechanics(contact, diameter, friction):
    """Contacts by e of the dynamic simulation, Coulomb's law and the balance of momentum."""

    def strike(which, velocity, spin, normal):
        radius = 0.5e-6 * diameter[which][:, None]
        into = np.vecdot(velocity, normal)[:, None]
        sphere = contact.replace(diameter=1e-6 * diameter[which])
        e = np.asarray(simulate(sphere, -into[:, 0]).coefficient_of_restitution)[:, None]
        support = -(1.0 + e) * into
        slip = velocity - into * normal - np.cross(radius * spin, normal)
        speed = np.linalg.norm(slip, axis=1, keepdims=True)
        impulse = support * normal
        impulse -= np.minimum(friction * support, 2.0 / 7.0 * speed) * slip / speed
        turned = spin - 2.5 * np.cross(normal, impulse) / radius
        return velocity + impulse, turned, e[:, 0] == 0.0

    return strike


@pytest.mark.parametrize("facets", ["seen", "facing", "every"])
@pytest.mark.parametrize("must_leave", [False, True])
@pytest.mark.parametrize(("axes", "most_contacts", "exponent"), [(1, 1, 1.0), (2, 5, 0.0)])
def test_rigid_spheres_obey_mechanics_over_all_their_contacts(
    contact, ensemble, facets, must_leave, axes, most_contacts, exponent
):
    """Events are those of the same shares whose contacts are followed by other means."""
    of = contact.replace(adhesion_rate_exponent=exponent, reference_velocity=1.66)
    speeds, sizes = Uniform(low=0.3, high=1.7), Uniform(low=45.0, high=76.0)
    process = fixed(speed_m_per_s=speeds, diameter_um=sizes, spin_ratio=0.1, friction=0.1)
    rules = Rules(facets=facets, must_leave=must_leave, most_contacts=most_contacts)
    size, two_axes = (2, 256), axes == 2
    drawn = ensemble(process, of=of, rules=rules, two_axes=two_axes, size=size)
    shares = replicate_shares(drawn, 0, 0)
    speed, diameter = speeds.quantile(shares[0]), sizes.quantile(shares[1])
    # Of all shares the middle one has no slope across.
    pairs = shares[2:].reshape(-1, 2, 256) if two_axes else [(shares[2], np.full(256, 0.5))]
    angle = np.radians(12.0)
    before = speed[:, None] * [np.cos(angle), 0.0, -np.sin(angle)]
    spin = (0.1 * speed / (0.5e-6 * diameter))[:, None] * [0.0, 1.0, 0.0]
    surface = Surface(slope=ROUGH, cross_slope=ROUGH, rules=rules)
    rebound = collide(surface, before, spin, pairs, by_mechanics(of, diameter, 0.1))
    change = (rebound.velocity - before)[seen := rebound.observed(rules)]
    e, mu = change[:, 2] / -before[seen, 2] - 1.0, -change[:, 0] / change[:, 2]
    accepted, _, captured, _, *sums = replicate_sums(drawn, 12.0, shares)
    assert (accepted, captured) == (seen.sum(), rebound.kept.sum())
    assert 0 < accepted < 256
    assert sums == pytest.approx([e.sum(), (e**2).sum(), mu.sum(), (mu**2).sum()], rel=1e-7)
    assert most_contacts == 1 or rebound.contacts.max() > 1


def test_the_rigid_body_wants_a_plane_and_a_capture_velocity(contact):
    sizes = fixed(diameter_um=Uniform(low=45.0, high=76.0))
    with pytest.raises(ValueError, match="surface_radius: must be infinite"):
        RigidBody.of(contact.replace(surface_radius=1e-3), sizes)
    with pytest.raises(ValueError, match="have no capture velocity"):
        RigidBody.of(contact, fixed(diameter_um=Uniform(low=5.0, high=62.0)))


def test_inferred_slope_gives_back_the_restitution_it_was_inferred_from(ensemble):
    settings = SlopeInference(
        angle_deg=20.0,
        restitution=1.0,
        angle_half_width_deg=2.5,
        restitution_half_width=0.05,
        plan=Plan(replicates=4, events=512),
    )
    flux = ensemble(rules=replace(ARTICLE, facets="seen"))
    row = infer_slope(flux, settings, 40)
    assert row["reached"]
    again = ensemble(slope=Normal(sd=row["slope_sd"]), rules=flux.rules, size=(32, 512))
    assert estimate(again, 20.0).restitution == pytest.approx(1.0, abs=5e-3)
    assert row["u_slope_sd"] > row["u_events_measured"] > 10 * row["u_events_drawn"]
    none = replace(ARTICLE, facets="every", must_leave=False)
    missed = infer_slope(ensemble(rules=none), settings, 40)
    assert not missed["reached"]
    assert missed["largest_restitution"] < 1.0
    assert "slope_sd" not in missed


# Bad inputs


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
        ({"friction": -0.1}, r"process\.friction: -0\.1 must be greater than or equal to 0"),
    ],
)
def test_bad_processes_are_refused_in_one_line(branch, changes, message):
    with pytest.raises(ValidationError) as caught:
        build(Process, {**branch["process"], **changes})
    (line,) = explain(caught.value, Process, "fig23_monte_carlo.process")
    assert re.search(message, line), line


@pytest.mark.parametrize("events", [1, 3, 1000])
def test_events_of_a_replicate_are_a_power_of_two(events):
    with pytest.raises(ValueError, match="power of two"):
        Plan(replicates=2, events=events)


@pytest.fixture(scope="module")
def branch(settings):
    return settings.branches["fig23_monte_carlo"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reference_angle_deg": 84.0}, "reference_angle_deg: 84 must be one of angles_deg, "),
        ({"variants": {}}, r"variants: \{\} must hold at least 1"),
        ({"variants": {"equal weights": {}}}, "variants: at least one must be drawn"),
    ],
)
def test_bad_parameters_of_the_study_are_refused_in_one_line(branch, changes, message):
    with pytest.raises(ValidationError) as caught:
        build(Params, {**branch, **changes})
    (line,) = explain(caught.value, Params, "fig23_monte_carlo")
    assert re.search(message, line), line
