"""Competing laws of the capture velocity, against printed values and over diameter."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from microimpact import Contact, Material, capture_velocity, simulate
from microimpact.model.closed_forms import sticking_restitution, yield_velocity
from study.tables import NOT_COMPUTED

LAWS = ["model", "jkr", "brach_dunn_1992", "dahneke_1971"]
MOLYBDENUM = "fluorescein-molybdenum, nominal"
MICA = "ammonium-fluorescein-mica"
LATEX = "polystyrene-latex-fused-silica"
CONSTANT, INVERSE = "steel-silicon, n = 0", "steel-silicon, n = 1"

# Printed capture velocities (Figs. 15 and 16) and the diameters they are taken to hold for.
PRINTED = {
    CONSTANT: (62.0, 0.18),
    INVERSE: (62.0, 0.18),
    MOLYBDENUM: (4.9, 1.47),
    MICA: (4.9, 1.10),
    LATEX: (1.27, 0.967),
}


@pytest.fixture(scope="module")
def study(run_study, calibration):
    def run(**changes):
        return run_study("capture_velocities", calibration, **changes)

    return run


@pytest.fixture(scope="module")
def tables(study):
    return study()


@pytest.fixture(scope="module")
def table(tables):
    return tables["capture_laws"].set_index(["pair", "law"])


@pytest.fixture(scope="module")
def works(calibration):
    table = calibration["calibration"]
    rows = table[table["quantity"] == "work_of_adhesion"]
    return rows.set_index("case")["value"]


@pytest.mark.parametrize(
    ("name", "table", "key"),
    [
        ("capture_velocities", "capture_laws", "pair"),
        ("fig15_16_restitution_fits", "restitution_fits", "case"),
    ],
)
def test_a_case_without_solution_costs_its_rows_alone(run_study, calibration, name, table, key):
    cases = calibration["calibration"]
    unsolved = pd.DataFrame([{"case": LATEX, "role": NOT_COMPUTED, "problem": "no solution"}])
    without = pd.concat([cases[cases["case"] != LATEX], unsolved])
    rows = run_study(name, {**calibration, "calibration": without})[table].set_index(key)
    assert rows.loc[LATEX, "problem"] == "no solution"
    assert rows.drop(LATEX)["problem"].isna().all()


# Moduli (Pa) and ratios of both bodies, and the density of the particle (kg/m3), as declared.
BODIES = {
    CONSTANT: ((193e9, 0.28), (169e9, 0.25), 8000.0),
    MOLYBDENUM: ((1.2e9, 0.3), (325e9, 0.31), 1350.0),
    LATEX: ((3.2e9, 0.34), (72.5e9, 0.17), 1050.0),
}


def curve(tables, pair, law):
    rows = tables["capture_law_curves"].query("panel == @pair and series == @law")
    return rows["x_um"].to_numpy(), rows["y_m_per_s"].to_numpy()


def steel_on_silicon(**changes):
    """Return the declared materials of config/materials.csv, written out."""
    steel = Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.28, density=8000.0)
    silicon = Material(name="silicon", youngs_modulus=169e9, poissons_ratio=0.25, density=2330.0)
    fields = {"diameter": 62e-6, "work_of_adhesion": 0.7} | changes
    return Contact(particle=steel, surface=silicon, **fields)


def test_every_pair_meets_every_law_and_its_printed_value(table):
    assert set(table.index) == {
        *((pair, law) for pair in PRINTED for law in LAWS),
        *((pair, "thornton_ning_yield") for pair in (CONSTANT, INVERSE)),
    }
    for (pair, _), row in table.iterrows():
        assert (row["diameter_um"], row["printed_m_per_s"]) == pytest.approx(PRINTED[pair])
        ratio = row["capture_velocity_m_per_s"] / PRINTED[pair][1]
        assert row["ratio_to_printed"] == pytest.approx(ratio)


def test_brach_dunn_by_hand(table):
    # k_i = (1 - nu^2)/(pi E); Ebar = 0.51 (5 pi^2 (k_1 + k_2)/(4 rho^1.5))^0.4
    for pair, (*elastic, density) in BODIES.items():
        compliance = sum((1 - nu**2) / (math.pi * modulus) for modulus, nu in elastic)
        effective = 0.51 * (5 * math.pi**2 * compliance / (4 * density**1.5)) ** (2 / 5)
        expected = (2 * effective / (PRINTED[pair][0] * 1e-6)) ** (10 / 7)
        found = table.loc[(pair, "brach_dunn_1992"), "capture_velocity_m_per_s"]
        assert found == pytest.approx(expected, rel=1e-12)
    # the same, worked out once on paper
    found = table.loc[(CONSTANT, "brach_dunn_1992"), "capture_velocity_m_per_s"]
    assert found == pytest.approx(5.49e-4, rel=2e-3)


def test_jkr_by_hand(table, works):
    # the form for a sphere on a plane: 1.84 ((w/R)^5 / (rho^3 E*^2))^(1/6)
    for pair, (*elastic, density) in BODIES.items():
        modulus = 1 / sum((1 - nu**2) / e for e, nu in elastic)
        radius = PRINTED[pair][0] * 1e-6 / 2
        expected = 1.84 * ((works[pair] / radius) ** 5 / (density**3 * modulus**2)) ** (1 / 6)
        found = table.loc[(pair, "jkr"), "capture_velocity_m_per_s"]
        assert found == pytest.approx(expected, rel=1e-3)  # 1.84 has three digits


def test_dahneke_by_hand(table, works, calibration):
    # R^2 m v^2/2 = (1 - R^2) E at capture, with the well of Hertz and ring force for E
    for pair, (*elastic, density) in BODIES.items():
        radius = PRINTED[pair][0] * 1e-6 / 2
        stiffness = 4 / 3 / sum((1 - nu**2) / e for e, nu in elastic)
        force = (9 * stiffness * radius * works[pair] ** 2 / (2 * math.pi)) ** (1 / 3)
        depth = 2 * math.pi * force / stiffness
        energy = 4 / 15 * math.sqrt(radius) * stiffness * depth**2.5
        row = table.loc[(pair, "dahneke_1971")]
        # R far above capture, of the calibrated contact written out
        bodies = [
            Material(name=name, youngs_modulus=modulus, poissons_ratio=nu, density=density)
            for name, (modulus, nu) in zip(("sphere", "plane"), elastic, strict=True)
        ]
        rows = calibration["calibration"].query("case == @pair and role == 'parameter'")
        fields = dict(zip(rows["quantity"], rows["value"].astype(float), strict=True))
        contact = Contact(particle=bodies[0], surface=bodies[1], **fields)
        speed = 10.0 * float(capture_velocity(contact))
        plateau = float(simulate(contact, speed).coefficient_of_restitution)
        mass = 4 / 3 * math.pi * radius**3 * density
        expected = math.sqrt(2 * energy / mass * (1 - plateau**2) / plateau**2)
        assert row["capture_velocity_m_per_s"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("law", "exponent"),
    [
        ("jkr", -5 / 6),
        ("brach_dunn_1992", -10 / 7),
        ("dahneke_1971", -5 / 6),
        ("thornton_ning_yield", 0.0),
    ],
)
def test_exponents_of_the_closed_forms(table, tables, law, exponent):
    rows = table.xs(law, level="law")
    assert rows["exponent"].to_numpy() == pytest.approx(exponent, abs=1e-9)
    for pair in rows.index:
        slope = np.polyfit(*np.log(curve(tables, pair, law)), 1)[0]
        assert slope == pytest.approx(exponent, abs=1e-9)


def test_exponent_of_the_model(table, tables):
    exponents = table.xs("model", level="law")["exponent"]
    # constant damping: -5/4 for little damping (v_c ~ V^(3/2)), steeper the more there is
    assert exponents[[MOLYBDENUM, MICA, LATEX, CONSTANT]].between(-1.5, -1.25).all()
    assert exponents[CONSTANT] < exponents[MOLYBDENUM]
    # damping inverse to the speed takes a fixed fraction: nearly the -5/6 of the velocity scale
    assert exponents[INVERSE] == pytest.approx(-5 / 6, abs=0.05)
    diameter, velocity = curve(tables, LATEX, "model")
    slope = np.diff(np.log(velocity)) / np.diff(np.log(diameter))
    assert slope[-1] == pytest.approx(-1.25, abs=0.02)
    assert (np.diff(slope) > 0).all()
    # and the table's is the slope of the curve at the pair's diameter
    at = np.interp(1.27, np.sqrt(diameter[1:] * diameter[:-1]), slope)
    assert exponents[LATEX] == pytest.approx(at, abs=1e-3)


def test_sticking_restitution():
    assert sticking_restitution(np.array([0.5, 1.0, 2.0]), 1.0) == pytest.approx(
        [0.0, 0.0, math.sqrt(0.75)]
    )
    assert sticking_restitution(1e6, 1.0, 0.7) == pytest.approx(0.7)


def test_onset_of_yield_by_hand(table):
    # 1.56 (p_y^5 / (E*^4 rho))^(1/2), p_y = 1.6 times 205 MPa
    modulus = 1 / ((1 - 0.28**2) / 193e9 + (1 - 0.25**2) / 169e9)
    expected = 1.56 * math.sqrt((1.6 * 205e6) ** 5 / (modulus**4 * 8000.0))
    found = table.loc[(CONSTANT, "thornton_ning_yield"), "capture_velocity_m_per_s"]
    assert found == pytest.approx(expected, rel=1e-3)  # 1.56 has three digits
    # the pressure at the centre of the elastic contact of that speed is p_y
    contact = steel_on_silicon()
    compression = (15 * contact.mass * found**2 / (16 * math.sqrt(31e-6) * modulus)) ** 0.4
    pressure = 2 * modulus / math.pi * math.sqrt(compression / 31e-6)
    assert pressure == pytest.approx(1.6 * 205e6, rel=1e-9)
    assert yield_velocity(contact, 2 * 205e6) == pytest.approx(found * 2**2.5, rel=1e-12)
