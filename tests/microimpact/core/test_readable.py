"""Records print as tables with units; numbers that are hardly meant warn whoever gives them."""

from __future__ import annotations

import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest

from microimpact import Contact, Material, materials, simulate, tabulate, trajectory
from microimpact.core.extras import optional
from microimpact.core.readable import precise
from microimpact.model.contact_laws import JKR

GLASS = {"youngs_modulus": 70e9, "poissons_ratio": 0.2, "density": 2500.0}
BODIES = {"particle": materials["glass"], "surface": materials["silicon"]}
CONTACT = Contact(**BODIES, diameter=3e-5, work_of_adhesion=0.1, hertz_damping=0.05)


def rows(record):
    return [line.split() for line in str(record).splitlines()]


def test_a_record_prints_plain_numbers_with_units():
    impact = simulate(CONTACT, 2.0, 45.0)
    assert ["contact_time", f"{impact.contact_time:.6g}", "s"] in rows(impact)
    assert ["captured", "no"] in rows(impact)
    assert ["diameter", "3e-05", "m"] in rows(CONTACT)
    assert ["particle.density", f"{materials['glass'].density:.6g}", "kg/m3"] in rows(CONTACT)
    assert not any("np." in text(x) for x in (impact, CONTACT) for text in (str, repr))
    assert eval(repr(CONTACT), {"Contact": Contact, "Material": Material}) == CONTACT
    assert impact._repr_html_() == f"<pre>{impact}</pre>"


def test_another_law_of_the_force_is_named():
    assert ["law", "jkr"] in rows(CONTACT.by_law(JKR(), 0.1))
    lossy = rows(CONTACT.by_law(JKR(viscous_time=1e-9), 0.1))
    assert lossy[-3:-1] == [["law", "jkr"], ["law.viscous_time", "1e-09", "s"]]


@pytest.mark.parametrize(
    ("value", "width", "text"),
    [
        (0.2000123, 3e-6, "0.2000123"),
        (0.2, 0.1, "0.2"),
        (1.23456, np.inf, "1.235"),
        (0.0, 1.0, "0"),
    ],
)
def test_digits_follow_the_width_of_an_interval(value, width, text):
    assert precise(value, width) == text


def test_arrays_print_their_ends():
    impacts = simulate(CONTACT, np.array([1e-4, 1.0, 2.0, 3.0]))
    text = str(impacts)
    e = impacts.coefficient_of_restitution
    assert f"{e.min():.6g} to {e.max():.6g} (4)" in text
    assert "yes in 1 of 4" in text
    assert len(repr(tabulate(CONTACT, 0.1, 1.0))) < 600


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: Material(name="a", **GLASS | {"youngs_modulus": 70}), "a: youngs_modulus = 70 Pa"),
        (lambda: CONTACT.replace(diameter=[3e-5, 30.0]), "diameter = 30 m is not from"),
        (lambda: CONTACT.replace(work_of_adhesion=250), "in mJ/m2?"),
        (lambda: Contact(**BODIES, diameter=1e-5, work_of_adhesion=0.1, friction=15), "in %?"),
        (lambda: simulate(CONTACT, 1.0, np.radians([30.0, 80.0])), "in radians?"),
    ],
)
def test_a_slip_of_the_unit_warns_once(build, words):
    with pytest.warns(UserWarning, match=r"is not from") as caught:
        build()
    (warning,) = caught
    assert words in str(warning.message)
    assert warning.filename == __file__


def test_copies_do_not_warn_again():
    with pytest.warns(UserWarning, match="friction"):
        doubtful = CONTACT.replace(friction=15.0)
    doubtful.replace(diameter=[1e-5, 2e-5]).at(1)
    simulate(doubtful, np.full(3, 1.0), [1.0, 45.0, 90.0])


def test_a_path_draws_itself_or_says_what_is_missing(monkeypatch):
    path = trajectory(CONTACT, 1.0)
    plt.switch_backend("Agg")
    (line,) = path.plot().axes[0].lines
    np.testing.assert_allclose(line.get_ydata(), 1e9 * path.compression)
    plt.close("all")
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(ModuleNotFoundError, match=r"needs emcee: pip install '.\[calibrate\]'"):
        optional("emcee")


def test_a_material_that_is_not_declared_names_the_nearest():
    with pytest.raises(KeyError, match="did you mean 'silicon'"):
        materials["silcon"]
