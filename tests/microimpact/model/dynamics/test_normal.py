"""Normal impact against closed forms, a table of high precision and conservation laws."""

import csv
import math
from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import gamma, lambertw
from tests.shared import ROOT

from microimpact.model.dynamics import normal
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import (
    ALWAYS_CAPTURED_ADHESION_GROUP,
    ALWAYS_CAPTURED_HERTZ_GROUP,
    SMALLEST_SPEED,
    normal_impact,
)

# Of SI numbers, which may be small: a share alone.
approx = partial(pytest.approx, abs=0.0)

EPSILON = np.finfo(float).eps
TABLE = ROOT / "tests/reference/restitution.csv"
REFERENCE = [
    {name: float(value) for name, value in row.items()}
    for row in csv.DictReader(TABLE.read_text(encoding="utf-8").splitlines())
]


def _label(row):
    kind = "" if row["adhesion"] else "bare-"
    return f"{kind}w{row['w']:g}-cH{row['c_h']:g}-cA{row['c_a']:g}-{row['damped_attachment']:g}"


def in_units_of_the_table(scaled, row):
    """Contact and speed of a row, with the units of velocity, time and length of its results."""
    if row["adhesion"]:
        contact = scaled(row["c_h"], row["c_a"], damped_attachment=bool(row["damped_attachment"]))
        velocity, length = contact.velocity_scale, contact.equilibrium_compression
    else:
        velocity = 2.0
        contact = scaled().replace(ring_force=0.0, hertz_damping=row["c_h"] / velocity)
        hertz = np.sqrt(contact.hertz_radius) * contact.stiffness
        length = (contact.mass * velocity**2 / hertz) ** 0.4
    return contact, row["w"] * velocity, velocity, length / velocity, length


def conditioning(row):
    """Relative error of e that a rounding of the inputs alone brings about near the threshold."""
    return EPSILON * row["w"] / (row["w"] - row["capture_speed"])


@pytest.mark.parametrize("row", REFERENCE, ids=_label)
def test_impacts_agree_with_the_table_of_high_precision(scaled, row):
    contact, speed, velocity, time, length = in_units_of_the_table(scaled, row)
    impact = normal_impact(contact, speed)
    # e ~ sqrt(v/v_c - 1): within 1e-6 of the threshold a speed given to 16 digits gives e to 10.
    tolerance = max(1e-12, 100 * conditioning(row))
    assert abs(impact.coefficient_of_restitution / row["e"] - 1) <= tolerance
    assert abs(impact.contact_time / time / row["contact_time"] - 1) <= tolerance
    assert abs(impact.maximum_compression / length / row["compression"] - 1) <= 1e-12
    assert capture_velocity(contact) / velocity == approx(row["capture_speed"], rel=2e-12)


@pytest.mark.parametrize(
    ("w", "c_h", "c_a", "damped"),
    [
        (0.7, 0.02, 0.1, False),
        (2.0, 0.0, 0.5, False),
        (3.0, 0.05, 0.5, True),
        (10.0, 0.05, 0.2, False),
        (0.3, 0.02, 0.1, False),
    ],
)
def test_the_time_form_gives_the_same_impact(scaled, time_form, w, c_h, c_a, damped):
    contact = scaled(c_h, c_a, damped_attachment=damped)
    velocity, length = contact.velocity_scale, contact.equilibrium_compression
    momentum = contact.mass * velocity
    impact = normal_impact(contact, w * velocity)
    march = time_form(w, c_h, c_a, damped_attachment=damped)
    assert bool(impact.captured) == march.captured
    assert impact.coefficient_of_restitution == approx(march.e, rel=1e-8)
    assert impact.maximum_compression / length == approx(march.compression, rel=1e-8)
    if not march.captured:
        assert impact.contact_time * velocity / length == approx(march.contact_time, rel=1e-7)
        assert impact.compressive_impulse / momentum == approx(march.compressive_impulse, rel=1e-7)
        assert impact.peak_net_impulse / momentum == approx(march.peak_net_impulse, rel=1e-6)


class TestWithoutAdhesion:
    @pytest.mark.parametrize("damping", [1e-6, 1e-3, 0.1, 1.0, 10.0, 100.0])
    def test_restitution_is_that_of_hunt_and_crossley(self, contact, damping):
        bare = contact.replace(ring_force=0.0, hertz_damping=damping, adhesion_damping=0.0)
        e = normal_impact(bare, 1.0).coefficient_of_restitution
        # d - ln(1 + d) = -e d - ln(1 - e d): the other real branch of Lambert's function
        d = damping
        if d >= 0.1:
            exact = (1 + lambertw(-(1 + d) * np.exp(-(1 + d))).real) / d
            assert e == approx(exact, rel=1e-12)
        if d <= 10:
            lost = d - np.log1p(d)
            assert -e * d - np.log1p(-e * d) == approx(lost, rel=1e-9, abs=1e-15)

    def test_adhesive_damping_has_nothing_to_act_on(self, contact):
        bare = contact.replace(ring_force=0.0, hertz_damping=0.1, adhesion_damping=0.0)
        damped = contact.replace(ring_force=0.0, hertz_damping=0.1, adhesion_damping=1e3)
        assert (
            normal_impact(damped, 1.0).coefficient_of_restitution
            == normal_impact(bare, 1.0).coefficient_of_restitution
        )

    def test_the_elastic_contact_time_is_that_of_hertz(self, contact):
        bare = contact.replace(ring_force=0.0, hertz_damping=0.0)
        speed = np.array([1e-6, 1.0, 30.0])
        impact = normal_impact(bare, speed)
        constant = 0.8 * np.sqrt(np.pi) * gamma(0.4) / gamma(0.9)
        assert constant == approx(2.9433, abs=5e-5)
        assert impact.contact_time == approx(
            constant * impact.maximum_compression / speed, rel=1e-13
        )
        assert impact.compression_time == approx(impact.contact_time / 2, rel=1e-13)
        hertz = np.sqrt(bare.hertz_radius) * bare.stiffness
        deepest = (1.25 * bare.mass * speed**2 / hertz) ** 0.4
        assert impact.maximum_compression == approx(deepest, rel=1e-13)


class TestWithoutDamping:
    @pytest.mark.parametrize("basis", ["adhesive", "bare"])
    def test_restitution_is_one_at_every_speed(self, scaled, basis):
        contact = scaled() if basis == "adhesive" else scaled(ring_force=0.0)
        speed = scaled().velocity_scale * np.geomspace(1e-6, 1e6, 121)
        impact = normal_impact(contact, speed)
        assert not impact.captured.any()
        assert np.abs(impact.coefficient_of_restitution - 1).max() <= 1e-12

    @pytest.mark.parametrize("w", [1e-6, 1e-3, 0.5, 1.0, 30.0])
    def test_the_compression_follows_from_the_energy(self, scaled, w):
        contact = scaled()
        impact = normal_impact(contact, w * contact.velocity_scale)

        def excess(x):
            return 0.4 * x**2.5 - 2 / 3 * x**1.5 - w**2 / 2

        deepest = brentq(excess, 5 / 3 * (1 - 1e-9), 10 + 10 * w, xtol=1e-15, rtol=1e-14)
        assert impact.maximum_compression / contact.equilibrium_compression == approx(
            deepest, rel=1e-12
        )


class TestNearTheThreshold:
    @pytest.mark.parametrize(("c_h", "c_a"), [(0.0, 1e-10), (1e-10, 0.0), (3e-11, 1e-10)])
    def test_a_small_damping_captures_what_it_can_dissipate(self, scaled, c_h, c_a):
        integral, _ = quad(
            lambda x: np.sqrt(x) * np.sqrt(4 / 3 * x**1.5 - 0.8 * x**2.5), 0, 5 / 3, epsabs=1e-13
        )
        assert integral == approx(0.82735, abs=5e-6)
        contact = scaled(c_h, c_a)
        predicted = np.sqrt(2 * integral * (c_a + 2 * c_h))
        # the next order in the damping is relatively of the order of w_c
        assert capture_velocity(contact) / contact.velocity_scale == approx(
            predicted, rel=predicted
        )

    def test_contacts_that_always_capture_do_so_at_every_speed(self, scaled):
        speed = scaled().velocity_scale * np.geomspace(1e-2, 1e3, 21)
        alone = (ALWAYS_CAPTURED_HERTZ_GROUP, 0.0), (0.0, ALWAYS_CAPTURED_ADHESION_GROUP)
        for c_h, c_a in (*alone, (0.6, 3.0)):
            impact = normal_impact(scaled(1.001 * c_h, 1.001 * c_a), speed)
            assert impact.captured.all()
            assert np.isinf(impact.contact_time).all()

    @pytest.mark.parametrize("damped", [False, True])
    @pytest.mark.parametrize(
        ("w", "c_h", "c_a"),
        [(0.01, 2.5, 0.0), (2.0, 8.0, 0.0), (0.01, 0.0, 2.5), (2.0, 0.0, 100.0), (1.0, 1e4, 1e4)],
    )
    def test_overdamped_contacts_are_captured_at_once(self, scaled, w, c_h, c_a, damped):
        """The approach may creep into the well and never turn."""
        contact = scaled(c_h, c_a, damped_attachment=damped)
        impact = normal_impact(contact, w * contact.velocity_scale)
        assert impact.captured
        assert impact.maximum_compression >= (1 - 1e-9) * contact.equilibrium_compression
        assert np.isfinite(impact.compressive_impulse)


class TestLedger:
    @pytest.mark.parametrize(("w", "captured"), [(2.0, False), (0.3, True)])
    def test_entries_add_up_in_si_units(self, scaled, w, captured):
        contact = scaled(0.05, 0.3)
        speed = w * contact.velocity_scale
        impact = normal_impact(contact, speed, ledger=True)
        ledger = impact.ledger
        assert impact.captured == captured
        before = 0.5 * contact.mass * speed**2
        assert ledger.kinetic_before == approx(before, rel=1e-14)
        left = ledger.kinetic_after + ledger.stored + ledger.hertz_work + ledger.adhesion_work
        assert left == approx(before, rel=1e-12)
        if captured:
            assert ledger.kinetic_after + ledger.stored <= 0.0
        else:
            assert ledger.kinetic_after == approx(
                before * impact.coefficient_of_restitution**2, rel=1e-13
            )
            total = (
                ledger.hertz_impulse
                + ledger.adhesion_impulse
                + ledger.hertz_damping_impulse
                + ledger.adhesion_damping_impulse
            )
            change = contact.mass * speed * (1 + impact.coefficient_of_restitution)
            assert total == approx(change, rel=1e-12)
            assert ledger.stored == ledger.hertz_damping_impulse == 0.0 > ledger.adhesion_impulse

    def test_a_speed_beyond_double_precision_is_an_error(self, contact):
        slow = 0.5 * SMALLEST_SPEED * contact.velocity_scale
        with pytest.raises(ValueError, match=r"speed must be at least 1e-30 .* got .* m/s"):
            normal_impact(contact, slow)
        with pytest.raises(ValueError, match=r"hertz_damping times speed must be at most 1e\+15"):
            normal_impact(contact.replace(hertz_damping=1e16), 1.0)


class TestHeavyDamping:
    """Far above c_H v = 1 a rebound creeps, and the integration alone would not end."""

    @pytest.mark.parametrize("damping", [2e4, 1e8, 1e12, 9e14])
    def test_a_sphere_leaves_at_one_over_the_damping(self, contact, damping):
        heavy = contact.replace(work_of_adhesion=0.0, adhesion_damping=0.0, hertz_damping=damping)
        impact = normal_impact(heavy, np.array([1.0, 1.1]), ledger=True)
        # exactly, y = c_H V obeys -y - ln(1 - y) = C - ln(1 + C): y = 1 but for exp(-C)
        assert impact.coefficient_of_restitution == approx(
            1.0 / (damping * np.array([1.0, 1.1])), rel=1e-12
        )
        assert impact.ledger.energy_residual == approx(0.0, abs=1e-11)
        # creeping back from the greatest compression at that speed
        assert impact.contact_time == approx(
            impact.maximum_compression * damping, rel=0.3 * damping**-0.4
        )

    def test_it_does_not_spoil_the_other_impacts(self, contact):
        some = contact.replace(hertz_damping=np.array([1e-3, 1e9]), adhesion_damping=0.0)
        alone = normal_impact(contact.replace(hertz_damping=1e-3, adhesion_damping=0.0), 2.0)
        impact = normal_impact(some, 2.0)
        assert impact.coefficient_of_restitution[0] == alone.coefficient_of_restitution
        assert impact.captured.tolist() == [False, True]

    @pytest.mark.parametrize("c_a", [0.0, 0.03])
    @pytest.mark.parametrize("c_h", [1e-4, 0.1, 0.45])
    def test_both_ways_agree_where_the_integration_still_ends(self, scaled, monkeypatch, c_h, c_a):
        contact = scaled(c_h, c_a, damped_attachment=c_h == 0.1)
        speed = np.array([2e4, 1e5]) / contact.hertz_damping
        quick = normal_impact(contact, speed, ledger=True)
        monkeypatch.setattr(normal, "STIFF", math.inf)
        slow = normal_impact(contact, speed, ledger=True)
        for name, error in {
            "coefficient_of_restitution": 1e-12,
            "contact_time": 1e-9,
            "compression_time": 1e-12,
            "maximum_compression": 1e-13,
            "compressive_impulse": 1e-9,
            "peak_net_impulse": 1e-9,
            "hertz_impulse": 1e-10,
        }.items():
            assert getattr(quick, name) == approx(getattr(slow, name), rel=error)
        assert quick.ledger.hertz_work == approx(slow.ledger.hertz_work, rel=1e-9)
        assert quick.ledger.adhesion_work == approx(slow.ledger.adhesion_work, rel=1e-5)
        assert quick.ledger.adhesion_impulse == approx(slow.ledger.adhesion_impulse, rel=1e-8)
