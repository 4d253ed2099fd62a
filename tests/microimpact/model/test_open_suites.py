"""Single impacts of open test suites: the table of docs/performance.md, row by row.

Inputs and outcomes of LAMMPS are those of its granular test suite as of July 2026; most of them
are cases of Chung and Ooi 2011.
"""

from __future__ import annotations

import math
import re

import pytest
from tests.shared import ROOT

from microimpact.core.materials import Material
from microimpact.model.calibration import hertz_damping_for
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.impact import planar
from microimpact.model.dynamics.normal import normal_impact


def contact(modulus, ratio, density, diameter, **fields):
    bodies = [
        Material(name="body", youngs_modulus=modulus, poissons_ratio=ratio, density=value)
        for value in (density, fields.pop("second_density", density))
    ]
    fields = {"work_of_adhesion": 0.0} | fields
    return Contact(particle=bodies[0], surface=bodies[1], diameter=diameter, **fields)


def aluminium(diameter, friction, speed, restitution, **fields):
    """The alloy of Chung and Ooi, with the damping that has its restitution at a speed."""
    undamped = contact(7e10, 0.33, 2700.0, diameter, friction=friction, **fields)
    return hertz_damping_for(undamped, speed, restitution)


def overlaps():
    glass = contact(4.8e10, 0.2, 2800.0, 0.02, partner_diameter=0.02)
    iron = contact(1e11, 0.25, 7000.0, 0.005)
    for body, speed, measured in (
        (glass, 20.0, 2 * (0.01 - 9.8629436218504573e-03)),
        (iron, 3.9, 0.0025 - 2.4773193534324612e-03),
    ):
        yield normal_impact(body, speed).maximum_compression * 1e6, measured * 1e6


def restitution():
    impact = planar(aluminium(0.005, 0.4, 2.0, 0.5), -2.0, 0.0)
    yield impact.normal_velocity, 9.9974392334184659e-01


def oblique():
    body = aluminium(0.005, 0.092, 2.9876, 0.98)
    for along, velocity, spin in (
        (15.237, 14.692749447044884, 544.25055295515733),
        (2.29, 1.7457443950640865, 544.25560493591468),
        (0.5, 0.34437890244522057, 155.62109755477954),
    ):
        impact = planar(body, -2.9876, along, tangential="spring")
        yield impact.tangential_velocity, velocity
        yield impact.spin, spin


def spinning():
    wall = planar(aluminium(0.2, 0.4, 0.2, 0.5), -0.2, 0.0, 22.86, tangential="spring")
    yield wall.tangential_velocity, 0.12089194099215592
    yield wall.spin, 19.837701475196010
    twins = aluminium(0.005, 0.4, 0.4, 0.5, partner_diameter=0.005)
    pair = planar(twins, -0.4, 0.0, 22.86, tangential="spring", partner_spin=-22.86)
    yield pair.spin, 22.86
    yield pair.partner_spin, -22.86
    heavy = {"partner_diameter": 1.0, "second_density": 2.7e6}
    unequal = planar(aluminium(0.2, 0.4, 0.2, 0.5, **heavy), -0.2, 0.0, 22.86, tangential="spring")
    yield unequal.spin, 19.838426252892553
    yield unequal.partner_spin * 1e6, -4.8353529322051940


def touch():
    pair = contact(4.8e10, 0.2, 2800.0, 0.02, partner_diameter=0.02).by_law(JKR(), 0.2)
    yield pair.pull_off_force * 8 / 9 * 1e3, 8 / 3 * math.pi * 0.1 * 0.005 * 1e3


def test_the_page_has_what_is_computed():
    page = (ROOT / "docs/performance.md").read_text(encoding="utf-8")
    number = r"(-?\d[\de.-]*)"
    printed = re.findall(rf"(?m)\| {number} \| {number} \| {number} % \|$", page)
    computed = [*overlaps(), *restitution(), *oblique(), *spinning(), *touch()]
    assert len(printed) == len(computed)
    for row, (ours, theirs) in zip(printed, computed, strict=True):
        off = 100 * (float(ours) / theirs - 1)
        assert row == (
            f"{theirs:.6g}",
            f"{float(ours):.6g}",
            f"{off if abs(off) > 5e-6 else 0:.2g}",
        )


def test_sliding_and_spinning_impacts_are_their_closed_forms():
    """Gross sliding: the impulse of friction is f (1 + e) v, whatever the contact's law."""
    impulse = 0.092 * 1.98 * 2.9876
    fast, _, slow, *_ = [ours for ours, _ in oblique()]
    assert fast == pytest.approx(15.237 - impulse, rel=1e-12)
    assert slow == pytest.approx(2.29 - impulse, rel=1e-12)
    assert next(iter(spinning()))[0] == pytest.approx(0.4 * 1.5 * 0.2, rel=1e-12)
