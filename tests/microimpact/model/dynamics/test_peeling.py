"""Work of separation that goes with the speed of the edge: limits, similarity, own integration."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from microimpact.model.closed_forms import contact_modulus
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import EDGE_SPEEDS, JKR, Hysteresis, MaugisBarquins
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact


@pytest.fixture(scope="module")
def build(steel, silicon):
    def contact(law, work=0.1, **changes):
        fields = {"particle": steel, "surface": silicon, "diameter": 62e-6} | changes
        return Contact(work_of_adhesion=work, law=law, **fields)

    return contact


def edge(speed, exponent, viscous_time=0.0):
    return MaugisBarquins(edge_speed=speed, edge_exponent=exponent, viscous_time=viscous_time)


def restitution(contact, speed):
    return normal_impact(contact, speed).coefficient_of_restitution


class Flat:
    """Flat punch on the profile of a sphere, in SI: contact radius a and compression d are free."""

    def __init__(self, contact):
        self.modulus, self.radius = contact_modulus(contact), contact.hertz_radius
        self.work, self.mass, self.law = contact.work_of_adhesion, contact.mass, contact.law

    def force(self, a, d):
        return 2 * self.modulus * a * (d - a**2 / (3 * self.radius))

    def elastic(self, a, d):
        r = self.radius
        return self.modulus * a * (d**2 - 2 * a**2 * d / (3 * r) + a**4 / (5 * r**2))

    def release(self, a, d):
        """Energy released per area that opens: minus the slope of the elastic energy."""
        return self.modulus * (a**2 / self.radius - d) ** 2 / (2 * math.pi * a)

    def jkr(self, a):
        """Compression at which the release is the work of adhesion."""
        return a**2 / self.radius - math.sqrt(2 * math.pi * self.work * a / self.modulus)

    def energy(self, a):
        return self.elastic(a, self.jkr(a)) - self.work * math.pi * a**2

    def impact(self, speed, errors):
        """Restitution, contact time, work of separation over what closing gave, loss in the bulk.

        Closing by JKR in its contact radius, then the edge by its own speed.
        """
        law, (r, e) = self.law, (self.radius, self.modulus)
        closed = (2 * math.pi * self.work * r**2 / e) ** (1 / 3)

        def closes(_, y):
            a, v = y[:2]
            slope = 2 * a / r - math.sqrt(math.pi * self.work / (2 * e * a))
            drag = 2 * e * a * law.viscous_time * v
            return [v / slope, -(self.force(a, self.jkr(a)) + drag) / self.mass, drag * v]

        def turns(_, y):
            return y[1]

        turns.terminal, turns.direction = True, -1.0
        start = [closed, speed, 0.0]
        there = solve_ivp(closes, (0, 1e-4), start, events=turns, **errors([closed, speed, 1e-9]))
        top = there.y[0, -1]
        unit = math.sqrt(self.mass / (2 * e * top))

        def opens(_, y):
            a, d, v = y[:3]
            excess = max(self.release(a, d) / self.work - 1.0, 0.0)
            pace = law.edge_speed * excess ** (1 / law.edge_exponent)
            work = self.work * (1.0 + (pace / law.edge_speed) ** law.edge_exponent)
            drag = 2 * e * a * law.viscous_time * v
            rates = [-pace, v, -(self.force(a, d) + drag) / self.mass, 1.0]
            rates += [2 * math.pi * a * pace * work, drag * v]
            return np.array(rates) / (1.0 + unit * pace / a)

        def parts(_, y):
            return y[0] - 1e-5 * top

        parts.terminal = True
        start = [top, self.jkr(top), 0.0, 0.0, 0.0, 0.0]
        size = [top, top**2 / r, speed, unit, self.mass * speed**2, self.mass * speed**2]
        back = solve_ivp(opens, (0, np.inf), start, events=parts, **errors(size))
        a, d, v, time, work, bulk = back.y[:, -1]
        # What is left elastic goes into the last of the area; closing gave no speed.
        work += self.elastic(a, d)
        lost = work - self.work * math.pi * top**2 - self.energy(closed)
        return -v / speed, there.t[-1] + time, lost, there.y[2, -1] + bulk


def errors_of(method):
    return lambda size: {"method": method, "rtol": 1e-12, "atol": 1e-13 * np.abs(size)}


@pytest.mark.parametrize(
    ("law", "work", "speed", "method"),
    [
        (edge(0.05, 0.96), 0.1, 1.66, "DOP853"),
        (edge(0.05, 0.96, 3e-9), 0.1, 0.3, "DOP853"),
        (edge(5.0, 2.0), 0.3, 0.75, "DOP853"),
        (edge(0.02, 0.5, 1e-9), 0.02, 1.66, "DOP853"),
        (edge(1e-12, 0.1), 0.3, 5.0, "DOP853"),
        (edge(30.0, 1.0), 2.0, 0.2, "DOP853"),
        (edge(1e3, 1.0), 2.0, 0.2, "LSODA"),
    ],
)
def test_an_integration_of_its_own_agrees_and_the_energies_sum_up(build, law, work, speed, method):
    contact = build(law, work)
    e, time, lost, bulk = Flat(contact).impact(speed, errors_of(method))
    impact = normal_impact(contact, speed)
    kinetic = 0.5 * contact.mass * speed**2
    assert impact.coefficient_of_restitution == pytest.approx(e, abs=1e-8)
    assert impact.contact_time == pytest.approx(time, rel=1e-6, abs=0)
    assert impact.losses.adhesion == pytest.approx(lost, abs=1e-8 * kinetic)
    assert impact.losses.bulk == pytest.approx(bulk, abs=1e-8 * kinetic)
    assert kinetic * (1 - e**2) == pytest.approx(lost + bulk, abs=1e-8 * kinetic)


SPEED = np.array([0.05, 0.2, 1.66, 20.0])


@pytest.mark.parametrize("viscous_time", [0.0, 2e-9])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
def test_a_fast_edge_is_that_of_jkr(build, exponent, viscous_time):
    jkr = build(JKR(viscous_time=viscous_time), 1.0)
    fast = build(edge(EDGE_SPEEDS[1] * np.array([[0.1], [1.0]]), exponent, viscous_time), 1.0)
    far = restitution(jkr, SPEED) - restitution(fast, SPEED)
    assert np.all((far[1] > 0.0) & (far[1] < 0.5 * far[0]))
    assert far[1].max() < 1e-4  # at a few capture velocities; 1e-6 of fast spheres
    assert capture_velocity(fast)[1].item() == pytest.approx(capture_velocity(jkr), rel=5e-6)


def test_a_slow_edge_holds_every_sphere(build):
    limit = capture_velocity(build(edge(np.array([1e-1, 1e-2, 1e-3]), 1.0)))
    assert np.all(np.diff(limit) > 0.0)
    for slowest in (1e-9, EDGE_SPEEDS[0]):
        assert not restitution(build(edge(slowest, 1.0)), SPEED).any()
    # Of m = 2 adhesion takes one share at all speeds: below some c all of it.
    assert capture_velocity(build(edge(1e-2, 2.0))) == math.inf


def test_without_an_exponent_it_is_the_hysteresis_of_twice_the_work(build):
    hysteresis = build(Hysteresis(unloading_work=2.0), 1.0)
    far = [
        restitution(build(edge(1.0, m), 1.0), 0.3) - restitution(hysteresis, 0.3)
        for m in (0.04, 0.02)
    ]
    assert abs(far[1]) < 0.01
    assert far[0] / far[1] == pytest.approx(2.0, rel=0.05)


def test_three_groups_make_an_impact(build, steel, silicon):
    """Speed over the adhesive one, edge speed over its own, and m; and A over the time."""
    one = build(edge(0.3, 0.8, 1e-9), 0.2)
    other = build(edge(0.3, 0.8), 0.05, particle=silicon, surface=steel, diameter=9e-6)
    # Adhesive speed V and compression n make a time n/V and a speed V (R/n)^(1/2) of the edge.
    units = [
        (c.velocity_scale, c.velocity_scale * math.sqrt(c.hertz_radius / c.equilibrium_compression))
        for c in (one, other)
    ]
    times = [c.equilibrium_compression / c.velocity_scale for c in (one, other)]
    law = edge(0.3 * units[1][1] / units[0][1], 0.8, 1e-9 * times[1] / times[0])
    other = other.replace(law=law)
    ratio = np.array([5.0, 20.0, 100.0])
    assert restitution(one, ratio * units[0][0]) == pytest.approx(
        restitution(other, ratio * units[1][0]), abs=1e-9
    )
    assert capture_velocity(one) / units[0][0] == pytest.approx(
        capture_velocity(other) / units[1][0], rel=1e-8
    )


@pytest.mark.parametrize("exponent", [0.35, 0.5, 0.96, 1.5])
def test_slow_edges_have_one_power_of_the_size_and_one_curve(build, exponent):
    """v_c ~ d^(-1/(1.2 - 0.6 m)), and e by v/v_c alone, where w/w_0 is large."""
    slow = 4e-24
    work = max(0.1 * (slow / 0.5) ** exponent, 1e-10)
    law = edge(0.5 * (work / 0.1) ** (1 / exponent), exponent)
    sizes = np.array([40e-6, 60e-6])
    contact = build(law, work, diameter=sizes)
    limit = capture_velocity(contact)
    power = math.log(limit[1] / limit[0]) / math.log(1.5)
    assert -1.0 / power == pytest.approx(1.2 - 0.6 * exponent, abs=2e-4)
    small, large = (restitution(contact, ratio * limit) for ratio in (1.5, 9.22))
    assert small[0] == pytest.approx(small[1], abs=1e-4)
    assert large[0] == pytest.approx(large[1], abs=1e-4)


@pytest.mark.parametrize("viscous_time", [0.0, 3e-9])
def test_the_capture_velocity_parts_rebounds_from_captures(build, viscous_time):
    law = edge(np.geomspace(1e-2, 1e3, 6)[:, None], np.array([0.1, 0.5, 1.0, 1.9]), viscous_time)
    contact = build(law, 0.3)
    limit = capture_velocity(contact)
    known = np.isfinite(limit) & (limit < 1e6)
    speed = np.where(known, limit, 1.0)
    above, below = (restitution(contact, speed * (1 + step)) for step in (1e-7, -1e-7))
    assert np.all(above[known] > 0.0)
    assert not below[known].any()
    assert np.all(limit > capture_velocity(build(JKR(viscous_time=viscous_time), 0.3)) * (1 - 1e-9))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"edge_exponent": 2.1},
            r"law\.edge_exponent must be finite and in \[0\.02, 2\], got 2\.1",
        ),
        ({"edge_speed": 0.0}, r"law\.edge_speed must be finite and in \[1e-24, 1e\+06\], got 0"),
        ({"viscous_time": -1.0}, r"law\.viscous_time must be"),
    ],
)
def test_parameters_are_checked(change, message):
    with pytest.raises(ValueError, match=message):
        MaugisBarquins(**{"edge_speed": 1.0, "edge_exponent": 1.0} | change)
