"""The contact: Eqs. (20)-(24), (30), (31), its scales, and its construction."""

import dataclasses
import math
import warnings
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from microimpact.core.materials import Material
from microimpact.model.contact import (
    REDUCED_STIFFNESS_SHARE,
    Contact,
    hertz_stiffness,
    ring_force_from_work,
    work_from_ring_force,
)
from microimpact.model.contact_laws import JKR, Hysteresis
from microimpact.model.dynamics.impact import simulate

# Of SI numbers, which may be small: a share alone.
approx = partial(pytest.approx, abs=0.0)


@pytest.fixture(scope="module")
def fields(steel, silicon):
    return {"particle": steel, "surface": silicon, "diameter": 62e-6, "work_of_adhesion": 0.5}


def in_other_units(material, *, length, mass, time):
    """The material in units that are this many metres, kilograms and seconds."""
    return Material(
        name=material.name,
        youngs_modulus=material.youngs_modulus * length * time**2 / mass,
        poissons_ratio=material.poissons_ratio,
        density=material.density * length**3 / mass,
    )


class TestElasticity:
    def test_stiffness_by_hand(self):
        """k = (1 - 0.36)/(pi 1e11) of both: K = 4/(3 pi 2 k) = 4e11/(6 0.64)."""
        same = Material(name="a", youngs_modulus=1e11, poissons_ratio=0.6 - 0.2, density=1.0)
        assert hertz_stiffness(same, same) == approx(4e11 / (6 * 0.84), rel=1e-14)

    def test_stiffness_is_four_thirds_of_the_contact_modulus(self, steel, silicon):
        modulus = 1 / ((1 - 0.28**2) / 193e9 + (1 - 0.25**2) / 169e9)
        assert hertz_stiffness(steel, silicon) == approx(4 / 3 * modulus, rel=1e-14)

    def test_stiffness_is_a_pressure_which_with_the_printed_square_it_is_not(self, steel, silicon):
        def printed(particle, surface):
            k = [
                (1 - m.poissons_ratio**2) / (math.pi * m.youngs_modulus)
                for m in (particle, surface)
            ]
            return 4 / (3 * math.pi * sum(k) ** 2)

        kpa = [in_other_units(m, length=1.0, mass=1e3, time=1.0) for m in (steel, silicon)]
        factor = hertz_stiffness(*kpa) / hertz_stiffness(steel, silicon)
        assert factor == approx(1e-3, rel=1e-14)
        assert printed(*kpa) / printed(steel, silicon) != approx(1e-3, rel=0.5)

    def test_stiffness_is_that_of_the_softer_body_on_a_rigid_one(self, steel):
        rigid = Material(name="rigid", youngs_modulus=1e30, poissons_ratio=0.3, density=1.0)
        expected = 4 / 3 * 193e9 / (1 - 0.28**2)
        assert hertz_stiffness(steel, rigid) == approx(expected, rel=1e-14)
        assert hertz_stiffness(rigid, steel) == hertz_stiffness(steel, rigid)

    def test_radius_of_sphere_on_sphere_by_hand(self, fields):
        contact = Contact(**fields | {"diameter": 60e-6, "surface_radius": 60e-6})
        assert contact.radius == 30e-6
        assert contact.hertz_radius == approx(20e-6, rel=1e-15)
        assert Contact(**fields).hertz_radius == approx(31e-6, rel=1e-15)

    def test_two_spheres_by_hand(self, fields):
        """Radii of 30 and 90 um; the second has 27 2330/8000 times the mass of the first."""
        contact = Contact(**fields | {"diameter": 60e-6, "partner_diameter": 180e-6})
        first, second = (rho * 4 / 3 * math.pi * r**3 for rho, r in ((8000, 3e-5), (2330, 9e-5)))
        assert contact.hertz_radius == approx(22.5e-6, rel=1e-14)
        assert contact.mass == approx(first * second / (first + second), rel=1e-14)
        assert contact.mass_share == approx(second / (first + second), rel=1e-14)
        # Equal spheres have half the radius and half the mass.
        twins = Contact(**fields | {"surface": fields["particle"], "partner_diameter": 62e-6})
        assert (twins.hertz_radius, twins.mass_share) == approx((15.5e-6, 0.5), rel=1e-14)

    def test_mass_by_hand(self, fields):
        expected = 8000 * math.pi * 62e-6**3 / 6
        assert Contact(**fields).mass == approx(expected, rel=1e-14)


class TestAdhesion:
    def test_ring_force_by_hand(self):
        assert ring_force_from_work(0.5, 8 * math.pi, 1.0) == approx(9 ** (1 / 3), rel=1e-14)

    @given(work=st.floats(1e-6, 1e3), radius=st.floats(1e-9, 1.0), stiffness=st.floats(1e5, 1e13))
    def test_work_and_ring_force_convert_both_ways(self, work, radius, stiffness):
        ring = ring_force_from_work(work, radius, stiffness)
        assert work_from_ring_force(ring, radius, stiffness) == approx(work, rel=1e-13)

    def test_either_input_gives_the_same_contact(self, fields):
        by_work = Contact(**fields)
        del (other := dict(fields))["work_of_adhesion"]
        by_force = Contact(**other, ring_force=by_work.ring_force)
        assert by_force.work_of_adhesion == approx(0.5, rel=1e-14)
        assert (by_work.adhesion_input, by_force.adhesion_input) == (
            "work_of_adhesion",
            "ring_force",
        )

    def test_the_contact_radius_at_no_load_is_that_of_jkr(self, fields):
        contact = Contact(**fields)
        jkr = (6 * math.pi * 0.5 * contact.hertz_radius**2 / contact.stiffness) ** (1 / 3)
        assert contact.equilibrium_contact_radius == approx(jkr, rel=1e-14)
        # the ring model needs three times JKR's approach for it
        jkr_approach = jkr**2 / (3 * contact.hertz_radius)
        assert contact.equilibrium_compression == approx(3 * jkr_approach, rel=1e-14)

    def test_the_pull_off_force_is_that_of_separation(self, fields):
        by_jkr = Contact(**fields, law=JKR())
        assert by_jkr.pull_off_force == approx(1.5 * math.pi * 0.5 * 31e-6, rel=1e-14)
        hysteresis = Contact(**fields, law=Hysteresis(unloading_work=2.0))
        assert hysteresis.pull_off_force == approx(1.5 * math.pi * 2.0 * 31e-6, rel=1e-14)

    def test_hertz_and_ring_force_balance_there(self, fields):
        contact = Contact(**fields)
        radius = contact.equilibrium_contact_radius
        hertz = contact.stiffness * radius**3 / contact.hertz_radius
        assert hertz == approx(2 * math.pi * radius * contact.ring_force, rel=1e-14)

    def test_the_reduced_stiffness_is_a_fixed_share(self, fields):
        plain, reduced = Contact(**fields), Contact(**fields, stiffness_model="reduced")
        share = reduced.stiffness / plain.stiffness
        assert share == approx(0.827, abs=5e-4)
        # Eq. (31) with a_c of JKR at no load
        a_c = plain.equilibrium_contact_radius
        lost = 2.5 * (5 / 9) ** 1.5 * 0.5 * math.pi * plain.hertz_radius**2 / a_c**3
        assert reduced.stiffness == approx(plain.stiffness - lost, rel=1e-13)
        assert share == approx(REDUCED_STIFFNESS_SHARE, rel=1e-15)

    def test_without_adhesion_the_stiffness_is_not_reduced(self, fields):
        contact = Contact(**fields | {"work_of_adhesion": [0.0, 0.5]}, stiffness_model="reduced")
        assert contact.stiffness / contact.hertz_stiffness == approx(
            [1.0, REDUCED_STIFFNESS_SHARE], rel=1e-15
        )


class TestScales:
    def test_the_velocity_scale_has_a_closed_form(self, fields):
        contact = Contact(**fields)
        wave = math.sqrt(3 * contact.stiffness / (4 * math.pi * 8000))
        group = 6 * math.pi * 0.5 / (contact.stiffness * contact.radius)
        assert contact.velocity_scale == approx(wave * group ** (5 / 6), rel=1e-13)

    def test_groups_are_dampings_times_the_scale(self, fields):
        contact = Contact(**fields, hertz_damping=0.2, adhesion_damping=3.0)
        c_h, c_a = contact.groups
        assert c_h == 0.2 * contact.velocity_scale
        assert c_a == 3.0 * contact.velocity_scale

    def test_adhesion_damping_follows_its_power_of_the_speed(self, fields):
        contact = Contact(
            **fields, adhesion_damping=3.0, adhesion_rate_exponent=0.5, reference_velocity=4.0
        )
        assert contact.adhesion_damping_at(1.0) == approx(6.0, rel=1e-15)
        assert contact.adhesion_damping_at(4.0) == 3.0
        assert Contact(**fields, adhesion_damping=3.0).adhesion_damping_at(0.1) == 3.0

    @pytest.mark.parametrize("units", [(1e-3, 1.0, 1.0), (1e-6, 1e-9, 1e-3), (7.0, 0.3, 11.0)])
    def test_the_impact_does_not_depend_on_the_units(self, fields, units):
        length, mass, time = units
        contact = Contact(**fields, hertz_damping=0.1, adhesion_damping=2.0)
        other = Contact(
            particle=in_other_units(contact.particle, length=length, mass=mass, time=time),
            surface=in_other_units(contact.surface, length=length, mass=mass, time=time),
            diameter=62e-6 / length,
            work_of_adhesion=0.5 * time**2 / mass,
            hertz_damping=0.1 * length / time,
            adhesion_damping=2.0 * length / time,
        )
        here = simulate(contact, 1.66, [10.0, 30.0, 60.0], 1e4)
        there = simulate(other, 1.66 * time / length, [10.0, 30.0, 60.0], 1e4 * time)
        for name in ("coefficient_of_restitution", "impulse_ratio", "energy_loss"):
            assert getattr(there, name) == approx(getattr(here, name), rel=1e-11)
        assert there.contact_time * time == approx(here.contact_time, rel=1e-11)
        assert there.spin / time == approx(here.spin, rel=1e-11)


class TestZeta:
    def test_the_damping_unit_by_hand(self, fields):
        contact = Contact(**fields, reference_velocity=1.66)
        group = contact.radius**3 * contact.stiffness * math.sqrt(1.66) / contact.mass
        assert contact.damping_unit == approx(group**-0.4, rel=1e-14)

    def test_zeta_makes_the_round_trip(self, fields):
        contact = Contact.from_zeta(
            zeta_hertz=0.3, zeta_adhesion=70.0, reference_velocity=1.66, **fields
        )
        assert contact.hertz_damping / contact.damping_unit == approx(0.3, rel=1e-15)
        assert contact.adhesion_damping / contact.damping_unit == approx(70.0, rel=1e-15)
        assert contact.reference_velocity == 1.66

    @pytest.mark.parametrize("exponent", [0.4, 2.5])
    def test_zeta_is_a_number_only_with_two_fifths(self, fields, exponent):
        """The printed 5/2 would make it depend on the unit of length."""

        def damping(contact):
            group = contact.mass / (
                contact.hertz_radius**3 * contact.stiffness * math.sqrt(contact.reference_velocity)
            )
            return group**exponent

        contact = Contact(**fields, reference_velocity=1.66)
        units = {"length": 1e-3, "mass": 1.0, "time": 1.0}
        millimetres = Contact(
            particle=in_other_units(contact.particle, **units),
            surface=in_other_units(contact.surface, **units),
            diameter=62e-3,
            work_of_adhesion=0.5,
            reference_velocity=1660.0,
        )
        # c is slowness: its number falls by a thousand
        homogeneous = damping(millimetres) / damping(contact) == approx(1e-3, rel=1e-12)
        assert homogeneous == (exponent == 0.4)
        assert (contact.damping_unit == approx(damping(contact), rel=1e-14)) == homogeneous


class TestReplace:
    def test_it_keeps_the_adhesion_that_was_given(self, fields):
        contact = Contact(**fields)
        smaller = contact.replace(diameter=10e-6)
        assert smaller.work_of_adhesion == 0.5
        assert smaller.ring_force == approx(contact.ring_force * (10 / 62) ** (1 / 3), rel=1e-14)
        by_force = contact.replace(ring_force=9.0)
        assert by_force.adhesion_input == "ring_force"
        assert by_force.replace(diameter=10e-6).ring_force == 9.0
        assert by_force.replace(work_of_adhesion=0.1).adhesion_input == "work_of_adhesion"

    def test_that_of_dataclasses_does_the_same(self, fields):
        contact = Contact(**fields)
        smaller = dataclasses.replace(contact, diameter=10e-6)
        assert smaller == contact.replace(diameter=10e-6)
        assert dataclasses.replace(contact, work_of_adhesion=0.1).work_of_adhesion == 0.1
        by_force = dataclasses.replace(smaller, ring_force=9.0)
        assert by_force == smaller.replace(ring_force=9.0)
        assert dataclasses.replace(by_force, diameter=1e-6).ring_force == 9.0
        assert dataclasses.replace(by_force, work_of_adhesion=0.5) == smaller
        with pytest.raises(ValueError, match="got both"):
            dataclasses.replace(contact, work_of_adhesion=0.1, ring_force=9.0)

    def test_it_checks_again(self, fields):
        with pytest.raises(ValueError, match=r"friction must be .* got -1"):
            Contact(**fields).replace(friction=-1)
        with pytest.raises(TypeError, match="nonsense"):
            Contact(**fields).replace(nonsense=1)


class TestArrays:
    def test_fields_broadcast(self, fields):
        contact = Contact(
            **fields | {"diameter": [[1e-6], [2e-6]], "work_of_adhesion": [0.1, 0.2, 0.3]}
        )
        assert contact.shape == (2, 3)
        assert contact.velocity_scale.shape == (2, 3)
        assert contact.mass.shape == (2, 1)

    def test_properties_of_materials_may_be_arrays(self, fields, steel):
        heavy = Material(
            name="x", youngs_modulus=193e9, poissons_ratio=0.28, density=[8000.0, 16000.0]
        )
        contact = Contact(**fields | {"particle": heavy})
        assert contact.shape == (2,)
        single = Contact(**fields)
        e = simulate(contact, 1.0).coefficient_of_restitution
        assert e[0] == simulate(single, 1.0).coefficient_of_restitution

    def test_a_contact_does_not_change_with_the_array_it_was_given(self, fields):
        diameter = np.array([1e-6, 2e-6])
        contact = Contact(**fields | {"diameter": diameter})
        diameter[:] = 1.0
        assert contact.diameter.tolist() == [1e-6, 2e-6]
        with pytest.raises(AttributeError):
            contact.diameter = 1.0


BAD = math.nan, -math.inf, -1.0
LENGTHS = ("diameter", "reference_velocity", "surface_radius")
OTHERS = (
    *("work_of_adhesion", "hertz_damping", "adhesion_damping", "friction"),
    "adhesion_rate_exponent",
)
NO_REFERENCE = "reference_velocity is needed"


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        *(
            ({name: value}, ValueError, f"^{name} must be finite and .*got {value:g}$")
            for name, values in (
                *((name, (*BAD, 0.0)) for name in LENGTHS),
                *((name, BAD) for name in OTHERS),
                *((name, (math.inf,)) for name in ("diameter", "work_of_adhesion", "friction")),
            )
            for value in values
        ),
        *(
            ({name: value}, TypeError, f"^{name} must be a real number")
            for name in ("diameter", "friction", "hertz_damping")
            for value in ("1", True, 1j, [1.0, None])
        ),
        ({"ring_force": 1.0}, ValueError, "either work_of_adhesion or ring_force, got both"),
        ({"work_of_adhesion": None}, ValueError, "work_of_adhesion or ring_force, got neither"),
        (
            {"work_of_adhesion": None, "ring_force": "1"},
            TypeError,
            "^ring_force must be a real number",
        ),
        ({"adhesion_rate_exponent": 0.5}, ValueError, NO_REFERENCE),
        ({"adhesion_rate_exponent": [0.0, 0.5]}, ValueError, NO_REFERENCE),
        ({"stiffness_model": "Hertz"}, ValueError, "stiffness_model must be one of .* got 'Hertz'"),
        ({"stiffness_model": 1}, TypeError, "stiffness_model must be one of .* got 1"),
        ({"particle": "steel"}, TypeError, "particle must be a Material, got 'steel'"),
        ({"surface": "steel"}, TypeError, "surface must be a Material, got 'steel'"),
        ({"damped_attachment": 1}, TypeError, "damped_attachment must be True or False, got 1"),
        ({"diameter": [1e-6] * 2, "friction": [0.1] * 3}, ValueError, r"diameter \(2,\).*friction"),
        ({"diameter": 10**400}, ValueError, "^diameter must be finite and > 0, got inf"),
        (
            {"surface_radius": [[1.0], [1.0, 2.0]]},
            TypeError,
            "^surface_radius must be a real number",
        ),
        *(
            (
                {name: value},
                ValueError,
                f"^{name} must be from .* to 1e\\+30 in SI units, got [^\\[]*$",
            )
            for name, value in (
                *(("diameter", 5e-324), ("partner_diameter", 1e308), ("surface_radius", 1e-320)),
                *(("work_of_adhesion", [0.1, 1e200]), ("friction", 1e31)),
            )
        ),
        (
            {"law": Hysteresis(unloading_work=1e200)},
            ValueError,
            r"^law\.unloading_work must be from",
        ),
    ],
)
def test_bad_input_is_named(fields, changes, error, message):
    with pytest.raises(error, match=message):
        Contact(**fields | changes)


@given(exponents=st.lists(st.floats(-30.0, 30.0), min_size=8, max_size=8))
def test_whatever_is_accepted_has_scales(exponents):
    """At all of the ends together no number leaves double precision."""
    numbers = 10.0 ** np.array(exponents)
    bodies = [
        Material(name="x", youngs_modulus=modulus, poissons_ratio=0.3, density=density)
        for modulus, density in (numbers[:2], numbers[2:4])
    ]
    names = ("diameter", "work_of_adhesion", "partner_diameter", "hertz_damping")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".* is not from", UserWarning)
        contact = Contact(
            particle=bodies[0], surface=bodies[1], **dict(zip(names, numbers[4:], strict=True))
        )
    scales = np.array([*contact.scales, contact.hertz_radius, contact.pull_off_force])
    assert np.all(np.isfinite(scales) & (scales > 0.0))


@pytest.mark.parametrize(
    ("name", "value", "error"),
    [
        ("zeta_hertz", -1.0, ValueError),
        ("zeta_adhesion", math.nan, ValueError),
        ("zeta_adhesion", "1", TypeError),
        ("zeta_hertz", None, TypeError),
        ("reference_velocity", 0.0, ValueError),
    ],
)
def test_bad_zeta_is_named(fields, name, value, error):
    zeta = {"zeta_hertz": 0.1, "zeta_adhesion": 1.0, "reference_velocity": 1.0} | {name: value}
    with pytest.raises(error, match=f"^{name} must be"):
        Contact.from_zeta(**zeta, **fields)
    with pytest.raises(ValueError, match=NO_REFERENCE):
        _ = Contact(**fields).damping_unit
