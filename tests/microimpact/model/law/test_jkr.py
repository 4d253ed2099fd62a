"""Coefficients of LAMMPS's contact jkr, by its law; LAMMPS itself is asked in tests/peers."""

import numpy as np
import pytest

from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.laws import BROKEN, PULL_OFF, jkr_restitution
from microimpact.model.law.export import export
from microimpact.model.law.jkr import jkr_coefficients

SPEEDS = np.array([0.1, 0.3, 1.0])


@pytest.fixture
def viscous(contact):
    return contact.by_law(JKR(viscous_time=3e-9), 0.5)


def test_a_jkr_contact_is_fitted_by_its_own_coefficients(viscous):
    fit = jkr_coefficients(viscous, SPEEDS, BROKEN)
    assert fit.surface_energy == pytest.approx(0.25, rel=1e-6)
    assert fit.damping == pytest.approx(3e-9, rel=1e-5)
    assert fit.misfit < 1e-7


def test_the_early_break_is_made_good_by_the_surface_energy(contact):
    """Without damping the loss goes as w^(5/3), and the early break takes 0.49387 of it."""
    closed = 3.6 * 4 ** (4 / 3)  # energy at touch, at the greatest pull and at the break: theory
    share = (closed - 2.4 * 3 ** (4 / 3)) / (closed + 2.4)
    plain = contact.by_law(JKR(), 0.5)
    fit = jkr_coefficients(plain, SPEEDS, PULL_OFF)
    assert fit.surface_energy == pytest.approx(0.25 * share ** (-3 / 5), rel=1e-6)
    assert fit.misfit < 1e-6


def test_the_capture_velocity_is_kept_and_the_misfit_stated(contact):
    limit = float(capture_velocity(contact))
    fit = jkr_coefficients(contact, limit * np.array([1.5, 5.0, 15.0]))
    again = contact.by_law(JKR(viscous_time=fit.damping), 2.0 * fit.surface_energy)
    around = limit * np.array([0.999, 1.001])
    assert list(jkr_restitution(again, around, end=PULL_OFF) > 0.0) == [False, True]
    assert 0.0 < fit.misfit < 0.1


def test_speeds_are_asked_for_where_they_are_needed(contact, tmp_path):
    limit = float(capture_velocity(contact))
    with pytest.raises(ValueError, match=rf"above the capture velocity {limit:.6g} m/s, got 0.001"):
        export(contact, tmp_path, "lammps-jkr", speeds=[0.001, 1.0])
    with pytest.raises(ValueError, match="speeds are of lammps-jkr, lethe, yade, got format 'c'"):
        export(contact, tmp_path, "c", speeds=[1.0])
    bare = contact.replace(work_of_adhesion=0.0)
    with pytest.raises(ValueError, match="speeds are needed where nothing is captured"):
        export(bare, tmp_path, "lammps-jkr")
    sizes = contact.replace(diameter=[5e-6, 6e-6])
    with pytest.raises(ValueError, match=r"format 'lammps-jkr' is of one contact, got \(2,\)"):
        export(sizes, tmp_path, "lammps-jkr")
    assert not list(tmp_path.iterdir())
    assert " 0.0 0.28 0 " not in export(bare, tmp_path, "lammps-jkr", speeds=2.0)[0].read_text()
