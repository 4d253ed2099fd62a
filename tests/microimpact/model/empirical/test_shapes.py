"""Tables of e over v/v_c: what they hold, and what searches in them find."""

import numpy as np
import pytest

from microimpact.model.contact_laws import JKR, Hysteresis, MaugisBarquins, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical import shapes
from microimpact.model.empirical.comparison import compare_models
from microimpact.model.empirical.data import in_own_units
from microimpact.model.posterior import calibrate_laws

NO_STARTS = np.empty((0, 0, 0))
RATIO = np.geomspace(1.001, 300.0, 40)
OTHERS = {
    "viscous JKR": JKR(viscous_time=10.5e-9),
    "Thornton-Ning": ThorntonNing(yield_pressure=1e9),
    "hysteresis": Hysteresis(unloading_work=5.0),
}


@pytest.mark.parametrize("name", [name for name, law in shapes.LAWS.items() if law.contact])
def test_between_its_places_a_table_is_the_integration(name):
    law, grid = shapes.LAWS[name], shapes.table(name)
    for shares in ((0.33, 0.43, 0.61), (0.77, 0.72, 0.27), (0.05, 0.91, 0.14)):
        at = np.array(shares) * (np.array(grid.shape[:3]) - 1.0)
        first, last, _ = law.exponents
        rate = first + shares[0] * (last - first)
        numbers = [
            np.array([first * (last / first) ** share])
            for share, (first, last, _) in zip(shares[1:], law.axes, strict=True)
        ]
        contact = law.contact(*numbers, rate)
        limit = capture_velocity(contact)
        if contact.law is None:
            contact = contact.replace(adhesion_rate_exponent=rate, reference_velocity=limit)
        exact = simulate(contact, limit * RATIO).coefficient_of_restitution
        assert np.allclose(shapes.restitution(name, at, RATIO), exact, atol=2e-3)


def test_a_fixed_loss_is_its_closed_form_and_nothing_leaves_below_v_c():
    ratio = np.array([0.5, 1.0, 1.5, 30.0])
    at = np.array([0.0, 0.73 * (shapes.ONE - 1), 0.0])
    e = shapes.restitution("fixed loss", at, ratio)
    kept = 0.01 ** (1.0 - 0.73)
    assert np.allclose(e, kept * np.sqrt(1.0 - np.maximum(ratio, 1.0) ** -2), atol=1e-5)


def held(name, v, e, weight, v_c):
    """Search with these v_c held, in the unit of v."""
    data = in_own_units(v[None], e[None], np.full((1, v.size), weight), None)
    return shapes.profile(name, data, np.zeros(v_c.size, int), v_c / data.unit, NO_STARTS)


def test_the_edge_is_tried_where_it_is_named(contact):
    """Its capture velocity and the exponent of that in d; the average of all is without it."""
    law = MaugisBarquins(edge_speed=0.05, edge_exponent=0.75, viscous_time=9e-9)
    other = contact.by_law(law, 0.1)
    limit = float(capture_velocity(other))
    speed = limit * np.geomspace(1.05, 15.0, 20)
    e = simulate(other, speed).coefficient_of_restitution
    best, _ = compare_models(speed, e, 0.01, models=[shapes.EDGE, "ring force"]).models
    assert best.name == shapes.EDGE
    assert best.interval[0] < limit < best.interval[1]
    sizes = other.replace(diameter=other.diameter * np.array([1.0, 1.02]))
    exponent = np.diff(np.log(capture_velocity(sizes)))[0] / np.log(1.02)
    assert best.size_exponent == pytest.approx(exponent, abs=0.05)
    assert shapes.EDGE not in {m.name for m in compare_models(speed, e, 0.01).models}
    drawn = calibrate_laws(contact, speed, e, 0.01, laws=[shapes.EDGE], draws=40)
    low, high = np.quantile(drawn.of_all(capture_velocity), [0.01, 0.99])
    assert low < limit < high
    fitted = simulate(drawn.best[shapes.EDGE], speed).coefficient_of_restitution
    assert np.allclose(fitted, e, atol=0.02)
    with pytest.raises(ValueError, match="laws: 'fixed loss' must be one of"):
        calibrate_laws(contact, speed, e, laws=["fixed loss"])


@pytest.mark.parametrize("name", OTHERS)
def test_materials_and_size_do_not_matter(contact, name):
    """A law found again from impacts of quite another sphere, without noise."""
    other = contact.replace(hertz_damping=0.0, adhesion_damping=0.0, law=OTHERS[name])
    limit = float(capture_velocity(other))
    ratio = np.geomspace(1.05, 15.0, 20)
    e = simulate(other, limit * ratio).coefficient_of_restitution
    found = held(name, ratio, e, 1e2, np.array([0.98, 1.0, 1.02]))
    assert found.value.argmin() == 1
    assert found.value[1] < 0.1
    compared = compare_models(limit * ratio, e, 0.01)
    assert compared.v_c_interval[0] < limit < compared.v_c_interval[1]
    assert next(m.v_c for m in compared.models if m.name == name) == pytest.approx(limit, rel=0.01)


def test_a_rate_exponent_between_places_is_found(contact):
    limit = float(capture_velocity(contact))
    rated = contact.replace(adhesion_rate_exponent=1.4, reference_velocity=limit)
    ratio = np.geomspace(1.05, 15.0, 20)
    e = simulate(rated, limit * ratio).coefficient_of_restitution
    found = held("ring force", ratio, e, 1e3, np.array([1.0]))
    assert found.value[0] < 0.1
    rates = shapes.LAWS["ring force"].values[0]
    assert np.interp(found.x[0, 0], np.arange(rates.size), rates) == pytest.approx(1.4, abs=0.01)


def test_a_search_ends_where_no_place_nearby_is_better(contact):
    name = "ring force"
    ratio = np.geomspace(1.1, 12.0, 15)
    e = np.clip(0.8 * np.sqrt(1.0 - ratio**-2) + 0.02 * np.cos(5.0 * ratio), 0.0, 1.0)
    found = held(name, ratio, e, 50.0, np.array([0.99]))

    def chi_square(at):
        return np.sum(np.square((shapes.restitution(name, at, ratio / 0.99) - e) * 50.0))

    best = chi_square(found.x[0, :3])
    assert best == pytest.approx(found.value[0])
    ends = np.array(shapes.table(name).shape[:3]) - 1.0
    for step in 0.05 * np.concatenate([np.eye(3), -np.eye(3)]):
        assert chi_square(np.clip(found.x[0, :3] + step, 0.0, ends)) >= best * (1.0 - 1e-6)


@pytest.mark.parametrize("name", ["viscous JKR", "Thornton-Ning", "hysteresis", "fixed loss"])
def test_tables_of_the_file_are_those_of_the_code(name):
    """That of the ring force, whose table takes a second, is compared between its places above."""
    computed = np.concatenate([shapes.restitutions(name), shapes.by_size(name)], axis=-1)
    np.testing.assert_allclose(shapes.table(name), computed, rtol=1e-6, atol=1e-7)
