"""Other laws of the normal force: closed forms, published limits, integrations of another kind."""

import math
from functools import partial

import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq, minimize_scalar
from scipy.special import beta

from microimpact.model.closed_forms import (
    contact_modulus,
    contact_regime,
    jkr_loss,
    jkr_sticking_velocity,
    plastic_restitution,
    tabor_number,
    yield_velocity,
)
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, Hysteresis, MaugisBarquins, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.separation import jkr_pull_off

# Of SI numbers, which may be small: a share alone.
approx = partial(pytest.approx, abs=0.0)

EVERY = [
    JKR(),
    JKR(viscous_time=3e-9),
    ThorntonNing(yield_pressure=2e9),
    Hysteresis(unloading_work=4.0),
    MaugisBarquins(edge_speed=20.0, edge_exponent=0.7, viscous_time=1e-9),
]
every_law = pytest.mark.parametrize("law", EVERY, ids=lambda law: f"{law.name}{law.parameters}")


@pytest.fixture(scope="module")
def build(steel, silicon):
    def contact(law, work=0.5, **changes):
        fields = {"particle": steel, "surface": silicon, "diameter": 62e-6} | changes
        return Contact(work_of_adhesion=work, law=law, **fields)

    return contact


class Textbook:
    """JKR by its formulas in SI."""

    def __init__(self, contact, work=None):
        self.modulus, self.radius = contact_modulus(contact), contact.hertz_radius
        self.work, self.mass = contact.work_of_adhesion if work is None else work, contact.mass

    def force(self, a):
        hertz = 4 * self.modulus * a**3 / (3 * self.radius)
        return hertz - math.sqrt(8 * math.pi * self.work * self.modulus * a**3)

    def compression(self, a):
        return a**2 / self.radius - math.sqrt(2 * math.pi * self.work * a / self.modulus)

    def slope(self, a):
        return 2 * a / self.radius - math.sqrt(math.pi * self.work / (2 * self.modulus * a))

    @property
    def broken(self):
        """Contact radius at the least compression."""
        return brentq(self.slope, 1e-12, 1e-5, xtol=1e-22, rtol=1e-14)

    @property
    def closed(self):
        return brentq(self.compression, 1.5 * self.broken, 1e-5, xtol=1e-22, rtol=1e-14)

    def energy(self, a, b):
        return quad(lambda x: self.force(x) * self.slope(x), a, b, epsabs=0, epsrel=1e-12)[0]

    def radius_at(self, compression):
        return brentq(lambda a: self.compression(a) - compression, self.broken, 1e-4, xtol=1e-20)


class TestJKR:
    def test_the_pull_off_force_is_the_least_of_the_textbook(self, build):
        contact = build(JKR())
        book = Textbook(contact)
        least = minimize_scalar(
            lambda a: book.force(a) * 1e6, bounds=(1e-9, 1e-5), options={"xatol": 1e-16}
        )
        assert contact.pull_off_force == approx(-least.fun / 1e6, rel=1e-12)
        assert contact.pull_off_force == jkr_pull_off(0.5, contact.hertz_radius)

    def test_all_that_is_lost_is_lost_between_closing_and_break(self, build):
        contact = build(JKR())
        book = Textbook(contact)
        lost = -book.energy(book.broken, book.closed)
        speed = np.array([0.02, 0.1, 1.66, 50.0])
        e = normal_impact(contact, speed).coefficient_of_restitution
        sticking = math.sqrt(2 * lost / contact.mass)
        assert e == approx(np.sqrt(1 - (sticking / speed) ** 2), rel=1e-12)
        assert capture_velocity(contact) == approx(sticking, rel=1e-12)
        assert jkr_loss(contact) == approx(lost, rel=1e-12)
        # Thornton and Ning print 14.18 for the constant of its square.
        assert sticking == approx(jkr_sticking_velocity(contact), rel=4e-4)

    def test_tabors_number_goes_with_the_stretch_over_the_spacing(self, build):
        contact = build(JKR())
        book = Textbook(contact)
        # Least compression 3 a^2/R at a^3 = pi w R^2 / 8 E*: Tabor's length is 0.62 of that.
        length = -book.compression(book.broken) / (3 * (math.pi / 8) ** (2 / 3))
        assert tabor_number(contact) == approx(length / 0.4e-9, rel=1e-12)
        assert [contact_regime(n) for n in (9.0, 1.0, 0.05)] == [
            "JKR",
            "between JKR and DMT",
            "DMT",
        ]

    def test_force_and_path_are_those_of_a_march_in_time(self, build):
        contact = build(JKR(viscous_time=3e-9))
        book, speed = Textbook(contact), 0.3
        end = book.compression(book.broken)

        def rates(_, y):
            a = book.radius_at(max(y[0], end * (1 - 1e-15)))
            drag = 2 * book.modulus * a * 3e-9 * y[1]
            return [y[1], -(book.force(a) + drag) / book.mass]

        def parted(_, y):
            return y[0] - end * (1 - 1e-9)

        parted.terminal, parted.direction = True, -1
        path = solve_ivp(
            rates, (0, 1e-5), [0.0, speed], events=parted, method="LSODA", rtol=1e-9, atol=1e-18
        )
        impact = normal_impact(contact, speed)
        assert impact.coefficient_of_restitution == approx(-path.y[1, -1] / speed, rel=1e-5)
        assert impact.contact_time == approx(path.t[-1], rel=1e-5)
        assert impact.maximum_compression == approx(path.y[0].max(), rel=1e-3)
        snap = -book.energy(book.broken, book.closed)
        assert impact.losses.adhesion == approx(snap, rel=1e-6)

    @pytest.mark.parametrize("viscous_time", [1e-12, 1e-11, 1e-10])
    def test_without_adhesion_it_follows_the_viscoelastic_series(self, build, viscous_time):
        """1 - C_1 A + 3/5 (C_1 A)^2 (Schwager and Poeschel 1998; Ramirez et al. 1999)."""
        contact = build(JKR(viscous_time=viscous_time), work=0.0)
        group = contact.hertz_stiffness * math.sqrt(contact.hertz_radius) / contact.mass
        first = 3 * 1.25**0.6 * 0.4 * beta(0.6, 1.5) * viscous_time * group**0.4 * 1.66**0.2
        e = normal_impact(contact, 1.66).coefficient_of_restitution
        assert e == approx(1 - first + 0.6 * first**2, abs=max(first**3, 1e-14))
        assert 3 * 1.25**0.6 * 0.4 * beta(0.6, 1.5) / 1.5 == approx(1.15344, rel=1e-5)

    @pytest.mark.parametrize("viscous_time", [3e-10, 3e-9, 2e-8])
    def test_outcomes_are_smooth_in_the_size_and_do_not_depend_on_the_company(
        self, build, viscous_time
    ):
        """A polynomial through all of them leaves rounding alone."""
        position = np.linspace(-1.0, 1.0, 301)
        contact = build(JKR(viscous_time=viscous_time), diameter=62e-6 * np.exp(0.05 * position))
        impact = normal_impact(contact, 8.0 * capture_velocity(contact))
        for name in (
            "coefficient_of_restitution",
            "contact_time",
            "compressive_impulse",
            "peak_net_impulse",
        ):
            values = getattr(impact, name) / getattr(impact, name)[0]
            smooth = Chebyshev.fit(position, values, 10)(position)
            np.testing.assert_allclose(values, smooth, rtol=1e-11)
        alone = normal_impact(
            contact.at((slice(3, 8),), contact.shape), 8.0 * capture_velocity(contact)[3:8]
        )
        assert np.array_equal(alone.contact_time, impact.contact_time[3:8])

    @pytest.mark.parametrize("viscous_time", [1e-7, 1e-6, 1e-4])
    def test_overdamped_spheres_creep_or_turn_and_stay(self, build, viscous_time):
        """Hard ones turn beyond equilibrium, soft ones creep towards it; neither fails."""
        contact = build(JKR(viscous_time=viscous_time), diameter=1e-6, work=5.0)
        assert capture_velocity(contact) == math.inf
        impact = normal_impact(contact, np.array([1e-3, 0.1, 10.0, 1e3]))
        assert impact.captured.all()
        book = Textbook(contact)
        balance = (6 * math.pi * 5.0 * book.radius**2 / contact.hertz_stiffness) ** (1 / 3)
        least = book.compression(balance)
        assert np.all(impact.maximum_compression >= least * (1 - 1e-6))
        assert impact.maximum_compression[0] == approx(least, rel=1e-6)

    def test_heavily_damped_restitution_goes_with_the_fifth_power(self, build):
        times = np.array([1e-6, 2e-6])
        contact = build(JKR(viscous_time=times), work=0.0)
        assert not capture_velocity(contact).any()
        e = normal_impact(contact, 1.0).coefficient_of_restitution
        assert math.log2(e[1] / e[0]) == approx(-5.0, abs=1e-4)
        with pytest.raises(ValueError, match=r"law\.viscous_time must be at most .* got 0\.001"):
            normal_impact(build(JKR(viscous_time=1e-3), work=0.0), 1.0)


class TestThorntonNing:
    SPEED = np.geomspace(0.05, 50.0, 40)

    def test_without_adhesion_it_is_the_published_closed_form(self, build):
        contact = build(ThorntonNing(yield_pressure=1.6e9), work=0.0)
        limit = yield_velocity(contact, 1e9)
        e = normal_impact(contact, self.SPEED).coefficient_of_restitution
        np.testing.assert_allclose(e, plastic_restitution(self.SPEED, limit), rtol=1e-13)
        assert normal_impact(contact, 0.999 * limit).coefficient_of_restitution == approx(
            1, rel=1e-12
        )

    def test_loading_is_that_of_the_published_stiffness(self, build):
        """dP/dx = (3 pi R p_y P_1^(1/2) - 2 R* E* a P_c^(1/2)) / (3 P_1^(1/2) - P_c^(1/2))."""
        contact = build(ThorntonNing(yield_pressure=2e9))
        book, speed = Textbook(contact), 1.0
        r, modulus, limit = book.radius, book.modulus, 1.5 * math.pi * book.work * book.radius

        def pressure(a):
            tensile = math.sqrt(2 * modulus * book.work / (math.pi * a))
            return 2 * modulus * a / (math.pi * r) - tensile

        start = brentq(lambda a: pressure(a) - 2e9, 1e-7, 1e-5, xtol=1e-20)

        def rates(a, y):
            hertz = math.sqrt(4 * modulus * a**3 / (3 * r))
            grip = math.sqrt(limit)
            stiffness = (3 * math.pi * r * 2e9 * hertz - 2 * modulus * a * grip) / (
                3 * hertz - grip
            )
            return [stiffness * book.slope(a), y[0] * book.slope(a)]

        before = [book.force(start), book.energy(book.closed, start)]
        kinetic = 0.5 * book.mass * speed**2

        def stops(_, y):
            return y[1] - kinetic

        stops.terminal = True
        path = solve_ivp(
            rates, (start, 1e-4), before, events=stops, method="DOP853", rtol=1e-12, atol=0
        )
        a, force = path.t[-1], path.y[0, -1]
        impact = normal_impact(contact, speed)
        assert impact.maximum_compression == approx(book.compression(a), rel=1e-8)
        # Unloads as JKR with the radius that has this contact radius at this force.
        elastic = Textbook(contact)
        cube = 4 * modulus * a**3 / 3
        book.radius = cube / (force + math.sqrt(8 * math.pi * book.work * modulus * a**3))
        left = book.energy(book.broken, a)
        assert impact.coefficient_of_restitution == approx(math.sqrt(left / kinetic), 1e-8)
        # In the bulk: the work there and back, of which the surfaces take no part.
        closing = elastic.energy(0.0, elastic.closed)
        lost = closing + kinetic - book.energy(0.0, a)
        assert impact.losses.bulk == approx(lost, rel=1e-6)
        # By the pull of the closing contact, and of the flattened one that breaks.
        lost = book.energy(0.0, book.broken) - closing
        assert impact.losses.adhesion == approx(lost, rel=1e-6)


class TestHysteresis:
    @pytest.mark.parametrize("work", [0.0, 0.5, 3.9])
    def test_the_loss_is_that_of_area_and_of_both_ends(self, build, work):
        """(w_2 - w_1) pi a^2, the elastic contact that closes and the one that breaks."""
        contact = build(Hysteresis(unloading_work=4.0), work=work)
        impact = normal_impact(contact, np.array([0.75, 1.66, 20.0]))
        book, opening = Textbook(contact), Textbook(contact, 4.0)
        for i, compression in enumerate(impact.maximum_compression):
            a = brentq(lambda x, c=compression: book.compression(x) - c, 1e-7, 1e-4, xtol=1e-20)
            lost = (4.0 - work) * math.pi * a**2 + opening.energy(0.0, opening.broken)
            lost -= book.energy(0.0, book.closed) if work else 0.0
            assert impact.losses.adhesion[i] == approx(lost, rel=1e-9)
        assert not impact.losses.bulk.any()

    def test_it_does_not_gain_energy(self, build):
        with pytest.raises(ValueError, match=r"law\.unloading_work must not be below .*0\.5"):
            build(Hysteresis(unloading_work=0.4))


@pytest.mark.parametrize(
    "law",
    [JKR(viscous_time=1e-30), ThorntonNing(yield_pressure=1e12), Hysteresis(unloading_work=0.5)],
    ids=lambda law: law.name,
)
def test_without_viscosity_yield_or_hysteresis_it_is_the_elastic_contact(build, law):
    """The viscous one is integrated, the elastic one a closed form."""
    speed = np.geomspace(0.018, 20.0, 30)
    found, elastic = (normal_impact(build(each), speed) for each in (law, JKR()))
    for name, error in {
        "coefficient_of_restitution": 1e-11,
        "contact_time": 1e-6,
        "compression_time": 1e-10,
        "maximum_compression": 1e-13,
        "compressive_impulse": 1e-11,
        "peak_net_impulse": 1e-11,
    }.items():
        assert getattr(found, name) == approx(getattr(elastic, name), rel=error), name
    assert np.all(np.abs(found.losses.bulk) <= 1e-12 * build(law).mass * speed**2)


@every_law
class TestEveryLaw:
    def test_friction_of_thornton_and_yin_counts_twice_the_pull_off_force(self, build, law):
        contact = build(law)
        if isinstance(law, MaugisBarquins):  # its edge may pull harder
            with pytest.raises(ValueError, match="'pull-off' does not go with the law 'maugis"):
                simulate(contact, 1.0, friction_basis="pull-off")
            return
        impact = normal_impact(contact, 0.4)
        slid = simulate(contact, 40.0, math.degrees(math.asin(0.01)), friction_basis="pull-off")
        extra = 2 * contact.pull_off_force * impact.contact_time
        whole = contact.mass * 0.4 * (1 + impact.coefficient_of_restitution)
        assert slid.impulse_ratio == approx(0.15 * (1 + extra / whole), rel=1e-9)

    @pytest.mark.parametrize("basis", ["compressive", "net", "pull-off"])
    def test_the_path_ends_as_the_impact_and_obeys_newton(self, build, law, basis):
        contact = build(law)
        if basis == "pull-off" and isinstance(law, MaugisBarquins):
            pytest.skip("refused")
        impact = simulate(contact, 1.66, 60.0, 100.0, friction_basis=basis)
        path = trajectory(contact, 1.66, 60.0, 100.0, points=2000, friction_basis=basis)
        ends = {
            "time": impact.contact_time,
            "velocity": impact.normal_velocity,
            "tangential_velocity": impact.tangential_velocity,
            "spin": impact.spin,
        }
        for name, value in ends.items():
            assert getattr(path, name)[-1] == approx(value, rel=1e-8)
        assert path.compression.max() == approx(impact.maximum_compression, rel=1e-5)
        pushed = np.gradient(path.velocity, path.time)[2:-2] * contact.mass
        greatest = path.normal_force.max()
        np.testing.assert_allclose(path.normal_force[2:-2] / greatest, pushed / greatest, atol=1e-4)
        lost = -np.trapezoid(path.hertz_damping_force * path.velocity, path.time)
        if isinstance(law, JKR):
            bulk = normal_impact(contact, 1.66 * math.sin(math.radians(60.0))).losses.bulk
            assert lost == approx(bulk, rel=1e-4, abs=1e-6 * impact.energy_loss)

    def test_a_captured_sphere_is_followed_to_its_second_turn(self, build, law):
        contact = build(law)
        path = trajectory(contact, 0.9 * capture_velocity(contact))
        assert path.captured
        assert path.velocity[-1] == approx(0.0, abs=1e-6 * path.velocity.max())
        assert path.compression[-1] < 0.5 * path.compression.max()

    def test_what_needs_the_ring_force_says_what_to_do(self, build, law):
        contact = build(law)
        with pytest.raises(ValueError, match=f"'ring force', got '{law.name}': take 'rigid'"):
            simulate(contact, 1.0, 45.0, tangential="mindlin")
        with pytest.raises(ValueError, match=f"'hertz' does not go with the law '{law.name}'"):
            simulate(contact, 1.0, 45.0, friction_basis="hertz")
        said = f"contact must have the law 'ring force' here, got '{law.name}'"
        with pytest.raises(ValueError, match=said):
            normal_impact(contact, 1.0, ledger=True)
        with pytest.raises(ValueError, match="'pull-off' does not go with the law 'ring force'"):
            simulate(build("ring force"), 1.0, 45.0, friction_basis="pull-off")


def test_parameters_of_a_law_are_arrays_too(build):
    times = np.array([0.0, 1e-9, 3e-9])
    e = normal_impact(build(JKR(viscous_time=times)), 1.0).coefficient_of_restitution
    assert build(JKR(viscous_time=times)).shape == (3,)
    assert np.all(np.diff(e) < 0.0)
    assert e[0] == approx(normal_impact(build(JKR()), 1.0).coefficient_of_restitution, rel=1e-9)


TN = ThorntonNing(yield_pressure=1e9)


@pytest.mark.parametrize(
    ("law", "changes", "error", "message"),
    [
        ("hertz", {}, ValueError, "law must be one of 'ring force', 'jkr', 'thornton-ning'"),
        ("hysteresis", {}, ValueError, r"law=Hysteresis\(unloading_work="),
        (3.0, {}, TypeError, "law must be 'ring force' or one of JKR"),
        *(
            (TN, {field: value}, ValueError, f"law 'thornton-ning' does not know {field}")
            for field, value in (
                ("hertz_damping", 0.1),
                ("adhesion_damping", [0.0, 1.0]),
                ("stiffness_model", "reduced"),
                ("damped_attachment", True),
            )
        ),
        (TN, {"work": None, "ring_force": 1.0}, ValueError, "does not know ring_force"),
    ],
)
def test_a_law_is_a_record_or_a_name_without_parameters_of_the_ring_force(
    build, law, changes, error, message
):
    with pytest.raises(error, match=message):
        build(law, **changes)
    assert build("ring force").law is None
    assert build("jkr").law.viscous_time == 0.0


@pytest.mark.parametrize("value", [-1e-9, math.nan, "1", True])
def test_parameters_are_checked(value):
    with pytest.raises((TypeError, ValueError), match=r"^law\.viscous_time must be"):
        JKR(viscous_time=value)
