"""The written reference of adhesive impacts, read again as another code would."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from click.testing import CliRunner

from microimpact.cli.reference import reference_command
from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Tables of impacts and of contacts, and the test of LAMMPS's suite."""
    done = CliRunner().invoke(reference_command, ["-o", str(tmp_path_factory.mktemp("reference"))])
    impacts, contacts, suite = done.stdout.split()
    test = yaml.safe_load(Path(suite).read_text(encoding="utf-8"))
    return pd.read_csv(impacts), pd.read_csv(contacts, index_col="case"), test


def rebuilt(row):
    """Contact of the numbers in a row."""
    glass = Material(
        name="glass",
        youngs_modulus=row["youngs_modulus_Pa"],
        poissons_ratio=row["poissons_ratio"],
        density=row["density_kg_per_m3"],
    )
    laws = {
        "jkr": lambda: JKR(viscous_time=row["viscous_time_s"]),
        "thornton-ning": lambda: ThorntonNing(yield_pressure=row["yield_pressure_Pa"]),
    }
    return Contact(
        particle=glass,
        surface=glass,
        diameter=row["diameter_m"],
        partner_diameter=row["partner_diameter_m"],
        work_of_adhesion=row["work_of_adhesion_J_per_m2"],
        hertz_damping=row["hertz_damping_s_per_m"],
        adhesion_damping=row["adhesion_damping_s_per_m"],
        friction=row["friction"],
        law=laws.get(row["law"], lambda: None)(),
    )


def test_the_contacts_have_the_impacts_beside_them(written):
    impacts, contacts, _ = written
    assert set(impacts["case"]) == set(contacts.index)
    for name, rows in impacts.groupby("case"):
        contact = rebuilt(contacts.loc[name])
        speed, along = (rows[f"{of}_speed_m_per_s"].to_numpy() for of in ("normal", "tangential"))
        after = planar(contact, -speed, along, tangential="mindlin" if along.any() else "rigid")
        for column, expected in {
            "restitution": after.coefficient_of_restitution,
            "contact_time_s": after.contact_time,
            "tangential_velocity_m_per_s": after.tangential_velocity,
            "spin_rad_per_s": after.spin,
        }.items():
            assert rows[column].to_numpy() == pytest.approx(expected, rel=1e-9), (name, column)
        limit = contacts.loc[name, "capture_velocity_m_per_s"]
        assert limit == pytest.approx(float(capture_velocity(contact)), rel=1e-9)


def test_energies_and_forces_are_those_of_the_numbers_beside_them(written):
    impacts, contacts, _ = written
    for _, row in impacts.iterrows():
        contact = contacts.loc[row["case"]]
        radius, paired = contact["diameter_m"] / 2, math.isfinite(contact["partner_diameter_m"])
        mass = contact["density_kg_per_m3"] * 4 / 3 * math.pi * radius**3 / (1 + paired)
        before = row["normal_speed_m_per_s"] ** 2 + row["tangential_speed_m_per_s"] ** 2
        after = (row["restitution"] * row["normal_speed_m_per_s"]) ** 2
        after += row["tangential_velocity_m_per_s"] ** 2
        after += 0.4 * (radius * row["spin_rad_per_s"]) ** 2
        expected = 0.5 * mass * (before - after)
        assert row["energy_loss_J"] == pytest.approx(expected, abs=1e-11 * mass * before)
        if contact["law"] in {"jkr", "thornton-ning"}:
            force = 1.5 * math.pi * contact["work_of_adhesion_J_per_m2"] * radius / (1 + paired)
            assert contact["pull_off_force_N"] == pytest.approx(force, rel=1e-12)


def test_the_case_for_lammps_is_the_impact_that_it_names(written):
    """Cohesion is half the work of adhesion, and each sphere has half the speed."""
    _, contacts, suite = written
    values = {name: float(value) for name, value in map(str.split, suite["variables"].splitlines())}
    assert "jkr ${emod} 0.0 ${poisson} ${coh} " in suite["pair_coeff"]
    row = contacts.loc["jkr-pair"]
    stated = {
        "youngs_modulus_Pa": values["emod"],
        "poissons_ratio": values["poisson"],
        "density_kg_per_m3": values["dens"],
        "diameter_m": values["diam"],
        "partner_diameter_m": values["diam"],
        "work_of_adhesion_J_per_m2": 2 * values["coh"],
    }
    assert stated == pytest.approx(dict(row[list(stated)]), rel=1e-12)
    impact = planar(rebuilt(pd.Series({**row, **stated})), -2 * values["vin"], 0.0)
    assert impact.coefficient_of_restitution == pytest.approx(values["en"], rel=1e-9)
    assert "set atom 1 vx ${vin}\nset atom 2 vx -${vin}\n" in suite["pre_commands"]
    # All of the contact lies within the run, which is no longer than need be.
    step = float(suite["pre_commands"].split("timestep ")[1])
    steps = np.sum(np.array(suite["run_segments"].split(), dtype=int))
    ahead = (values["sep"] - values["diam"] / 2) / values["vin"]
    assert 1.0 < step * steps / (ahead + impact.contact_time) < 3.0
