"""The reference of adhesive impacts, and codes with a mistake against it."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.shared import ROOT

from microimpact.core.materials import Material
from microimpact.model import reference, verification
from microimpact.model.closed_forms import jkr_loss
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.force_laws import jkr_restitution
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.reference import CASES
from microimpact.model.verification import ENDS, NOT_REDUCED, RIGID_WALL, STARTS, TIME_STEP, WORKS

FINE = 4000
BROKEN_EARLY, BROKEN_AT_TOUCH = ENDS[3.0], ENDS[4.0]
BEGUN_LATE = STARTS[6.0]
SPEEDS = np.array([0.035, 0.05, 0.06, 0.08, 0.1, 0.2, 0.5])


class Code:
    """A code of particles: velocity Verlet on a JKR contact in SI units, with some mistake.

    Closing and break are at cubes of s over b, as in `verification`, at a^3 = cube^2 pi w R^2/6K.
    """

    def __init__(self, contact, *, start=4.0, end=1.0, factor=1.0):
        self.radius, self.mass = float(contact.hertz_radius), float(contact.mass)
        self.stiffness = float(contact.hertz_stiffness)
        self.work = factor * contact.work_of_adhesion
        self.time = contact.law.viscous_time
        least = (math.pi * self.work * self.radius**2 / (6 * self.stiffness)) ** (1 / 3)
        self.a = least * np.geomspace(1.0, 60.0, 200_000)
        self.overlap = self.overlap_at(self.a)
        self.begins = self.overlap_at(least * start ** (2 / 3))
        self.ends = self.overlap_at(least * end ** (2 / 3))

    def overlap_at(self, a):
        pull = np.sqrt(6 * np.pi * self.work * a / self.stiffness)
        return a**2 / self.radius - 2 / 3 * pull

    def acceleration(self, overlap, rate):
        a = np.interp(overlap, self.overlap, self.a)
        elastic = self.stiffness * a**3 / self.radius
        pull = np.sqrt(6 * np.pi * self.work * self.stiffness * a**3)
        damping = 1.5 * self.stiffness * a * self.time * rate
        return -(elastic - pull + damping) / self.mass

    def restitution(self, speed, steps):
        """Return e of one impact, 0 if the contact lasts, in so many steps a Hertz contact."""
        group = self.mass**2 / (self.stiffness**2 * self.radius * speed)
        step = 2.94 * (1.25**2 * group) ** 0.2 / steps
        overlap, rate, touching, acceleration = -0.3 * speed * step, speed, False, 0.0
        for _ in range(8 * steps):
            half = rate + 0.5 * step * acceleration
            overlap += step * half
            touching = overlap >= self.ends if touching else overlap >= self.begins
            acceleration = self.acceleration(overlap, half) if touching else 0.0
            rate = half + 0.5 * step * acceleration
            if not touching and rate < 0.0:
                return -rate / speed
        return 0.0


def restitutions(case, steps=FINE, contact=None, **mistake):
    code = Code(contact or CASES[case].contact, **mistake)
    return np.array([code.restitution(speed, steps) for speed in SPEEDS])


def verdict(case, *arguments, **mistake):
    return verification.verify(case, SPEEDS, restitutions(case, *arguments, **mistake))


@pytest.mark.parametrize("case", ["jkr-wall", "jkr-pair", "viscous-jkr-wall"])
def test_a_code_without_a_mistake_agrees(case):
    found = verdict(case)
    assert found.agrees, found
    assert abs(found.difference) < 2e-3


@pytest.mark.parametrize(
    ("mistake", "words"),
    [
        ({"end": 3.0}, BROKEN_EARLY),
        ({"end": 4.0}, BROKEN_AT_TOUCH),
        ({"start": 6.0}, BEGUN_LATE),
        ({"factor": 2.0}, WORKS[2.0]),
        ({"factor": 0.5}, WORKS[0.5]),
        ({"end": 3.0, "factor": 2.0}, f"{BROKEN_EARLY}; {WORKS[2.0]}"),
    ],
)
@pytest.mark.parametrize("case", ["jkr-wall", "viscous-jkr-wall"])
def test_a_mistake_is_named(case, mistake, words):
    found = verdict(case, **mistake)
    assert not found.agrees
    assert found.causes[0][0] == words, found


def test_mistakes_of_the_bodies_are_named():
    pair, wall = CASES["jkr-pair"].contact, CASES["jkr-wall"].contact
    single = pair.replace(partner_diameter=math.inf)
    assert verdict("jkr-pair", contact=single).causes[0][0] == NOT_REDUCED
    stiff = 2.0 * wall.surface.youngs_modulus
    like_rigid = {
        role: Material(name=role, youngs_modulus=stiff, poissons_ratio=0.25, density=2500.0)
        for role in ("particle", "surface")
    }
    assert verdict("jkr-wall", contact=wall.replace(**like_rigid)).causes[0][0] == RIGID_WALL


def test_the_page_has_the_losses_of_the_mistakes():
    page = (ROOT / "docs/jkr-for-implementers.md").read_text(encoding="utf-8")
    printed = re.findall(r"(?m)^\|.*\| (\d[.\d]*) \| (\d[.\d]*) \|$", page.split("| mistake |")[1])
    contact, speed = CASES["jkr-wall"].contact, np.array([0.5])
    rigid = Material(name="rigid", youngs_modulus=1e30, poissons_ratio=0.25, density=2500.0)
    double, half = (contact.replace(work_of_adhesion=factor * 0.1) for factor in (2.0, 0.5))
    curves = [
        jkr_restitution(changed, speed, start, end)
        for changed, start, end in (
            *((contact, 4.0, 3.0), (double, 4.0, 1.0), (double, 4.0, 3.0), (half, 4.0, 1.0)),
            *((contact, 6.0, 1.0), (contact, 4.0, 4.0), (contact.replace(surface=rigid), 4.0, 1.0)),
        )
    ]
    whole = 1 - jkr_restitution(contact, speed) ** 2
    losses = [max(float(((1 - e**2) / whole)[0]), 0.0) for e in curves]
    assert np.array(printed, dtype=float) == pytest.approx(
        np.array([(loss, math.sqrt(loss)) for loss in losses]), abs=6e-4
    )


def test_long_time_steps_are_named():
    found = verdict("jkr-wall", 12)
    assert [words for words, _ in found.causes] == [TIME_STEP], found


def test_damping_of_the_total_force_is_named():
    """m v dv/dn = -F (1 + c v), F the Hertz force less the ring force, in steps of n."""
    contact = CASES["ring-force-wall"].contact
    stiffness = float(contact.stiffness * np.sqrt(contact.hertz_radius) / contact.mass)
    pull = float(2 * np.pi * contact.ring_force * np.sqrt(contact.hertz_radius) / contact.mass)

    def rates(_, y):
        n = max(y[0], 0.0)
        force = stiffness * n**1.5 - pull * math.sqrt(n)
        return [y[1], -force * (1 + contact.hertz_damping * y[1])]

    def parted(_, y):
        return y[0]

    parted.terminal, parted.direction = True, -1
    e = []
    for speed in SPEEDS:
        path = solve_ivp(rates, (0, 1e-6), [1e-16, speed], events=parted, rtol=1e-9, atol=1e-18)
        e.append(-path.y[1, -1] / speed)
    found = verification.verify("ring-force-wall", SPEEDS, np.array(e))
    assert found.causes[0][0].startswith("Hertz damping multiplies the total force")


def test_what_is_unknown_is_called_so():
    e = 0.9 * restitutions("jkr-wall")
    assert verification.verify("jkr-wall", SPEEDS, e).causes[0][0] == verification.UNKNOWN


def test_closed_forms_are_beside_the_numbers():
    rows = reference.impacts()
    for name in ("restitution", "contact_time", "tangential_velocity"):
        closed = next(key for key in rows[0] if key.startswith(f"{name}_closed_form"))
        value = closed.replace("_closed_form", "")
        pairs = np.array([(row[value], row[closed]) for row in rows if row[closed] == row[closed]])
        assert pairs.size
        np.testing.assert_allclose(*pairs.T, rtol=1e-12)
    for row in reference.contacts():
        closed = row["capture_velocity_closed_form_m_per_s"]
        assert math.isnan(closed) or row["capture_velocity_m_per_s"] == pytest.approx(closed, 1e-12)


@pytest.mark.parametrize("case", ["viscous-jkr-wall", "viscous-jkr-pair"])
def test_viscous_impacts_are_those_of_another_integrator(case):
    """In the contact radius a and the speed over it, by Dormand and Prince's method."""
    contact = CASES[case].contact
    assert isinstance(contact.law, JKR)
    code = Code(contact)
    least, scale = float(code.a[0]), 1.0
    drag = 1.5 * code.stiffness * code.time

    def slope(x):  # of the overlap over x, a = least x^2
        a, da = least * x * x, 2 * least * x
        pull = math.sqrt(6 * math.pi * code.work / (code.stiffness * a)) / 3
        return (2 * a / code.radius - pull) * da

    def rates(_, y):  # dt = slope dtau
        x, v = y
        a = least * x * x
        force = code.stiffness * a**3 / code.radius + drag * a * v
        force -= math.sqrt(6 * math.pi * code.work * code.stiffness * a**3)
        return [v * scale, -slope(x) * force / code.mass * scale]

    def parted(_, y):
        return y[0] - 1.0

    parted.terminal, parted.direction = True, -1
    for row in (row for row in reference.impacts() if row["case"] == case):
        speed, e = row["normal_speed_m_per_s"], row["restitution"]
        if not e:
            continue
        scale = 1 / speed
        path = solve_ivp(
            rates,
            (0, 200),
            [16 ** (1 / 6), speed],
            events=parted,
            method="DOP853",
            rtol=1e-13,
            atol=1e-16,
        )
        assert -path.y_events[0][0][1] / speed == pytest.approx(e, rel=1e-12)


def test_numbers_and_lists_will_do_but_no_complex_ones():
    verdict = verification.verify("hertz-wall", 0.1, 1.0)
    assert verdict.agrees
    assert verification.verify("hertz-wall", [0.1, 0.2], 1.0).impacts == 2
    for speed, restitution, message in (
        (0.1 + 1j, 1.0, "speed must be a real number"),
        ([0.1, 0.2], [0.9, math.nan], "e must be .* got nan at index 1"),
        ([0.1, 0.2], [0.9] * 3, r"speed \(2,\), restitution \(3,\)"),
        ([], [], "an impact at least"),
    ):
        with pytest.raises((TypeError, ValueError), match=message):
            verification.verify("hertz-wall", speed, restitution)


@pytest.mark.parametrize(
    ("words", "ratio"),
    [
        (verification.REDUCED, 0.891),
        (verification.HALF_MASS, 2 ** (1 / 2)),
        (verification.DIAMETER, 2 ** (-5 / 6)),
        (verification.DIAMETER_IN_FORCE, 2 ** (2 / 3)),
        (verification.HALF_MODULUS, 2 ** (1 / 3)),
        (verification.POISSON, 1.25 ** (-1 / 3)),
    ],
)
def test_mistakes_of_one_number_are_named(words, ratio):
    """By the closed form: v_s goes as w^(5/6) R^(2/3) K^(-1/3) m^(-1/2)."""
    contact = CASES["jkr-wall"].contact
    sticking = ratio * float(np.sqrt(2 * jkr_loss(contact) / contact.mass))
    e = np.sqrt(np.maximum(1.0 - (sticking / SPEEDS) ** 2, 0.0))
    found = verification.verify("jkr-wall", SPEEDS, e)
    assert words in [cause for cause, _ in found.causes], found


def test_the_square_of_e_is_named():
    speed = np.array([0.06, 0.1, 0.2, 0.5])
    for case in ("jkr-wall", "viscous-jkr-pair", "ring-force-wall"):
        e = normal_impact(CASES[case].contact, speed).coefficient_of_restitution
        found = verification.verify(case, speed, e**2)
        assert found.causes[0][0] == verification.SQUARED, found


def test_no_case_or_number_of_another_range_is_compared():
    for case, v, e, message in (
        ("jkr-wal", 0.1, 0.9, r"case 'jkr-wal' unknown \(did you mean 'jkr-wall'\?\)"),
        ("jkr-wall", 0.1, -1.0, "e must be .*, got -1"),
        ("jkr-wall", 0.0, 0.9, "speeds? must be finite and .*, got 0"),
    ):
        with pytest.raises(ValueError, match=message):
            verification.verify(case, np.array([v]), np.array([e]))
