"""Tangential compliance: the static law, both limits, the sense of slip, energy, bad input."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import gamma

from microimpact.model.dynamics import tangential
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar, simulate, spatial
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.tangential import compliant_impulse, contact_shear_modulus

LAWS = ("mindlin", "spring")
every_law = pytest.mark.parametrize("law", LAWS)
GREATEST = 1.25**0.2  # contact radius of an undamped Hertz impact, scaled


@pytest.fixture(scope="module")
def elastic(contact):
    return contact.replace(work_of_adhesion=0.0, hertz_damping=0.0, adhesion_damping=0.0)


def stiffness(contact):
    return float(8 * contact_shear_modulus(contact.particle, contact.surface) / contact.stiffness)


def slip_after(contact, impact):
    return impact.tangential_velocity - contact.radius * impact.spin


def test_the_stiffness_is_that_of_mindlin_for_like_bodies(steel, contact):
    """8 G* over K is 3 (1 - nu)/(2 - nu), the ratio of tangential to normal stiffness doubled."""
    like = contact.replace(surface=steel)
    nu = steel.poissons_ratio
    assert stiffness(like) == pytest.approx(3 * (1 - nu) / (2 - nu), rel=1e-14)


def test_a_constant_normal_force_gives_the_law_of_cattaneo_and_mindlin():
    """Displacement 3 f N/(16 G* a) (1 - (1 - F/fN)^(2/3)), and back by twice its half."""
    number, k, s, limit = 2000, 1.2, 0.8, 0.3 * 0.8**3
    edge = np.linspace(0.0, s, number + 1)
    springs = np.zeros((6, number))
    springs[tangential.PLACE] = (edge[:-1] ** 2 + edge[:-1] * edge[1:] + edge[1:] ** 2) / 3
    springs[tangential.LENGTH] = np.diff(edge)
    tangential._press_row(s, limit / (k * s), number, springs)
    springs[tangential.LIMIT] = springs[tangential.NEXT_LIMIT]
    full = 1.5 * limit / (k * s)

    def pushed(way):
        # with nothing to slow it down the point moves by its slip times the time
        tangential._drive(way, 1.0, number, False, 0.0, 0.0, springs)
        return k * springs[tangential.LENGTH] @ springs[tangential.STRAIN]

    there = np.array([pushed(0.02 * full) for _ in range(40)])
    share = 0.02 * np.arange(1, 41)
    assert there == pytest.approx(limit * (1 - (1 - share) ** 1.5), rel=1e-5)
    back = np.array([pushed(-0.02 * full) for _ in range(60)])
    way = 0.02 * np.arange(1, 61)
    expected = there[-1] - 2 * limit * (1 - (1 - way / 2) ** 1.5)
    assert back == pytest.approx(expected, abs=1e-5 * limit)


class TestGrossSlip:
    @every_law
    @pytest.mark.parametrize("basis", ["compressive", "hertz"])
    def test_little_friction_is_rigid_sliding(self, contact, law, basis):
        weak = contact.replace(friction=1e-3)
        angle = np.array([5.0, 30.0, 60.0, 85.0])
        rigid = simulate(weak, 1.66, angle, 2e3, basis)
        impact = simulate(weak, 1.66, angle, 2e3, basis, tangential=law)
        assert not impact.rolling.any()
        for name in ("tangential_velocity", "spin", "impulse_ratio", "energy_loss"):
            assert np.array_equal(getattr(impact, name), getattr(rigid, name))

    @every_law
    @pytest.mark.parametrize("basis", ["compressive", "hertz"])
    @pytest.mark.parametrize("ratio", [1.2, 3.0, 30.0])
    def test_the_path_that_is_followed_is_the_kernels(self, contact, law, basis, ratio):
        """Its integral of friction is that of the normal impact, damped and adhesive too."""
        speed = ratio * capture_velocity(contact)
        normal = normal_impact(contact, speed, ledger=True)
        slip = np.array([1e3 * speed])
        impulse, stuck = compliant_impulse(contact, normal, slip, speed, law, basis)
        whole = normal.hertz_impulse if basis == "hertz" else normal.compressive_impulse
        assert not stuck.any()
        assert impulse == pytest.approx(contact.friction * whole / contact.mass, rel=5e-4)


class TestNoSlip:
    """Without a limit the contact is an oscillator whose stiffness follows the contact radius."""

    def test_one_spring_in_closed_form(self, elastic):
        """The loading is a hypergeometric function of (x/x_m)^(5/2), the unloading its mirror."""
        k = stiffness(elastic)
        product = -3.5 * 1.25 * k / 6.25
        root = math.sqrt(0.01 - 4 * product)
        a, b = (0.1 + root) / 2, (0.1 - root) / 2
        deepest = GREATEST**2
        slip = gamma(0.6) * gamma(0.5) / gamma(0.6 - a) / gamma(0.6 - b)
        brake = -2.5 / deepest * product * gamma(0.6) * gamma(0.5) / gamma(1 + a) / gamma(1 + b)
        expected = slip**2 - brake**2 / (3.5 * k * GREATEST)
        impact = planar(elastic.replace(friction=1e6), -1.0, 0.1, tangential="spring")
        assert slip_after(elastic, impact) / 0.1 == pytest.approx(expected, rel=1e-4)

    def test_springs_that_leave_one_by_one(self, elastic):
        """What was stuck at a radius lets go there with the displacement it has gathered since."""
        k = stiffness(elastic)

        def loading(_, y):
            x, u, _, slip, force = y
            s = math.sqrt(max(x, 0.0))
            return [u, -(s**3), slip, -3.5 * force, k * s * slip]

        def turned(_, y):
            return y[1]

        turned.terminal, turned.direction = True, -1
        options = {"rtol": 1e-10, "atol": 1e-13, "dense_output": True}
        first = solve_ivp(loading, (0, 9), [0, 1, 0, 1, 0], events=turned, **options)
        way, slip, force = first.y[2:, -1]
        end = first.t[-1]

        def unloading(t, y):
            # the undamped path is its own mirror image: at the same radius, as long before
            way, slip, force = y
            x, u, caught = first.sol(max(2 * end - t, 0.0))[:3]
            s = math.sqrt(max(x, 1e-30))
            return [slip, -3.5 * force, k * s * slip - k * (way - caught) * u / (2 * s)]

        last = solve_ivp(unloading, (end, 2 * end), [way, slip, force], **options)
        impact = planar(elastic.replace(friction=1e6), -1.0, 0.1, tangential="mindlin")
        assert slip_after(elastic, impact) / 0.1 == pytest.approx(last.y[1, -1], abs=5e-5)

    @pytest.mark.parametrize("ratio", [1e-5, 1e-3, 0.1])
    def test_one_spring_while_a_slow_sphere_is_drawn_in_and_pressed(self, contact, ratio):
        """Compressive friction holds from where Hertz and ring force balance until there again."""
        sticky = contact.replace(hertz_damping=0.0, adhesion_damping=0.0, friction=1e6)
        k, unit = stiffness(sticky), float(sticky.velocity_scale)
        energy = 0.5 * ratio**2

        def pressed(_, y):
            x, u, slip, force = y
            return [u, -math.sqrt(x) * (x - 1), -3.5 * force, k * math.sqrt(x) * slip]

        def released(_, y):
            x, u, slip, way = y
            return [u, -math.sqrt(x) * (x - 1), -3.5 * k * math.sqrt(x) * way, slip]

        def turned(_, y):
            return y[1]

        def balanced(_, y):
            return y[0] - 1

        turned.terminal = balanced.terminal = True
        turned.direction = balanced.direction = -1
        options = {"rtol": 1e-10, "atol": 1e-13}
        start = math.sqrt(2 * (energy + 4 / 15))
        first = solve_ivp(pressed, (0, 9), [1, start, 1, 0], events=turned, **options).y[:, -1]
        first[3] /= k * math.sqrt(first[0])
        last = solve_ivp(released, (0, 9), first, events=balanced, **options).y[2, -1]
        slip = ratio * unit
        impact = planar(sticky, -ratio * unit, slip, tangential="spring")
        assert slip_after(sticky, impact) / slip == pytest.approx(last, abs=2e-4)


class TestReversal:
    def test_the_contact_point_turns_round_between_grazing_and_normal(self, elastic):
        """Maw, Barber and Fawcett: on at steep and at grazing angles, back between."""
        slip = 7 * elastic.friction * np.array([0.02, 0.05, 0.2, 0.4, 0.6, 0.8, 1.05, 1.5])
        impact = planar(elastic, -1.0, slip, tangential="mindlin")
        assert np.sign(slip_after(elastic, impact)).tolist() == [1, 1, -1, -1, -1, -1, 1, 1]

    @every_law
    def test_only_slip_over_friction_and_speed_matters_without_adhesion(self, elastic, law):
        slip = np.linspace(0.05, 1.2, 20)
        one, other = (
            planar(elastic.replace(friction=f), -v, 7 * f * v * slip, tangential=law)
            for f, v in ((0.15, 1.0), (0.3, 40.0))
        )
        assert one.impulse_ratio / 0.15 == pytest.approx(other.impulse_ratio / 0.3, rel=1e-9)


states = st.fixed_dictionaries(
    {
        "v_n": st.floats(0.003, 10.0).map(lambda v: -v),
        "v_t": st.floats(-5.0, 5.0),
        "omega": st.floats(-2e5, 2e5),
        "friction_basis": st.sampled_from(["compressive", "hertz"]),
        "tangential": st.sampled_from(("rigid", *LAWS)),
    }
)


class TestAnyImpact:
    @every_law
    @pytest.mark.parametrize("basis", ["compressive", "hertz"])
    @pytest.mark.parametrize("damped", [False, True])
    def test_slip_never_grows_down_to_1e_5_of_the_velocity_scale(self, contact, law, basis, damped):
        """Nor from slight to tenfold friction, nor at grazing or steep angles."""
        rng, n = np.random.default_rng(1), 500
        sticky = contact.replace(
            hertz_damping=0.0, adhesion_damping=0.0, friction=10 ** rng.uniform(-2, 1, n)
        )
        unit = sticky.velocity_scale
        if damped:
            groups = 10 ** rng.uniform(-4, -0.5, (2, n)) / unit
            sticky = sticky.replace(hertz_damping=groups[0], adhesion_damping=groups[1])
        speed = 10 ** rng.uniform(-5, 2, n) * unit
        slip = speed * 10 ** rng.uniform(-3, 3, n)
        impact = planar(sticky, -speed, slip, 0.0, basis, tangential=law)
        assert np.max(np.abs(slip_after(sticky, impact)) / slip) <= 1 + 1e-12

    @given(state=states, angle=st.floats(0.0, 2 * math.pi))
    def test_in_three_dimensions_it_is_the_planar_one_along_the_slip(self, contact, state, angle):
        flat = planar(contact, **state)
        c, s = math.cos(angle), math.sin(angle)
        laws = {name: state[name] for name in ("friction_basis", "tangential")}
        impact = spatial(
            contact,
            [c * state["v_t"], s * state["v_t"], state["v_n"]],
            [-s * state["omega"], c * state["omega"], 7.0],
            **laws,
        )
        v_t, spin = float(flat.tangential_velocity), float(flat.spin)
        size = abs(state["v_t"]) + contact.radius * abs(state["omega"]) + 1e-9
        assert impact.velocity[:2] == pytest.approx([c * v_t, s * v_t], abs=1e-9 * size)
        assert contact.radius * impact.spin[:2] == pytest.approx(
            contact.radius * np.array([-s * spin, c * spin]), abs=1e-9 * size
        )
        assert impact.spin[2] == 7.0
        assert impact.impulse_ratio == pytest.approx(abs(flat.impulse_ratio), rel=1e-9, abs=1e-12)
        assert impact.energy_loss == pytest.approx(flat.energy_loss, abs=1e-9 * (1 + size**2))
        for name in ("coefficient_of_restitution", "captured", "contact_time", "rolling"):
            assert getattr(impact, name) == getattr(flat, name)
        mirror = planar(contact, **state | {"v_t": -state["v_t"], "omega": -state["omega"]})
        assert (mirror.tangential_velocity, mirror.spin) == (-v_t, -spin)

    @every_law
    def test_the_normal_impact_is_left_alone_and_what_is_captured_rolls(self, contact, law):
        speed = np.array([[0.5 * float(capture_velocity(contact))], [1.66]])
        angle = np.linspace(5.0, 90.0, 9)
        rigid, impact = (simulate(contact, speed, angle, tangential=t) for t in ("rigid", law))
        for name in ("coefficient_of_restitution", "contact_time", "maximum_compression"):
            assert np.array_equal(getattr(impact, name), getattr(rigid, name))
        stays = rigid.captured
        assert stays[0].all()
        assert impact.rolling[stays].all()
        assert np.array_equal(impact.spin[stays], rigid.spin[stays])

    @every_law
    def test_no_field_is_nan_near_capture_nor_far_from_it(self, contact, law):
        threshold = float(capture_velocity(contact))
        speed = threshold * np.array([1 + 1e-12, 1 + 1e-6, 1.01, 1e4])
        for basis in ("compressive", "hertz"):
            impact = planar(contact, -speed, 0.1 * speed, 0.0, basis, tangential=law)
            assert np.isfinite(impact.spin).all()
            assert (np.abs(impact.impulse_ratio) < 10).all()


@pytest.mark.parametrize(
    ("changes", "motion", "error", "message"),
    [
        *(
            ({}, {"tangential": value}, error, f"^tangential must be one of .*, got {value!r}$")
            for value, error in (("Mindlin", ValueError), (None, TypeError))
        ),
        *(
            (
                {},
                {"tangential": law, "friction_basis": "net"},
                ValueError,
                r"^friction_basis must be 'compressive' or 'hertz' ",
            )
            for law in LAWS
        ),
        (
            {"hertz_damping": 1e9},
            {"tangential": "mindlin"},
            RuntimeError,
            r"c_H v is 1e\+09 at most, too much damping",
        ),
    ],
)
def test_bad_input_is_named(elastic, changes, motion, error, message):
    with pytest.raises(error, match=message):
        planar(elastic.replace(**changes), -1.0, 1e-3, **motion)
