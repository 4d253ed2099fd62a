"""Contacts of LAMMPS, Lethe and YADE, and the coefficients fitted; a table for AcuSolve.

LAMMPS itself is asked in tests/peers.
"""

import math
import re

import numpy as np
import pytest

from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.laws import BROKEN, PULL_OFF, jkr_restitution
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.codes import fitted, jkr_coefficients, lethe, yade, yades_e
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


def lammps(contact):
    def code(time, work, speeds):
        changed = contact.by_law(JKR(viscous_time=time), work)
        return jkr_restitution(changed, speeds, end=PULL_OFF)

    return code


@pytest.mark.parametrize(("code", "damping"), [(lammps, 1e-8), (lethe, 0.1), (yade, 5e-9)])
def test_the_fit_keeps_the_capture_velocity(contact, code, damping):
    limit, peer = float(capture_velocity(contact)), code(contact)
    fit = fitted(contact, limit * np.array([1.5, 5.0, 15.0]), peer, 1e-3 * damping)
    around = peer(fit.damping, 2.0 * fit.surface_energy, limit * np.array([0.999, 1.001]))
    assert list(around > 0.0) == [False, True]
    assert 0.0 < fit.misfit < 0.1
    if code is not lammps:  # whose contact breaks early
        assert peer(0.0, 0.5, SPEEDS) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("loss", [0.0, 0.1, 1.0])
def test_without_adhesion_lethe_returns_the_restitution_put_in(contact, loss):
    assert lethe(contact)(loss, 0.0, SPEEDS) == pytest.approx(math.exp(-loss), abs=2e-5)


def test_without_adhesion_yade_has_the_restitution_of_its_approximant(contact):
    expected = [yades_e(contact, 5e-9, speed) for speed in SPEEDS]
    assert yade(contact)(5e-9, 0.0, SPEEDS) == pytest.approx(expected, abs=5e-6)


def test_the_wall_of_acusolve_is_right_between_its_rows(contact, tmp_path):
    table, text = export(contact, tmp_path, "acusolve", 20.0)
    speed, e = np.loadtxt(table).T
    misfit = float(re.search(r"right to (\S+)\.\n", text.read_text())[1])
    between = np.geomspace(0.5 * speed[1], 20.0, 2000)
    off = np.interp(between, speed, e) - normal_impact(contact, between).coefficient_of_restitution
    assert np.max(np.abs(off)) < 1.1 * misfit < 0.01


def test_speeds_are_asked_for_where_they_are_needed(contact, tmp_path):
    limit, bare = float(capture_velocity(contact)), contact.replace(work_of_adhesion=0.0)
    for body, form, speeds, message in (
        (contact, "lammps-jkr", [0.001, 1.0], rf"above the capture velocity {limit:.6g} m/s, got"),
        (contact, "c", [1.0], "speeds are of lammps-jkr, lethe, yade, got format 'c'"),
        (bare, "lammps-jkr", None, "speeds are needed where nothing is captured"),
        (contact.replace(diameter=[5e-6, 6e-6]), "yade", None, r"is of one contact, got \(2,\)"),
    ):
        with pytest.raises(ValueError, match=message):
            export(body, tmp_path, form, speeds=speeds)
    assert not list(tmp_path.iterdir())
    assert " 0.0 0.28 0 " not in export(bare, tmp_path, "lammps-jkr", speeds=2.0)[0].read_text()
