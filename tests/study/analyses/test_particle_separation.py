"""Separation force against silica, and the worked example of the documentation made of it."""

from __future__ import annotations

import math

import pytest
from tests.shared import ROOT

FORCES = ("adhesion", "uniform charge", "charged patches")
GUIDE = (ROOT / "docs/separation.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("particle_separation")


@pytest.fixture(scope="module")
def summary(tables):
    rows = tables["particle_separation"]
    return rows.assign(silica_percent=rows["silica_percent"].fillna(-1.0)).set_index(
        ["quantity", "silica_percent"]
    )


def test_bare_forces_by_hand(summary):
    # middles of the ranges: w = sqrt(0.01 0.1), and so on; R = 4 um
    work, charge, density = math.sqrt(0.01 * 0.1), math.sqrt(10 * 20) * 1e-3, math.sqrt(1100 * 1300)
    q = charge * density * 4 / 3 * math.pi * (4e-6) ** 3
    image = math.sqrt(1.0 * 1.9) * q**2 / (16 * math.pi * 8.8541878e-12 * (4e-6) ** 2)
    patches = math.sqrt(0.1 * 0.5) * q * math.sqrt(44e6 * 350e6) / 2
    expected = dict(zip(FORCES, (1.5 * math.pi * work * 4e-6, image, patches), strict=True))
    for name, force in expected.items():
        assert summary.loc[(name, 0.0), "middle"] == pytest.approx(force * 1e9, rel=1e-6)
    # the bands are those of the ends of the ranges
    low, high = summary.loc[("adhesion", 0.0), ["low", "high"]]
    assert (low, high) == pytest.approx((188.4956, 1884.956), rel=1e-6)
    low, high = summary.loc[("uniform charge", 0.0), ["low", "high"]]
    assert high / low == pytest.approx(4 * (13 / 11) ** 2 * 1.9, rel=1e-9)


def test_what_the_abstract_states_against_the_declared_ranges(summary):
    # adhesion far exceeds the force on a uniform charge, whatever the inputs
    uniform = summary.loc[("adhesion over uniform charge", 0.0)]
    assert uniform["low"] > 10
    assert (uniform["holds"], uniform["share"]) == ("yes", 1.0)
    # that on patches not for all
    patches = summary.loc[("adhesion over charged patches", 0.0)]
    assert patches["low"] < 1
    assert patches["high"] > 10
    # a full layer of silica leaves the stated share ...
    left = summary.loc[("adhesion over bare, full layer", -1.0)]
    assert left["middle"] == pytest.approx(0.05, rel=0.05)
    # ... which is reached a little above the stated weight
    at = summary.loc[("adhesion over bare", 2.0)]
    assert (at["bound_low"], at["bound_high"]) == pytest.approx((0.025, 0.1))
    assert at["low"] < 0.05 < at["middle"] < at["high"]
    # patches and adhesion meet there; the uniform charge is too weak at the usual charge of toner
    assert 1.9 < summary.loc[("silica where adhesion meets charged patches", -1.0), "middle"] < 2.3
    assert math.isnan(summary.loc[("silica where adhesion meets uniform charge", -1.0), "middle"])
    equal = summary.loc[("charge to mass for equality", 2.0)]
    assert equal["middle"] > 20 > equal["low"]
    assert equal["holds"] == "no"


def test_charge_for_equality(run_study, summary):
    wanted = summary.loc[("charge to mass for equality", 2.0), "middle"]
    table = run_study("particle_separation", charge_to_mass_uC_per_g=[wanted, wanted])
    rows = table["particle_separation"].query("silica_percent == 2.0").set_index("quantity")
    assert rows.loc["adhesion over uniform charge", "middle"] == pytest.approx(1.0, rel=1e-9)


def test_a_range_of_no_width_has_no_band(run_study):
    spans = {
        "work_of_adhesion_J_per_m2": [0.05, 0.05],
        "youngs_modulus_GPa": [3.0, 3.0],
        "particle_density_kg_per_m3": [1200, 1200],
        "surface_factor": [1.0, 1.0],
        "silica_diameter_nm": [16, 16],
    }
    rows = run_study("particle_separation", **spans)["particle_separation"]
    bare = rows.query("quantity == 'adhesion' and silica_percent == 0").iloc[0]
    assert bare["low"] == pytest.approx(bare["high"], rel=1e-12)
    assert bare["middle"] == pytest.approx(942.5, rel=1e-4)
    coated = rows.query("quantity == 'adhesion' and silica_percent == 2").iloc[0]
    assert coated["low"] < coated["high"]  # what is left is the placement


def test_the_guide_gives_the_numbers_of_the_table(summary):
    middles, shares = summary["middle"], summary["share"]
    assert f"factor {middles['adhesion over charged patches', 0.0]:.1f} at the middles" in GUIDE
    assert (
        f"tenfold in {shares['adhesion over charged patches', 0.0]:.0%}".replace("%", " %") in GUIDE
    )
    assert f"{middles['adhesion over bare', 2.0]:.0%}".replace("%", " % at the middles") in GUIDE
    left = middles["adhesion over bare, full layer", -1.0]
    assert f"A full layer leaves {100 * left:.1f} %" in GUIDE
    meets = middles["silica where adhesion meets charged patches", -1.0]
    assert f"adhesion and patches cross at {meets:.1f} %" in GUIDE
    weaker = middles["adhesion over uniform charge", 2.0]
    needed = middles["charge to mass for equality", 2.0]
    assert f"{weaker:.0f} times weaker than adhesion at 2 %" in GUIDE
    assert f"would have to be {needed:.0f} µC/g" in GUIDE
    together = shares["statements that hold, of four", -1.0]
    assert f"in {100 * together:.1f} % of combinations" in GUIDE
