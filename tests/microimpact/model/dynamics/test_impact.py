"""Oblique impact, planar and in three dimensions."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson

from microimpact.model.choices import FRICTION_BASES
from microimpact.model.dynamics import impact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar, simulate, spatial
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.rigid_body.algebra import energy_loss, rigid_body_rebound

every_basis = pytest.mark.parametrize("basis", FRICTION_BASES)

FIELDS = [
    "coefficient_of_restitution",
    "impulse_ratio",
    "captured",
    "contact_time",
    "normal_velocity",
    "tangential_velocity",
    "spin",
    "rolling",
    "energy_loss",
    "translational_energy_loss",
    "maximum_compression",
]

oblique = st.fixed_dictionaries(
    {
        "v_n": st.floats(0.003, 10.0).map(lambda v: -v),
        "v_t": st.floats(-5.0, 5.0),
        "omega": st.floats(-2e5, 2e5),
        "friction_basis": st.sampled_from(FRICTION_BASES),
    }
)


def as_tuple(impact):
    return tuple(np.asarray(getattr(impact, name)).tolist() for name in FIELDS)


class TestSliding:
    @every_basis
    def test_the_impulse_ratio_is_the_friction_without_adhesion(self, contact, basis):
        bare = contact.replace(ring_force=0.0, hertz_damping=0.2, adhesion_damping=0.0)
        angle = np.array([0.01, 0.1, 1.0, 5.0])
        impact = simulate(bare, 1.66, angle, friction_basis=basis)
        assert not impact.rolling.any()
        assert impact.impulse_ratio == pytest.approx(0.15, rel=1e-12)

    def test_on_the_net_force_the_ratio_is_the_friction_with_adhesion_too(self, contact):
        v_n = -capture_velocity(contact) * np.array([1.0001, 1.1, 3.0, 100.0])
        impact = planar(contact, v_n, 1e4, friction_basis="net")
        assert not impact.rolling.any()
        assert impact.impulse_ratio == pytest.approx(0.15, rel=1e-13)

    @pytest.mark.parametrize("basis", ["compressive", "hertz"])
    def test_on_what_compresses_the_ratio_rises_towards_capture(self, contact, basis):
        v_n = -capture_velocity(contact) * np.array([30.0, 10.0, 5.0, 3.0, 1.1])
        impact = planar(contact, v_n, 1e4, friction_basis=basis)
        assert not impact.rolling.any()
        assert (np.diff(impact.impulse_ratio) > 0).all()
        assert impact.impulse_ratio[0] > 0.15
        assert impact.impulse_ratio[-1] > 1.5 * 0.15

    @pytest.mark.parametrize("w", [1.5, 4.0, 30.0])
    def test_the_friction_impulse_is_that_of_a_march_through_time(self, scaled, time_form, w):
        contact = scaled(0.03, 0.3)
        v = w * contact.velocity_scale
        march = time_form(w, 0.03, 0.3)
        expected = 0.15 * march.compressive_impulse / (1 + march.e) / w
        assert planar(contact, -v, 1e3).impulse_ratio == pytest.approx(expected, rel=1e-7)

    def test_without_friction_nothing_happens_along_the_surface(self, contact):
        impact = simulate(contact.replace(friction=0.0), 1.0, 30.0, 1e3)
        assert impact.impulse_ratio == 0.0
        assert impact.tangential_velocity == pytest.approx(math.cos(math.pi / 6), rel=1e-15)
        assert impact.spin == 1e3
        assert not impact.rolling


class TestRolling:
    @every_basis
    def test_the_impulse_ratio_is_that_of_rolling(self, contact, basis):
        angle = np.array([55.0, 60.0, 85.0, 90.0])
        impact = simulate(contact, 1.66, angle, friction_basis=basis)
        assert impact.rolling.all()
        expected = 2 / 7 / np.tan(np.radians(angle)) / (1 + impact.coefficient_of_restitution)
        assert impact.impulse_ratio == pytest.approx(expected, rel=1e-13, abs=1e-16)
        assert impact.tangential_velocity == pytest.approx(
            impact.spin * contact.radius, rel=1e-13, abs=1e-16
        )

    @every_basis
    @pytest.mark.parametrize("w", [1.3, 5.0])
    def test_it_is_decided_where_the_friction_of_the_path_stops_the_slip(self, scaled, basis, w):
        """The slip that is just stopped, from the forces against time."""
        contact = scaled(0.03, 0.3)
        v = w * contact.velocity_scale
        path = trajectory(contact, v, points=8001)
        supports = {
            "compressive": np.maximum(path.normal_force, 0.0),
            "hertz": path.hertz_force,
            "net": path.normal_force,
        }[basis]
        impulse = cumulative_simpson(supports, x=path.time)
        stopped = 3.5 * contact.friction * impulse.max() / contact.mass
        slips = stopped * np.array([0.3, 0.999, 1.001, 3.0])
        impact = planar(contact, -v, slips, friction_basis=basis)
        assert impact.rolling.tolist() == [True, True, False, False]

    def test_on_the_net_force_it_is_decided_at_first_passage(self, scaled):
        """The net impulse falls again while adhesion pulls: what has rolled goes on rolling."""
        contact = scaled(0.0, 0.3)
        v = 1.5 * contact.velocity_scale
        normal = normal_impact(contact, v)
        last = (1 + normal.coefficient_of_restitution) * v
        peak = normal.peak_net_impulse / contact.mass
        assert peak > 1.05 * last
        slip = 3.5 * contact.friction * 0.5 * (peak + last)
        assert planar(contact, -v, slip, friction_basis="net").rolling

    def test_a_sphere_that_rolls_already_feels_no_friction(self, contact):
        impact = planar(contact, -1.0, 0.31, 0.31 / contact.radius)
        assert impact.rolling
        assert impact.impulse_ratio == pytest.approx(0.0, abs=1e-15)
        assert impact.tangential_velocity == pytest.approx(0.31, rel=1e-14)


class TestCaptured:
    @every_basis
    def test_it_ends_rolling_by_definition(self, contact, basis):
        v_n, v_t, omega = -0.5 * capture_velocity(contact), 2.0, -3e4
        impact = planar(contact, v_n, v_t, omega, friction_basis=basis)
        assert impact.captured
        assert impact.rolling
        assert impact.coefficient_of_restitution == 0.0
        assert impact.normal_velocity == 0.0
        assert impact.contact_time == math.inf
        expected = (5 * v_t + 2 * contact.radius * omega) / 7
        assert impact.tangential_velocity == pytest.approx(expected, rel=1e-13)
        assert impact.spin == pytest.approx(expected / contact.radius, rel=1e-13)
        assert impact.impulse_ratio == pytest.approx((v_t - expected) / -v_n, rel=1e-13)

    def test_the_threshold_is_in_the_normal_velocity_whatever_the_angle(self, contact):
        threshold = capture_velocity(contact)
        angle = np.array([1.0, 15.0, 50.0, 90.0])
        speed = threshold / np.sin(np.radians(angle))
        assert simulate(contact, speed * (1 - 1e-9), angle).captured.all()
        assert not simulate(contact, speed * (1 + 1e-9), angle).captured.any()


class TestEnergy:
    @given(state=oblique)
    def test_losses_are_those_of_the_rigid_body(self, contact, state):
        impact = planar(contact, **state)
        loss = energy_loss(
            state["v_n"],
            state["v_t"],
            state["omega"],
            contact.radius,
            impact.coefficient_of_restitution,
            -impact.impulse_ratio,
        )
        speed = state["v_n"] ** 2 + state["v_t"] ** 2
        scale = 1 + (contact.radius * state["omega"]) ** 2 / speed
        assert impact.energy_loss == pytest.approx(loss.total, abs=1e-12 * scale)
        assert impact.translational_energy_loss == pytest.approx(
            loss.translational, abs=1e-12 * scale
        )

    @given(state=oblique)
    def test_the_rigid_body_with_this_restitution_and_ratio_rebounds_alike(self, contact, state):
        impact = planar(contact, **state)
        after = rigid_body_rebound(
            state["v_n"],
            state["v_t"],
            state["omega"],
            contact.radius,
            impact.coefficient_of_restitution,
            1e9 if impact.rolling else abs(impact.impulse_ratio),
        )
        scale = abs(state["v_t"]) + contact.radius * abs(state["omega"]) + 1e-3
        assert impact.normal_velocity == pytest.approx(after.V_n, rel=1e-14)
        assert impact.tangential_velocity == pytest.approx(after.V_t, abs=1e-13 * scale)
        assert contact.radius * impact.spin == pytest.approx(
            contact.radius * after.Omega, abs=1e-13 * scale
        )


@given(state=oblique)
def test_the_mirror_image_is_an_impact_too(contact, state):
    impact = planar(contact, **state)
    mirror = planar(contact, **state | {"v_t": -state["v_t"], "omega": -state["omega"]})
    for name in ("tangential_velocity", "spin", "impulse_ratio"):
        assert getattr(mirror, name) == -getattr(impact, name)
    for name in set(FIELDS) - {"tangential_velocity", "spin", "impulse_ratio"}:
        assert getattr(mirror, name) == getattr(impact, name)


class TestSimulate:
    def test_it_is_planar_by_speed_and_angle(self, contact):
        radians = np.radians(37.0)
        impact = simulate(contact, 1.66, 37.0, 5e3)
        other = planar(contact, -1.66 * np.sin(radians), 1.66 * np.cos(radians), 5e3)
        assert as_tuple(impact) == pytest.approx(as_tuple(other), rel=1e-14)

    def test_fields_broadcast_with_arguments(self, contact):
        many = contact.replace(diameter=np.array([[[20e-6]], [[60e-6]]]))
        impact = simulate(many, np.array([[0.5], [1.0], [2.0]]), [10.0, 30.0, 60.0, 90.0], 1e3)
        assert {np.shape(getattr(impact, name)) for name in FIELDS} == {(2, 3, 4)}

    def test_a_polydisperse_sample_is_a_loop_over_its_spheres(self, contact):
        diameters = np.geomspace(0.5e-6, 100e-6, 23)
        sample = simulate(contact.replace(diameter=diameters), 1.0, 40.0)
        assert 0 < sample.captured.sum() < 23
        for i, diameter in enumerate(diameters):
            alone = simulate(contact.replace(diameter=diameter), 1.0, 40.0)
            for name in FIELDS:
                value = np.asarray(getattr(sample, name))[i]
                # NumPy's powers of arrays and of single numbers differ in the last digit
                assert value == pytest.approx(getattr(alone, name), rel=1e-12)

    @every_basis
    def test_results_do_not_depend_on_order_or_parts(self, contact, basis):
        random = np.random.default_rng(3)
        speed, angle = random.uniform(0.01, 3, 200), random.uniform(1, 90, 200)
        whole = simulate(contact, speed, angle, friction_basis=basis)
        order = random.permutation(200)
        shuffled = simulate(contact, speed[order], angle[order], friction_basis=basis)
        halves = [
            simulate(contact, speed[part], angle[part], friction_basis=basis)
            for part in (slice(0, 37), slice(37, 200))
        ]
        for name in FIELDS:
            values = getattr(whole, name)
            assert np.array_equal(getattr(shuffled, name), values[order])
            assert np.array_equal(np.concatenate([getattr(h, name) for h in halves]), values)

    @pytest.mark.parametrize(
        "speed",
        [
            [1, 2],
            (1.0, 2.0),
            np.float32([1, 2]),
            np.array([1, 2], dtype=np.uint8),
            pd.Series([1.0, 2.0], index=[9, 4]),
        ],
    )
    def test_any_sequence_of_numbers_will_do(self, contact, speed):
        expected = simulate(contact, np.array([1.0, 2.0]), 50.0)
        assert as_tuple(simulate(contact, speed, 50.0)) == as_tuple(expected)

    @pytest.mark.parametrize("speed", [2, 2.0, np.int16(2), np.array(2.0), np.float32(2)])
    def test_a_single_number_gives_single_numbers(self, contact, speed):
        impact = simulate(contact, speed, 50.0)
        assert {np.shape(getattr(impact, name)) for name in FIELDS} == {()}
        assert as_tuple(impact) == as_tuple(simulate(contact, 2.0, 50.0))

    @every_basis
    @pytest.mark.parametrize("shape", [(0,), (0, 3)])
    def test_no_impacts_give_empty_arrays(self, contact, basis, shape):
        impact = simulate(contact, np.ones(shape), friction_basis=basis)
        assert {np.shape(getattr(impact, name)) for name in FIELDS} == {shape}

    def test_every_field_is_a_number(self, contact):
        speed = np.geomspace(1e-6, 1e3, 60)[:, None]
        angle = np.array([1e-6, 1.0, 45.0, 90.0])
        impact = simulate(contact, speed, angle, 1e4)
        for name in FIELDS:
            assert not np.isnan(getattr(impact, name)).any()


GOOD = {"speed": 1.0, "angle": 45.0, "spin": 0.0}


class TestBadInput:
    @pytest.mark.parametrize(
        ("name", "value", "said"),
        [
            ("speed", 0, "0"),
            ("speed", -1.5, "-1.5"),
            ("speed", math.nan, "nan"),
            ("speed", math.inf, "inf"),
            ("speed", [1.0, -2.0], "-2 at index 1"),
            ("angle", 0.0, "0"),
            ("angle", -10, "-10"),
            ("angle", 90.5, "90.5"),
            ("angle", 180, "180"),
            ("angle", math.nan, "nan"),
            ("spin", math.inf, "inf"),
            ("spin", math.nan, "nan"),
        ],
    )
    def test_out_of_range_is_a_value_error(self, contact, name, value, said):
        with pytest.raises(ValueError, match=f"^{name} must be finite.*got {said}$"):
            simulate(contact, **GOOD | {name: value})

    @pytest.mark.parametrize("name", list(GOOD))
    @pytest.mark.parametrize("value", ["1", None, True, 1j, [1.0, "2"]])
    def test_no_number_is_a_type_error(self, contact, name, value):
        with pytest.raises(TypeError, match=f"^{name} must be a real number"):
            simulate(contact, **GOOD | {name: value})

    @pytest.mark.parametrize(("basis", "error"), [("Net", ValueError), ("", ValueError)])
    @pytest.mark.parametrize("function", [simulate, planar, spatial])
    def test_an_unknown_basis_names_the_known_ones(self, contact, function, basis, error):
        arguments = {simulate: (1.0, 45.0), planar: (-1.0, 1.0), spatial: ([1.0, 0.0, -1.0],)}[
            function
        ]
        with pytest.raises(error, match=f"friction_basis must be one of .* got {basis!r}"):
            function(contact, *arguments, friction_basis=basis)
        with pytest.raises(TypeError, match=r"friction_basis must be one of .* got None"):
            function(contact, *arguments, friction_basis=None)

    def test_shapes_are_named(self, contact):
        with pytest.raises(ValueError, match=r"speed \(2,\), angle \(3,\)"):
            simulate(contact, [1.0, 2.0], [10.0, 20.0, 30.0])
        many = contact.replace(diameter=[1e-6, 2e-6])
        with pytest.raises(ValueError, match=r"contact \(2,\), speed \(3,\)"):
            simulate(many, [1.0, 2.0, 3.0])
        with pytest.raises(ValueError, match=r"v_n \(2,\), omega \(3,\)"):
            planar(contact, [-1.0, -2.0], 1.0, [0.0, 0.0, 0.0])

    @pytest.mark.parametrize("v_n", [0.0, 1.0, math.nan])
    def test_the_sphere_must_approach(self, contact, v_n):
        with pytest.raises(ValueError, match=r"^v_n must be"):
            planar(contact, v_n, 1.0)
        with pytest.raises(ValueError, match=r"^velocity"):
            spatial(contact, [1.0, 0.0, v_n])

    @pytest.mark.parametrize("velocity", [1.0, [1.0, -1.0], np.ones((3, 2))])
    def test_vectors_have_three_components(self, contact, velocity):
        with pytest.raises(ValueError, match=r"velocity must have shape \(\.\.\., 3\), got"):
            spatial(contact, velocity)
        with pytest.raises(ValueError, match=r"spin must have shape \(\.\.\., 3\), got"):
            spatial(contact, [1.0, 0.0, -1.0], velocity)

    def test_vectors_broadcast_or_are_named(self, contact):
        with pytest.raises(ValueError, match=r"velocity \(2,\), spin \(4,\)"):
            spatial(contact, [[0.0, 0.0, -1.0]] * 2, np.zeros((4, 3)))


def turned(vector, angle):
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = np.moveaxis(np.asarray(vector), -1, 0)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)


spatial_states = st.fixed_dictionaries(
    {
        "velocity": st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, -0.003)),
        "spin": st.tuples(*[st.floats(-1e5, 1e5)] * 3),
        "friction_basis": st.sampled_from(FRICTION_BASES),
    }
)
SCALARS = ["coefficient_of_restitution", "captured", "contact_time", "rolling"]


class TestSpatial:
    @given(state=oblique)
    def test_in_a_plane_it_is_the_planar_impact(self, contact, state):
        flat = planar(contact, **state)
        impact = spatial(
            contact,
            [state["v_t"], 0.0, state["v_n"]],
            [0.0, state["omega"], 0.0],
            state["friction_basis"],
        )
        for name in SCALARS:
            assert getattr(impact, name) == getattr(flat, name)
        assert impact.velocity == pytest.approx(
            [flat.tangential_velocity, 0.0, flat.normal_velocity], rel=1e-12, abs=1e-14
        )
        assert impact.spin == pytest.approx([0.0, flat.spin, 0.0], rel=1e-12, abs=1e-8)
        assert impact.impulse_ratio == pytest.approx(abs(flat.impulse_ratio), rel=1e-12)
        assert impact.energy_loss == pytest.approx(flat.energy_loss, rel=1e-10, abs=1e-10)

    @given(state=spatial_states, angle=st.floats(0.0, 2 * math.pi))
    def test_a_turn_about_the_normal_turns_the_outcome(self, contact, state, angle):
        impact = spatial(contact, **state)
        other = spatial(
            contact,
            turned(state["velocity"], angle),
            turned(state["spin"], angle),
            state["friction_basis"],
        )
        for name in ("coefficient_of_restitution", "captured", "contact_time"):
            assert getattr(other, name) == getattr(impact, name)
        assert other.velocity == pytest.approx(turned(impact.velocity, angle), abs=1e-12)
        assert other.spin == pytest.approx(turned(impact.spin, angle), abs=1e-12 / contact.radius)

    @given(state=spatial_states, spin=st.floats(-1e6, 1e6))
    def test_spin_about_the_normal_is_inert(self, contact, state, spin):
        impact = spatial(contact, **state)
        x, y, z = state["spin"]
        other = spatial(contact, state["velocity"], (x, y, z + spin), state["friction_basis"])
        assert np.array_equal(other.velocity, impact.velocity)
        assert np.array_equal(other.spin[:2], impact.spin[:2])
        assert other.spin[2] == z + spin

    @given(state=spatial_states)
    def test_slip_keeps_its_direction_or_stops(self, contact, state):
        def slip(velocity, spin):
            radius = contact.radius
            return np.array([velocity[0] - radius * spin[1], velocity[1] + radius * spin[0]])

        impact = spatial(contact, **state)
        before, after = (slip(state["velocity"], state["spin"]), slip(impact.velocity, impact.spin))
        scale = 1e-12 * (1 + np.abs(before).max())
        assert abs(before[0] * after[1] - before[1] * after[0]) <= 10 * scale
        assert before @ after >= -scale
        if impact.rolling:
            assert np.abs(after).max() <= scale

    def test_leading_shapes_broadcast_with_the_contact(self, contact):
        many = contact.replace(diameter=np.array([[20e-6], [60e-6]]))
        velocity = np.array([[1.0, 0.0, -1.0], [0.0, 2.0, -0.5], [0.0, 0.0, -2.0]])
        impact = spatial(many, velocity)
        assert impact.velocity.shape == impact.spin.shape == (2, 3, 3)
        assert impact.captured.shape == (2, 3)
        alone = spatial(contact.replace(diameter=60e-6), velocity[1])
        assert np.array_equal(impact.velocity[1, 1], alone.velocity)


@pytest.mark.parametrize("friction", [0.0, 0.15])
def test_a_captured_sphere_rolls_only_by_friction(contact, friction):
    smooth = contact.replace(friction=friction)
    impact = simulate(smooth, 0.5 * capture_velocity(contact), 45.0)
    assert impact.captured
    assert bool(impact.rolling) == (friction > 0.0)
    v_n = 0.5 * capture_velocity(contact)
    assert bool(spatial(smooth, (0.1, 0.0, -v_n)).rolling) == (friction > 0.0)


def test_impacts_in_blocks_are_those_in_one(contact, monkeypatch):
    several = contact.replace(diameter=np.linspace(1e-5, 1e-4, 4)[:, None])
    states = np.geomspace(0.01, 3.0, 5), 60.0, np.linspace(0.0, 1e5, 5)
    one = simulate(several, *states)
    monkeypatch.setattr(impact, "BLOCK", 7)
    blocks = simulate(several, *states)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(blocks, name), getattr(one, name))
