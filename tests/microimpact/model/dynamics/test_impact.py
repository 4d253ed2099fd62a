"""Oblique impact, planar and in three dimensions."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson

from microimpact.model.choices import FRICTION_BASES
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import Impact, planar, simulate, spatial
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.rigid_body.algebra import energy_loss, rigid_body_rebound

every_basis = pytest.mark.parametrize("basis", FRICTION_BASES)

FIELDS = [name for name in Impact.__dataclass_fields__ if name != "interpolation_error"]
ODD = ("tangential_velocity", "spin", "impulse_ratio")

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
        impact = simulate(bare, 1.66, np.array([0.01, 0.1, 1.0, 5.0]), friction_basis=basis)
        assert not impact.rolling.any()
        assert impact.impulse_ratio == pytest.approx(0.15, rel=1e-12)

    @every_basis
    def test_with_adhesion_it_rises_towards_capture_unless_the_force_is_the_net_one(
        self, contact, basis
    ):
        v_n = -capture_velocity(contact) * np.array([100.0, 10.0, 5.0, 3.0, 1.1, 1.0001])
        impact = planar(contact, v_n, 1e4, friction_basis=basis)
        assert not impact.rolling.any()
        if basis == "net":
            assert impact.impulse_ratio == pytest.approx(0.15, rel=1e-13)
        else:
            assert (np.diff(impact.impulse_ratio) > 0).all()
            assert impact.impulse_ratio[0] > 0.15
            assert impact.impulse_ratio[-1] > 1.5 * 0.15

    @pytest.mark.parametrize("w", [1.5, 4.0, 30.0])
    def test_the_friction_impulse_is_that_of_a_march_through_time(self, scaled, time_form, w):
        contact = scaled(0.03, 0.3)
        march = time_form(w, 0.03, 0.3)
        expected = 0.15 * march.compressive_impulse / (1 + march.e) / w
        impact = planar(contact, -w * contact.velocity_scale, 1e3)
        assert impact.impulse_ratio == pytest.approx(expected, rel=1e-7)


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
        """The slip that is just stopped, from the forces against time.

        The net impulse falls again while adhesion pulls: there the first passage decides.
        """
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
        angle = np.array([1.0, 15.0, 50.0, 90.0])
        speed = capture_velocity(contact) / np.sin(np.radians(angle))
        assert simulate(contact, speed * (1 - 1e-9), angle).captured.all()
        assert not simulate(contact, speed * (1 + 1e-9), angle).captured.any()

    @pytest.mark.parametrize("friction", [0.0, 0.15])
    def test_it_rolls_only_by_friction(self, contact, friction):
        smooth, v_n = contact.replace(friction=friction), -0.5 * capture_velocity(contact)
        for impact in (planar(smooth, v_n, 0.1), spatial(smooth, (0.1, 0.0, v_n))):
            assert impact.captured
            assert bool(impact.rolling) == (friction > 0.0)


@given(state=oblique)
def test_the_rigid_body_with_this_restitution_and_ratio_rebounds_alike(contact, state):
    impact = planar(contact, **state)
    motion = state["v_n"], state["v_t"], state["omega"], contact.radius
    e, ratio = impact.coefficient_of_restitution, impact.impulse_ratio
    loss = energy_loss(*motion, e, -ratio)
    turning = contact.radius * abs(state["omega"])
    scale = 1 + turning**2 / (state["v_n"] ** 2 + state["v_t"] ** 2)
    assert impact.energy_loss == pytest.approx(loss.total, abs=1e-12 * scale)
    assert impact.translational_energy_loss == pytest.approx(loss.translational, abs=1e-12 * scale)
    after = rigid_body_rebound(*motion, e, 1e9 if impact.rolling else abs(ratio))
    scale = abs(state["v_t"]) + turning + 1e-3
    assert impact.normal_velocity == pytest.approx(after.V_n, rel=1e-14)
    assert impact.tangential_velocity == pytest.approx(after.V_t, abs=1e-13 * scale)
    assert contact.radius * impact.spin == pytest.approx(
        contact.radius * after.Omega, abs=1e-13 * scale
    )
    mirror = planar(contact, **state | {"v_t": -state["v_t"], "omega": -state["omega"]})
    for name in FIELDS:
        assert getattr(mirror, name) == (-1 if name in ODD else 1) * getattr(impact, name)


class TestArguments:
    def test_speed_and_angle_are_velocities(self, contact):
        radians = np.radians(37.0)
        impact = simulate(contact, 1.66, 37.0, 5e3)
        other = planar(contact, -1.66 * np.sin(radians), 1.66 * np.cos(radians), 5e3)
        assert as_tuple(impact) == pytest.approx(as_tuple(other), rel=1e-14)

    def test_a_polydisperse_sample_is_a_loop_over_its_spheres(self, contact):
        diameters = np.geomspace(0.5e-6, 100e-6, 23)
        sample = simulate(contact.replace(diameter=diameters), 1.0, 40.0)
        assert 0 < sample.captured.sum() < 23
        for i, diameter in enumerate(diameters):
            alone = simulate(contact.replace(diameter=diameter), 1.0, 40.0)
            for name in set(FIELDS) - {"partner_spin"}:
                value = np.asarray(getattr(sample, name))[i]
                # NumPy's powers of arrays and of single numbers differ in the last digit
                assert value == pytest.approx(getattr(alone, name), rel=1e-12, abs=0.0)

    @every_basis
    def test_results_do_not_depend_on_order_or_blocks(self, contact, basis, monkeypatch):
        random = np.random.default_rng(3)
        speed, angle = random.uniform(0.01, 3, 200), random.uniform(1, 90, 200)
        several = contact.replace(diameter=np.array([[2e-5], [6e-5]]))
        whole = simulate(several, speed, angle, 1e3, basis)
        order = random.permutation(200)
        monkeypatch.setattr("microimpact.model.dynamics.impact.BLOCK", 37)
        shuffled = simulate(several, speed[order], angle[order], 1e3, basis)
        for name in set(FIELDS) - {"partner_spin"}:
            values = getattr(whole, name)
            assert values.shape == (2, 200)
            assert np.array_equal(getattr(shuffled, name), values[:, order])

    @pytest.mark.parametrize(
        "speed", [2, np.int16(2), np.array(2.0), [1, 2], np.float32([1, 2]), pd.Series([1.0, 2.0])]
    )
    def test_numbers_and_sequences_of_numbers_will_do(self, contact, speed):
        plain = 2.0 if np.ndim(speed) == 0 else np.array([1.0, 2.0])
        assert as_tuple(simulate(contact, speed, 50.0)) == as_tuple(simulate(contact, plain, 50.0))

    def test_outcomes_go_into_a_table_with_the_index_of_a_series(self, contact):
        speed = pd.Series([1.0, 2.0], index=["a", "b"])
        impact = simulate(contact, speed, 50.0)
        table = pd.DataFrame(impact.to_dict(), index=speed.index)
        assert set(table.columns) == set(Impact.__dataclass_fields__)
        assert table["spin"]["b"] == impact.spin[1]

    @every_basis
    @pytest.mark.parametrize("shape", [(0,), (0, 3), (60, 4)])
    def test_every_field_is_a_number_of_the_common_shape(self, contact, basis, shape):
        speed = np.resize(np.geomspace(1e-6, 1e3, 60), shape[:1])
        angle = np.resize([1e-6, 1.0, 45.0, 90.0], shape[1:])
        speed = speed.reshape(shape[:1] + (1,) * (len(shape) - 1))
        impact = simulate(contact, speed, angle, 1e4, basis)
        for name in set(FIELDS) - {"partner_spin"}:
            assert np.shape(getattr(impact, name)) == shape
            assert not np.isnan(getattr(impact, name)).any()


SPEED, ANGLE = {"speed": 1.0}, {"speed": 1.0, "angle": 45.0}
NUMBER = "must be a real number"
VECTOR = r"must have shape \(\.\.\., 3\), got"
MANY = {"diameter": [1e-6, 2e-6]}
TOWARDS = {"velocity": [1.0, 0.0, -1.0]}


@pytest.mark.parametrize(
    ("function", "arguments", "error", "message"),
    [
        *(
            (simulate, ANGLE | {name: value}, ValueError, f"^{name} must be finite.*got {words}$")
            for name, value, words in (
                ("speed", 0, "0"),
                ("speed", -1.5, "-1.5"),
                ("speed", math.nan, "nan"),
                ("speed", math.inf, "inf"),
                ("speed", [1.0, -2.0], "-2 at index 1"),
                ("angle", 0.0, "0"),
                ("angle", 90.5, "90.5"),
                ("spin", math.inf, "inf"),
                *(
                    ("speed", 10**400, "inf"),
                    ("speed", 1e308, "1e\\+308"),
                    ("spin", -1e18, "-1e\\+18"),
                ),
            )
        ),
        *(
            (simulate, ANGLE | {name: value}, TypeError, f"^{name} {NUMBER}")
            for name in ("speed", "angle", "spin")
            for value in ("1", None, True, [1.0, "2"])
        ),
        *(
            (
                function,
                arguments | {"friction_basis": basis},
                error,
                "friction_basis must be one of",
            )
            for function, arguments in ((simulate, SPEED), (spatial, TOWARDS))
            for basis, error in (("Net", ValueError), (None, TypeError))
        ),
        (simulate, {"speed": [1.0, 2.0], "angle": [10.0] * 3}, ValueError, r"speed \(2,\), angle"),
        (simulate, {"speed": [1.0] * 3} | MANY, ValueError, r"contact \(2,\), speed \(3,\)"),
        (
            planar,
            {"v_n": [-1.0] * 2, "v_t": 1.0, "omega": [0.0] * 3},
            ValueError,
            r"v_n \(2,\), om",
        ),
        (planar, {"v_n": 0.0, "v_t": 1.0}, ValueError, "^v_n must be"),
        (planar, {"v_n": -1e200, "v_t": 1.0}, ValueError, "^v_n must be"),
        (planar, {"v_n": -1.0, "v_t": 1e200}, ValueError, "^v_t must be"),
        (spatial, {"velocity": [1e200, 0.0, -1.0]}, ValueError, "^velocity must be"),
        (spatial, {"velocity": [1.0, 0.0, 0.0]}, ValueError, "^velocity"),
        (spatial, {"velocity": [1.0, -1.0]}, ValueError, f"velocity {VECTOR}"),
        (spatial, TOWARDS | {"spin": 1.0}, ValueError, f"spin {VECTOR}"),
        (
            spatial,
            {"velocity": [[0.0, 0.0, -1.0]] * 2, "spin": np.zeros((4, 3))},
            ValueError,
            r"velocity \(2,\), spin \(4,\)",
        ),
    ],
)
def test_bad_input_is_named(contact, function, arguments, error, message):
    fields = {name: arguments[name] for name in MANY if name in arguments}
    motion = {name: value for name, value in arguments.items() if name not in fields}
    with pytest.raises(error, match=message):
        function(contact.replace(**fields), **motion)


@pytest.mark.parametrize("work", [1e-30, 1e-28, 1e-25])
def test_hardly_any_adhesion_is_as_good_as_none(contact, work):
    speed = np.geomspace(0.1, 10.0, 60)
    expected = simulate(contact.replace(work_of_adhesion=0.0), speed, 40.0)
    found = simulate(contact.replace(work_of_adhesion=work), speed, 40.0)
    for name in FIELDS:
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-12), name


def test_an_outcome_that_is_no_number_is_an_error(contact):
    good = simulate(contact, [1.0, 2.0])
    with pytest.raises(ValueError, match="beyond double precision"):
        replace(good, energy_loss=np.array([0.5, math.nan]))


class TestSpatial:
    """In a plane it is the planar impact: see `test_tangential`."""

    @given(
        velocity=st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, -0.003)),
        spin=st.tuples(*[st.floats(-1e5, 1e5)] * 3),
        basis=st.sampled_from(FRICTION_BASES),
    )
    def test_slip_keeps_its_direction_or_stops(self, contact, velocity, spin, basis):
        def slip(velocity, spin):
            radius = contact.radius
            return np.array([velocity[0] - radius * spin[1], velocity[1] + radius * spin[0]])

        impact = spatial(contact, velocity, spin, basis)
        before, after = slip(velocity, spin), slip(impact.velocity, impact.spin)
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
