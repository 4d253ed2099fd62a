"""Contacts of Lethe and YADE by their force, and the coefficients fitted; tables for AcuSolve."""

import math
import re

import numpy as np
import pytest

from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.codes import lethe, yade, yades_e
from microimpact.model.law.export import export
from microimpact.model.law.jkr import fitted

SPEEDS = np.array([0.1, 1.0, 10.0])


@pytest.mark.parametrize("loss", [0.0, 0.1, 1.0])
def test_without_adhesion_lethe_returns_the_restitution_put_in(contact, loss):
    assert lethe(contact)(loss, 0.0, SPEEDS) == pytest.approx(math.exp(-loss), abs=2e-5)


def test_without_adhesion_yade_has_the_restitution_of_its_approximant(contact):
    expected = [yades_e(contact, 5e-9, speed) for speed in SPEEDS]
    assert yade(contact)(5e-9, 0.0, SPEEDS) == pytest.approx(expected, abs=5e-6)


@pytest.mark.parametrize(("code", "damping"), [(lethe, 0.1), (yade, 5e-9)])
def test_adhesion_alone_loses_nothing_and_the_fit_keeps_the_capture_velocity(
    contact, code, damping
):
    assert code(contact)(0.0, 0.5, SPEEDS) == pytest.approx(1.0, abs=1e-6)
    limit = float(capture_velocity(contact))
    fit = fitted(contact, limit * np.array([1.5, 5.0, 15.0]), code(contact), 1e-3 * damping)
    around = code(contact)(fit.damping, 2.0 * fit.surface_energy, limit * np.array([0.999, 1.001]))
    assert list(around > 0.0) == [False, True]
    assert 0.0 < fit.misfit < 0.05


def test_the_wall_of_acusolve_is_right_between_its_rows(contact, tmp_path):
    table, text = export(contact, tmp_path, "acusolve", 20.0)
    speed, e = np.loadtxt(table).T
    misfit = float(re.search(r"right to (\S+)\.\n", text.read_text())[1])
    between = np.geomspace(0.5 * speed[1], 20.0, 2000)
    off = np.interp(between, speed, e) - normal_impact(contact, between).coefficient_of_restitution
    assert np.max(np.abs(off)) < 1.1 * misfit < 0.01
