"""The law of normal impacts as a table: the error stated holds, capture is the integrator's."""

from dataclasses import fields, replace

import numpy as np
import pytest

from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate, spatial
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.families import Family, NoTableError
from microimpact.model.law.table import THRESHOLD, tabulate

QUANTITIES = (
    "coefficient_of_restitution",
    "contact_time",
    "compression_time",
    "maximum_compression",
    "compressive_impulse",
    "peak_net_impulse",
    "hertz_impulse",
)
CAPTURED_TOO = ("compression_time", "maximum_compression")
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


def speeds(contact, most, seed=1, unit=None):
    """Speeds from far below capture to ``most`` velocity scales, a third of them close to it."""
    random = np.random.default_rng(seed)
    unit = contact.velocity_scale if unit is None else unit
    limit = np.asarray(capture_velocity(contact))
    wide = unit * np.exp(random.uniform(np.log(0.05), np.log(most), COUNT))
    near = random.choice([-1.0, 1.0], COUNT) * 10.0 ** random.uniform(-5.0, -0.5, COUNT)
    return np.where(random.random(COUNT) < 0.3, np.where(limit > 0.0, limit, unit), wide) * (
        1.0 + near
    )


def errors(found, expected):
    """Largest relative difference of all quantities of each impact; verdicts must be the same."""
    assert np.array_equal(found.captured, expected.captured)
    differences = np.zeros(found.captured.shape)
    for name in QUANTITIES:
        kept = np.ones_like(found.captured) if name in CAPTURED_TOO else ~found.captured
        quotient = getattr(found, name)[kept] / getattr(expected, name)[kept]
        differences[kept] = np.maximum(differences[kept], np.abs(quotient - 1.0))
    return differences


def worst(found, expected):
    return np.max(errors(found, expected))


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
    v = speeds(contact, most, unit=unit)
    law = tabulate(contact, v.min(), v.max(), tolerance=tolerance)
    assert 0.0 < law.error <= tolerance
    found = law.normal_impact(contact, v)
    x = distance(contact, v)
    differences = errors(found, normal_impact(contact, v, ledger=True))
    assert np.max(differences[x >= THRESHOLD]) <= law.error
    # Closer to capture both are integrated, from speeds that rounding makes differ.
    assert np.all(differences[x < THRESHOLD] <= 1e-4 * tolerance / x[x < THRESHOLD])
    assert np.all(found.coefficient_of_restitution[found.captured] == 0.0)
    assert np.all(np.isinf(found.contact_time[found.captured]))
    assert np.all(np.isfinite(found.contact_time[~found.captured]))


@pytest.mark.parametrize("exponent", [0.0, 0.5])
def test_damping_that_is_the_same_serves_many_diameters(contact, exponent):
    random = np.random.default_rng(3)
    unit = contact.velocity_scale
    spheres = contact.replace(
        adhesion_rate_exponent=exponent,
        reference_velocity=3.0 * unit,
        diameter=random.uniform(50e-6, 75e-6, COUNT),
        friction=random.uniform(0.1, 0.2, COUNT),
    )
    v = speeds(spheres, 20.0, unit=unit)
    law = tabulate(spheres, v.min(), v.max())
    assert not law.family.alike
    found, expected = law.normal_impact(spheres, v), normal_impact(spheres, v, ledger=True)
    away = distance(spheres, v) >= THRESHOLD
    assert np.max(errors(found, expected)[away]) <= law.error <= 1e-9


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
    expected = normal_impact(spheres, v, ledger=True)
    assert worst(law.normal_impact(spheres, v), expected) <= law.error


def test_equal_groups_at_different_damping_are_one_family(scaled):
    sizes = np.array([20e-6, 60e-6])
    bare = scaled().replace(diameter=sizes)
    same = bare.replace(adhesion_damping=0.3 / bare.velocity_scale)
    assert Family.of(same).alike
    with pytest.raises(NoTableError, match="must be the same"):
        Family.of(bare.replace(adhesion_damping=np.array([0.1, 0.3]) / bare.velocity_scale))


def test_restitution_rises_from_zero_as_the_square_root_at_the_threshold(scaled):
    contact = scaled(0.02, 0.3)
    limit = float(capture_velocity(contact))
    x = np.geomspace(1e-12, 0.5, 4000)
    v = limit * (1.0 + x)
    e = tabulate(contact, v.min(), v.max()).normal_impact(contact, v).coefficient_of_restitution
    rising = np.diff(e) > -1e-9 * e[1:]
    assert np.all(rising)
    near = (x > 1e-9) & (x < 1e-3)
    assert e[near] / np.sqrt(x[near]) == pytest.approx(e[near][-1] / np.sqrt(x[near][-1]), rel=5e-3)


def test_a_wrong_piece_shows(scaled):
    contact = scaled(0.02, 0.3)
    v = speeds(contact, 20.0)
    v = v[distance(contact, v) >= THRESHOLD]
    good = tabulate(contact, v.min(), v.max())
    expected = normal_impact(contact, v, ledger=True)
    for name in ("rebounds", "captures"):
        table = getattr(good, name)
        for piece in (1, table.pieces // 2):
            coefficients = table.coefficients.copy()
            coefficients[0, piece, 0, 2] *= 1.0 + 1e-4
            bad = replace(good, **{name: replace(table, coefficients=coefficients)})
            assert worst(bad.normal_impact(contact, v), expected) > good.error


def test_pieces_do_not_depend_on_the_speeds_asked_for(scaled):
    contact = scaled(0.02, 0.3)
    v = contact.velocity_scale * np.geomspace(2.0, 3.0, 100)
    narrow = tabulate(contact, v.min(), v.max()).normal_impact(contact, v)
    wide = tabulate(contact, v.min(), 20.0 * v.max()).normal_impact(contact, v)
    for name in QUANTITIES:
        assert np.array_equal(getattr(narrow, name), getattr(wide, name))


def test_speeds_beyond_the_table_are_integrated(scaled):
    contact = scaled(0.02, 0.3)
    unit = contact.velocity_scale
    law = tabulate(contact, unit, 2.0 * unit)
    v = unit * np.array([1e-4, 1e-2, 50.0, 400.0])
    found, expected = law.normal_impact(contact, v), normal_impact(contact, v, ledger=True)
    assert worst(found, expected) < 1e-12


@pytest.mark.parametrize(
    "change",
    [
        {"hertz_damping": 0.5},
        {"adhesion_damping": 0.5},
        {"adhesion_rate_exponent": 0.5, "reference_velocity": 1.0},
        {"damped_attachment": True},
        {"work_of_adhesion": 0.0},
    ],
)
@pytest.mark.parametrize("kind", ["one V", "several V", "no adhesion"])
def test_tables_of_other_contacts_are_refused(scaled, kind, change):
    own = scaled(0.02, 0.3)
    if kind == "several V":
        own = own.replace(diameter=own.diameter * np.array([0.9, 1.1]))
    if kind == "no adhesion":
        own, change = own.replace(work_of_adhesion=0.0), {"work_of_adhesion": 0.1}
    speed = own.velocity_scale * 5.0 + 1.0
    law = tabulate(own, np.min(speed), np.max(speed))
    law.normal_impact(own, speed)
    with pytest.raises(NoTableError, match="damping must be those"):
        law.normal_impact(own.replace(**change), speed)


def test_near_the_threshold_verdicts_are_the_integrators(scaled):
    contact = scaled(0.02, 0.3)
    limit = float(capture_velocity(contact))
    v = limit * (1.0 + np.linspace(-2.0, 2.0, 401) * THRESHOLD)
    found = tabulate(contact, v.min(), v.max()).normal_impact(contact, v)
    assert np.array_equal(found.captured, normal_impact(contact, v).captured)
    assert 100 < found.captured.sum() < 300


# Oblique impacts, and what cannot be tabulated


@pytest.mark.parametrize("basis", ["compressive", "hertz", "net"])
def test_oblique_impacts_agree_to_the_stated_error(contact, basis):
    arguments = np.geomspace(0.05, 5.0, 500), 25.0, 1e3, basis
    found, expected = (
        tabulate(contact, 0.02, 5.0).simulate(*arguments),
        simulate(contact, *arguments),
    )
    error = np.max(found.interpolation_error)
    assert 0.0 < error < 1e-9
    assert expected.interpolation_error == 0.0
    # Energies and velocities after impact are differences of numbers of this accuracy.
    for field in fields(expected):
        if field.name != "interpolation_error":
            one, other = getattr(found, field.name), getattr(expected, field.name)
            assert one == pytest.approx(other, rel=1e3 * error)


@pytest.mark.parametrize("kind", ["several sizes", "no adhesion", "undamped", "beyond the table"])
def test_a_pass_is_simulation_whatever_the_contacts_and_shapes(contact, kind):
    spheres = contact.replace(diameter=np.array([50e-6, 60e-6, 75e-6]), friction=[0.1, 0.2, 0.3])
    if kind == "no adhesion":
        spheres = spheres.replace(work_of_adhesion=0.0)
    if kind == "undamped":
        spheres = spheres.replace(work_of_adhesion=0.0, hertz_damping=0.0)
    arguments = np.geomspace(0.05, 5.0, 40)[:, None, None], np.array([[7.0], [90.0]]), -1e3
    law = tabulate(spheres, 0.5 if kind == "beyond the table" else 0.001, 2.0)
    found, expected = law.simulate(*arguments), simulate(spheres, *arguments)
    assert np.max(found.interpolation_error) < 1e-8
    for field in fields(expected):
        one, other = getattr(found, field.name), np.asarray(getattr(expected, field.name))
        assert np.shape(one) == (40, 2, 3) or field.name in {"interpolation_error", "partner_spin"}
        if other.dtype == bool:
            assert np.array_equal(one, other)
        elif field.name != "interpolation_error":
            assert one == pytest.approx(
                other, rel=1e-7, abs=1e-9 * np.nanmax(np.abs(other[other < np.inf]))
            )


def test_threads_change_no_outcome(contact):
    speed = np.geomspace(0.05, 5.0, 100_000)
    law = tabulate(contact, 0.02, 5.0)
    for run in (
        lambda threads: law.simulate(speed, 30.0, threads=threads),
        lambda threads: law.normal_impact(contact, speed, threads=threads),
    ):
        alone, shared = run(1), run(3)
        for field in fields(alone):
            np.testing.assert_array_equal(getattr(alone, field.name), getattr(shared, field.name))


def test_impacts_in_space_agree_too(contact):
    velocity = np.stack(np.broadcast_arrays(0.3, -0.2, -np.geomspace(0.05, 5.0, 200)), axis=-1)
    law = tabulate(contact, 0.05, 5.0)
    found, expected = spatial(contact, velocity, law=law.normal_impact), spatial(contact, velocity)
    assert np.max(found.interpolation_error) < 1e-9
    assert found.velocity == pytest.approx(expected.velocity, rel=1e-8)
    assert found.spin == pytest.approx(expected.spin, rel=1e-8)


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
    near = np.array([limit * (1.0 + side * 1e-10)])
    for error in (law.simulate(near), law.normal_impact(contact, near)):
        assert error.interpolation_error == pytest.approx(2e-4, rel=1e-2)


def test_what_cannot_be_tabulated_is_refused(scaled):
    unit = scaled().velocity_scale
    slowest, fastest = 0.5 * unit, 20.0 * unit
    with pytest.raises(ValueError, match="at no speed does a sphere"):
        tabulate(scaled(0.0, 1.3), slowest, fastest)
    # The force at first touch changes its sign with the speed: impulses have a kink.
    with pytest.raises(ValueError, match="no table reaches the tolerance 1e-09"):
        tabulate(scaled(0.0, 0.3, damped_attachment=True), slowest, fastest)
    with pytest.raises(ValueError, match="no table reaches"):
        tabulate(scaled(0.001, 0.1).replace(diameter=np.geomspace(10e-6, 1e-3, 9)), unit, unit)
    with pytest.raises(ValueError, match="or zero, for all impacts"):
        Family.of(scaled().replace(work_of_adhesion=np.array([0.0, 0.5])))
    mixed = scaled(np.array([0.0, 0.1]), 0.0).replace(work_of_adhesion=0.0)
    with pytest.raises(ValueError, match="hertz_damping must be positive, or zero"):
        Family.of(mixed)


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
    spheres = contact.replace(diameter=np.array([50e-6, 60e-6]))
    law = tabulate(spheres, 0.5, 0.5)
    others = contact.replace(diameter=np.array([40e-6, 55e-6, 90e-6]))
    found, exact = law.normal_impact(others, 0.5), normal_impact(others, 0.5)
    difference = found.coefficient_of_restitution / exact.coefficient_of_restitution - 1.0
    assert np.all(np.abs(difference) < [1e-13, law.error, 1e-13])
    w, place = law.family.coordinates(others, np.full(3, 0.5))
    assert np.array_equal(np.abs(place) > 1.0, [True, False, True])
    np.testing.assert_allclose(
        law.restitution(w, place), exact.coefficient_of_restitution, rtol=1e-9
    )
