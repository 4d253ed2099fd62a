"""The law of normal impacts as a table: the error stated holds, capture is the integrator's."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from microimpact.model.contact_laws import JKR, Hysteresis, MaugisBarquins, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.families import Family, NoTableError
from microimpact.model.law.table import THRESHOLD, tabulate

# In the order of the rows of a table.
QUANTITIES = (
    "coefficient_of_restitution",
    "contact_time",
    "compression_time",
    "maximum_compression",
    "compressive_impulse",
    "peak_net_impulse",
    "hertz_impulse",
)
CAPTURED_TOO = [2, 3]
COUNT = 3000


UNIT = 2.0  # reference velocity in velocity scales
FIXED_LOSS = {"adhesion_rate_exponent": 1.0, "reference_velocity": UNIT}
BARE = {"work_of_adhesion": 0.0}
DRAWN = np.random.default_rng(5).uniform([0.0, 0.0], [0.2, 0.6], (6, 2))
# Damping groups C_H and C_A, other fields, the largest speed in velocity scales, and a tolerance.
KINDS = {
    **{f"C_H {h:.3f}, C_A {a:.3f}": (h, a, {}, 50.0, 1e-9) for h, a in DRAWN},
    "undamped": (0.0, 0.0, {}, 50.0, 1e-9),
    "material damping alone": (0.05, 0.0, {}, 30.0, 1e-9),
    "fixed loss": (0.0, 0.4, FIXED_LOSS, 50.0, 1e-9),
    "fixed loss and material damping": (0.05, 0.4, FIXED_LOSS, 50.0, 1e-9),
    "rate exponent one half": (0.05, 0.4, FIXED_LOSS | {"adhesion_rate_exponent": 0.5}, 50.0, 1e-9),
    "damped attachment": (0.01, 0.1, {"damped_attachment": True}, 5.0, 1e-9),
    # Beyond C_A = 1.163 nothing rebounds; so close to it direct integration has fewer digits.
    "nearly critical": (0.0, 1.15, {}, 300.0, 1e-6),
    "no adhesion": (0.05, 0.3, BARE, 50.0, 1e-9),
    "no adhesion, undamped": (0.0, 0.0, BARE, 50.0, 1e-9),
}


def speeds(contact, most, unit):
    """Speeds from far below capture to ``most`` velocity scales, a third of them close to it."""
    random = np.random.default_rng(1)
    limit = np.asarray(capture_velocity(contact))
    wide = unit * np.exp(random.uniform(np.log(0.05), np.log(most), COUNT))
    near = random.choice([-1.0, 1.0], COUNT) * 10.0 ** random.uniform(-5.0, -0.5, COUNT)
    return np.where(random.random(COUNT) < 0.3, np.where(limit > 0.0, limit, unit), wide) * (
        1.0 + near
    )


def integrated(contact, v):
    """Quantities (7, n) by integration, in the units of a table, and the captured ones."""
    impact = normal_impact(contact, v, ledger=True)
    velocity, length = contact.velocity_scale, contact.equilibrium_compression
    if not np.any(velocity):
        hertz = np.sqrt(contact.hertz_radius) * contact.stiffness
        velocity, length = v, (contact.mass * v**2 / hertz) ** 0.4
    time, impulse = length / velocity, contact.mass * velocity
    units = 1.0, time, time, length, impulse, impulse, impulse
    rows = [getattr(impact, name) / unit for name, unit in zip(QUANTITIES, units, strict=True)]
    return np.array(rows), impact.captured


def errors(law, contact, v):
    """Largest relative difference of all quantities of each impact; verdicts must be the same."""
    values, captured = law.quantities(*law.family.coordinates(contact, v))
    expected, stays = integrated(contact, v)
    assert np.array_equal(captured, stays)
    assert np.all(values[0, captured] == 0.0)
    assert np.array_equal(np.isinf(values[1]), captured)
    with np.errstate(invalid="ignore"):
        differences = np.abs(values / expected - 1.0)
    return np.where(stays, differences[CAPTURED_TOO].max(axis=0), differences.max(axis=0))


def distance(contact, v):
    """Relative distance from capture."""
    limit = np.asarray(capture_velocity(contact))
    return np.where(limit > 0.0, np.abs(v / np.where(limit > 0.0, limit, 1.0) - 1.0), 1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_the_error_stated_bounds_the_error(scaled, kind):
    hertz, adhesion, changes, most, tolerance = KINDS[kind]
    unit = scaled().velocity_scale
    if "reference_velocity" in changes:
        changes = changes | {"reference_velocity": UNIT * unit}
    contact = scaled(hertz, adhesion).replace(**changes)
    v = speeds(contact, most, unit)
    law = tabulate(contact, v.min(), v.max(), tolerance=tolerance)
    assert 0.0 < law.error <= tolerance
    x, differences = distance(contact, v), errors(law, contact, v)
    assert np.max(differences[x >= THRESHOLD]) <= law.error
    # Closer to capture both are integrated, from speeds that rounding makes differ.
    assert np.all(differences[x < THRESHOLD] <= 1e-4 * tolerance / x[x < THRESHOLD])


@pytest.mark.parametrize("exponent", [0.0, 0.5])
def test_damping_that_is_the_same_serves_many_diameters(contact, exponent):
    unit = contact.velocity_scale
    spheres = contact.replace(
        adhesion_rate_exponent=exponent,
        reference_velocity=3.0 * unit,
        diameter=np.random.default_rng(3).uniform(50e-6, 75e-6, COUNT),
    )
    v = speeds(spheres, 20.0, unit)
    law = tabulate(spheres, v.min(), v.max())
    assert not law.family.alike
    away = distance(spheres, v) >= THRESHOLD
    assert np.max(errors(law, spheres, v)[away]) <= law.error <= 1e-9


def test_a_fixed_loss_is_the_same_for_all_diameters_works_and_speeds_in_scales(contact):
    # n = 1: C_A = c_A v_N/w, in which neither r nor w_A is left; and C_H = 0.
    rated = contact.replace(
        adhesion_damping=1.6, hertz_damping=0.0, adhesion_rate_exponent=1.0, reference_velocity=0.05
    )
    sizes = np.array([5e-6, 20e-6, 300e-6])
    assert Family.of(rated.replace(diameter=sizes, work_of_adhesion=np.array([0.1, 1, 2]))).alike
    assert not Family.of(rated.replace(diameter=sizes, hertz_damping=0.01)).alike
    v = np.geomspace(0.01, 1.0, COUNT)
    spheres = rated.replace(diameter=np.resize(sizes, COUNT))
    law = tabulate(spheres, v.min(), v.max())
    assert np.max(errors(law, spheres, v)) <= law.error


def test_equal_groups_at_different_damping_are_one_family(scaled):
    bare = scaled().replace(diameter=np.array([20e-6, 60e-6]))
    assert Family.of(bare.replace(adhesion_damping=0.3 / bare.velocity_scale)).alike
    with pytest.raises(NoTableError, match="must be the same"):
        Family.of(bare.replace(adhesion_damping=np.array([0.1, 0.3]) / bare.velocity_scale))


def test_restitution_rises_from_zero_as_the_square_root_at_the_threshold(scaled):
    contact = scaled(0.02, 0.3)
    x = np.geomspace(1e-12, 0.5, 4000)
    v = float(capture_velocity(contact)) * (1.0 + x)
    e = tabulate(contact, v.min(), v.max()).simulate(v).coefficient_of_restitution
    assert np.all(np.diff(e) > -1e-9 * e[1:])
    near = (x > 1e-9) & (x < 1e-3)
    assert e[near] / np.sqrt(x[near]) == pytest.approx(e[near][-1] / np.sqrt(x[near][-1]), rel=5e-3)


def test_a_wrong_piece_shows(scaled):
    contact = scaled(0.02, 0.3)
    v = speeds(contact, 20.0, contact.velocity_scale)
    v = v[distance(contact, v) >= THRESHOLD]
    good = tabulate(contact, v.min(), v.max())
    for name in ("rebounds", "captures"):
        table = getattr(good, name)
        for piece in (1, table.pieces // 2):
            coefficients = table.coefficients.copy()
            coefficients[0, piece, 0, 2] *= 1.0 + 1e-4
            bad = replace(good, **{name: replace(table, coefficients=coefficients)})
            assert np.max(errors(bad, contact, v)) > good.error


def test_pieces_do_not_depend_on_the_speeds_asked_for_and_beyond_them_is_integration(scaled):
    contact = scaled(0.02, 0.3)
    unit = contact.velocity_scale
    v = unit * np.geomspace(2.0, 3.0, 100)
    narrow = tabulate(contact, v.min(), v.max())
    wide = tabulate(contact, v.min(), 20.0 * v.max())
    coordinates = narrow.family.coordinates(contact, v)
    assert np.array_equal(narrow.quantities(*coordinates)[0], wide.quantities(*coordinates)[0])
    assert np.max(errors(narrow, contact, unit * np.array([1e-4, 1e-2, 50.0, 400.0]))) < 1e-12


# Oblique impacts, and what cannot be tabulated

LAWS = (
    JKR(),
    JKR(viscous_time=3e-9),
    ThorntonNing(yield_pressure=2e9),
    Hysteresis(unloading_work=4.0),
    MaugisBarquins(edge_speed=0.5, edge_exponent=0.96),
)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.name}{law.parameters}")
def test_a_table_over_sizes_by_another_law_is_integration(contact, law):
    contact = contact.by_law(law, 0.5).replace(diameter=np.geomspace(40e-6, 80e-6, 5))
    tolerance = 1e-4 if isinstance(law, ThorntonNing) else 1e-6
    table = tabulate(contact, 1e-3, 20.0, tolerance)
    speed = np.geomspace(2e-3, 19.0, 300)[:, None]
    found, expected = table.simulate(speed, 60.0), simulate(contact, speed, 60.0)
    assert np.array_equal(found.captured, expected.captured)
    assert table.error <= tolerance
    for name in ("coefficient_of_restitution", "maximum_compression", "contact_time"):
        rebounds = ~expected.captured
        exact, value = (getattr(i, name)[rebounds] for i in (expected, found))
        assert np.all(np.abs(value - exact) <= found.interpolation_error[rebounds] * exact)
    found, expected = table.simulate(speed, 15.0), simulate(contact, speed, 15.0)
    slides = ~expected.rolling
    assert np.count_nonzero(slides) > 500
    error = np.abs(found.impulse_ratio / expected.impulse_ratio - 1.0)[slides]
    assert np.all(error <= 2.0 * found.interpolation_error[slides])
    with pytest.raises(ValueError, match=r"'pull-off' (is not in a table|does not go with)"):
        table.simulate(1.0, 60.0, friction_basis="pull-off")


@pytest.mark.parametrize("basis", ["compressive", "hertz", "net"])
@pytest.mark.parametrize(
    "kind", ["one", "several sizes", "no adhesion", "undamped", "beyond the table"]
)
def test_a_pass_is_simulation_whatever_the_contacts_and_shapes(contact, kind, basis):
    spheres = contact.replace(diameter=np.array([50e-6, 60e-6, 75e-6]), friction=[0.1, 0.2, 0.3])
    if kind == "one":
        spheres = contact
    if kind == "no adhesion":
        spheres = spheres.replace(work_of_adhesion=0.0)
    if kind == "undamped":
        spheres = spheres.replace(work_of_adhesion=0.0, hertz_damping=0.0)
    motion = np.geomspace(0.05, 5.0, 40)[:, None, None], np.array([[7.0], [90.0]]), -1e3, basis
    law = tabulate(spheres, 0.5 if kind == "beyond the table" else 0.001, 5.0)
    found, expected = law.simulate(*motion), simulate(spheres, *motion)
    error = np.max(found.interpolation_error)
    assert 0.0 < error < 1e-8
    assert expected.interpolation_error == 0.0
    for field in fields(expected):
        value, exact = getattr(found, field.name), np.asarray(getattr(expected, field.name))
        if exact.dtype == bool:
            assert np.array_equal(value, exact)
        elif field.name != "interpolation_error":
            # Energies and velocities after impact are differences of numbers of this accuracy.
            scale = np.nanmax(np.abs(exact[exact < np.inf]))
            assert value == pytest.approx(exact, rel=1e-7, abs=1e-9 * scale)
        if field.name != "partner_spin":
            assert np.shape(value) in {np.shape(exact), (40, 2, 3), (40, 2, 1)}


def test_threads_change_no_outcome(contact):
    speed, law = np.geomspace(0.05, 5.0, 100_000), tabulate(contact, 0.02, 5.0)
    alone, shared = (law.simulate(speed, 30.0, threads=n) for n in (1, 3))
    for field in fields(alone):
        np.testing.assert_array_equal(getattr(alone, field.name), getattr(shared, field.name))


@pytest.mark.parametrize("threads", [math.nan, 0, -1, 2.5, True])
def test_threads_are_a_whole_number(contact, threads):
    with pytest.raises((TypeError, ValueError), match=r"^threads must be"):
        tabulate(contact, 0.02, 5.0).simulate(1.0, threads=threads)


def test_rounding_is_part_of_the_error_of_what_the_table_gives(contact):
    limit = float(capture_velocity(contact))
    excess = np.array([-0.01, 0.004, 0.3])
    law = tabulate(contact, 0.5 * limit, 2.0 * limit)
    error = law.simulate(limit * (1.0 + excess)).interpolation_error
    assert error - law.error == pytest.approx(2e-14 / np.abs(excess), rel=1e-3)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_stated_error_grows_towards_capture_as_rounding_does(contact, side):
    limit = float(capture_velocity(contact))
    v = limit * (1.0 + side * np.geomspace(1e-13, 0.1, 2000))
    law = tabulate(contact, 0.5 * limit, 2.0 * limit)
    found, expected = law.simulate(v), simulate(contact, v)
    same = found.captured == expected.captured
    # Verdicts may differ within rounding of the threshold alone.
    assert np.all(np.abs(v[~same] / limit - 1.0) < 1e-12)
    assert np.all(found.interpolation_error[~same] > 1e-3)
    kept = same & ~expected.captured
    quotient = found.coefficient_of_restitution[kept] / expected.coefficient_of_restitution[kept]
    assert np.all(np.abs(quotient - 1.0) <= found.interpolation_error[kept])
    assert found.interpolation_error[0] > 1e3 * found.interpolation_error[-1]
    near = law.simulate(limit * (1.0 + side * 1e-10))
    assert near.interpolation_error == pytest.approx(2e-4, rel=1e-2)


def test_what_cannot_be_tabulated_is_refused(scaled):
    unit = scaled().velocity_scale
    for contact, message in (
        (scaled(0.0, 1.3), "at no speed does a sphere"),
        # The force at first touch changes its sign with the speed: impulses have a kink.
        (scaled(0.0, 0.3, damped_attachment=True), "no table reaches the tolerance 1e-09"),
        (scaled(0.001, 0.1).replace(diameter=np.geomspace(1e-5, 1e-3, 9)), "no table reaches"),
        (scaled().replace(work_of_adhesion=np.array([0.0, 0.5])), "or zero, for all impacts"),
        (
            scaled(np.array([0.0, 0.1]), 0.0).replace(work_of_adhesion=0.0),
            "hertz_damping must be positive, or zero",
        ),
    ):
        with pytest.raises(NoTableError, match=message):
            tabulate(contact, 0.5 * unit, 20.0 * unit)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 1.0), "slowest"),
        ((2.0, 1.0), "fastest"),
        ((0.1, 1.0, -1e-9), "tolerance"),
        ((0.1, 1.0, 10.0), "tolerance"),
    ],
)
def test_bad_ranges_are_refused_by_name(contact, arguments, message):
    with pytest.raises(ValueError, match=message):
        tabulate(contact, *arguments)


def test_a_law_integrates_impacts_of_spheres_it_was_not_made_for(contact):
    law = tabulate(contact.replace(diameter=np.array([50e-6, 60e-6])), 0.5, 0.5)
    others, speed = contact.replace(diameter=np.array([40e-6, 55e-6, 90e-6])), np.full(3, 0.5)
    assert np.all(errors(law, others, speed) < [1e-12, law.error, 1e-12])
    w, place = law.family.coordinates(others, speed)
    assert np.array_equal(np.abs(place) > 1.0, [True, False, True])
    e = normal_impact(others, speed).coefficient_of_restitution
    np.testing.assert_allclose(law.restitution(w, place), e, rtol=1e-9)
