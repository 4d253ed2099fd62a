"""Coefficients of LAMMPS's contact jkr, and its input file read again.

LAMMPS itself is asked in tests/peers.
"""

import re

import numpy as np
import pytest

from microimpact.core.materials import Material
from microimpact.model.closed_forms import contact_modulus
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.force_laws import BROKEN, PULL_OFF, jkr_restitution
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.codes import jkr_coefficients
from microimpact.model.law.export import export

SPEEDS = np.array([0.1, 1.0, 10.0])


def test_a_jkr_contact_is_fitted_by_its_own_coefficients(contact):
    fit = jkr_coefficients(contact.by_law(JKR(viscous_time=3e-9), 0.5), SPEEDS / 10 + 0.1, BROKEN)
    assert fit.surface_energy == pytest.approx(0.25, rel=1e-6)
    assert fit.damping == pytest.approx(3e-9, rel=1e-5)
    assert fit.misfit < 1e-7


def test_the_early_break_is_made_good_by_the_surface_energy(contact):
    """Without damping the loss goes as w^(5/3), and the early break takes 0.49387 of it."""
    closed = 3.6 * 4 ** (4 / 3)  # energy at touch, at the greatest pull and at the break: theory
    share = (closed - 2.4 * 3 ** (4 / 3)) / (closed + 2.4)
    fit = jkr_coefficients(contact.by_law(JKR(), 0.5), np.array([0.1, 0.3, 1.0]), PULL_OFF)
    assert fit.surface_energy == pytest.approx(0.25 * share ** (-3 / 5), rel=1e-6)
    assert fit.misfit < 1e-6


def test_the_input_of_lammps_is_the_contact(contact, tmp_path):
    """Every number of the file, and the restitution and capture of a contact made of them."""
    limit = float(capture_velocity(contact))
    speeds = limit * np.array([1.5, 5.0, 15.0])
    text, table = (
        path.read_text() for path in export(contact, tmp_path, "lammps-jkr", speeds=speeds)
    )
    numbers = {
        name: np.array(re.findall(pattern.replace("@", r"(-?\d[-+.\de]*)"), text)[0], dtype=float)
        for name, pattern in {
            "limit": r"capture velocity\n# @ m/s",
            "misfit": r"m/s to @ at most",
            "whole": r"needs gamma @ and eta @\.",
            "start": r"single 0 0 @",
            "sphere": r"diameter @ density @",
            "elastic": r"granular jkr @ @ @ @ &\n",
            "friction": r"mindlin NULL 0\.0 @",
            "run": r"timestep *@(?:.|\n)*\nrun *@\n",
            "speed": r"speed index @",
        }.items()
    }
    modulus, damping, ratio, energy = numbers["elastic"]
    diameter, density = numbers["sphere"]
    body = Material(name="body", youngs_modulus=modulus, poissons_ratio=ratio, density=density)
    sphere = contact.replace(particle=body, surface=body, diameter=diameter)
    assert sphere.mass == pytest.approx(contact.mass, rel=1e-12)
    assert contact_modulus(sphere) == pytest.approx(float(contact_modulus(contact)), rel=1e-9)
    assert ratio == contact.particle.poissons_ratio
    assert numbers["friction"] == contact.friction
    assert numbers["limit"] == pytest.approx(limit, rel=1e-5)

    def rebounds(energy, damping, speed, end):
        time = damping * sphere.mass / (2.0 * contact_modulus(sphere))
        return jkr_restitution(sphere.by_law(JKR(viscous_time=time), 2.0 * energy), speed, end=end)

    speed, e, fitted = np.loadtxt(table.splitlines()[1:], delimiter=",").T
    assert speed == pytest.approx(speeds)
    assert e == pytest.approx(normal_impact(contact, speed).coefficient_of_restitution, rel=1e-12)
    assert fitted == pytest.approx(rebounds(energy, damping, speed, PULL_OFF), rel=1e-6)
    assert np.max(np.abs(fitted - e)) == pytest.approx(numbers["misfit"], abs=5e-4)
    around = limit * np.array([0.999, 1.001])
    for case in ((energy, damping, around, PULL_OFF), (*numbers["whole"], around, BROKEN)):
        assert list(rebounds(*case) > 0.0) == [False, True]
    # The shortest contact is resolved, and the slowest sphere has long left when the run ends.
    step, steps = numbers["run"]
    assert numbers["speed"] == speeds.max()
    times = normal_impact(contact, speeds).contact_time
    assert step == pytest.approx(times.min() / 500, rel=1e-3)
    flight = (numbers["start"] - contact.radius) * (1.0 + 1.0 / fitted.min()) / speeds.min()
    assert step * steps > 10.0 * (times.max() + flight)


def test_speeds_are_asked_for_where_they_are_needed(contact, tmp_path):
    limit, bare = float(capture_velocity(contact)), contact.replace(work_of_adhesion=0.0)
    for body, form, speeds, message in (
        (contact, "lammps-jkr", [0.001, 1.0], rf"above the capture velocity {limit:.6g} m/s, got"),
        (contact, "c", [1.0], "speeds are of format 'lammps-jkr', got 'c'"),
        (bare, "lammps-jkr", None, "speeds are needed where nothing is captured"),
        (
            contact.replace(diameter=[5e-6, 6e-6]),
            "lammps-jkr",
            None,
            r"is of one contact, got \(2,\)",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            export(body, tmp_path, form, speeds=speeds)
    assert not list(tmp_path.iterdir())
    assert " 0.0 0.28 0 " not in export(bare, tmp_path, "lammps-jkr", speeds=2.0)[0].read_text()
