"""Studies and figures as the workflow runs them, in this process."""

from __future__ import annotations

from importlib import import_module

import pandas as pd
import pytest
from tests.shared import ROOT

import study
from study.declared.documents import load
from study.figures.registry import filled, registry
from study.judge.criteria import read_claims


@pytest.fixture(scope="session")
def claims(settings):
    return read_claims(ROOT / "config/claims.yaml", settings.branches["claim_numbers"])


@pytest.fixture(scope="session")
def run_study(made):
    """The function that runs a study with shipped parameters, or some of its own."""
    return study.run_study


@pytest.fixture(scope="session")
def calibration(made):
    """The calibrated cases and the family they are of, from which most studies start."""
    return {name: made("calibration")[name] for name in ("calibration", "calibration_family")}


@pytest.fixture(scope="session")
def admitted(calibration, settings):
    """The function that makes up drawn contacts: those of a study, with columns changed."""

    def made_up(study, changes):
        branch, table = settings.branches[study], calibration["calibration"]
        rows = table[(table["case"] == branch["case"]) & (table["role"] == "parameter")]
        numbers = dict(zip(rows["quantity"], rows["value"].astype(float), strict=True))
        row = {
            **branch["posterior"],
            "contact_law": "ring force",
            "particle": rows["particle"].iloc[0],
            "surface": rows["surface"].iloc[0],
            "friction_basis": "compressive",
            "friction": 0.15,
            "diameter_um": 75.0,  # Another than is drawn
            "work_of_adhesion_J_per_m2": numbers["work_of_adhesion"],
            "hertz_damping_s_per_m": numbers["hertz_damping"],
            "adhesion_damping_s_per_m": numbers["adhesion_damping"],
            "rate_exponent": numbers["adhesion_rate_exponent"],
            "reference_velocity_m_per_s": numbers.get("reference_velocity", 1.0),  # None with n = 0
        }
        return pd.DataFrame([row | change for change in changes])

    return made_up


@pytest.fixture(scope="session")
def figures(settings):
    return registry(filled(load(ROOT / "config/figures.yaml"), settings.branches, settings.pairs))


@pytest.fixture(scope="session")
def draw(figures):
    """Return a function that draws a figure; saving and reading it are tested elsewhere."""

    def drawn(name, tables):
        spec = figures[name]
        function = getattr(import_module(spec.module), spec.function)
        return function({key: tables[key] for key in spec.data}, spec)

    return drawn
