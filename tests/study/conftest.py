"""Studies and figures as the workflow runs them, in this process."""

from __future__ import annotations

import pandas as pd
import pytest

import study
from study.figures.declaration import all_figures
from study.figures.style import Sheet, context
from study.judge.criteria import declared_claims


@pytest.fixture(scope="session")
def claims(settings):
    return declared_claims(settings.branches["claim_numbers"])


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
    """All figures with their words filled in."""
    return {
        name: figure.filled(settings.branches[figure.analysis], settings.pairs)
        for name, figure in all_figures().items()
    }


@pytest.fixture(scope="session")
def draw(figures, settings):
    """Return a function that draws a figure; saving and reading it are tested elsewhere."""

    def drawn(name, tables):
        figure = figures[name]
        branch = settings.branches[figure.analysis]
        with context():
            sheet = Sheet(figure, {k: tables[k] for k in figure.data}, branch, settings.pairs)
            figure.draw(sheet)
        return sheet.figure

    return drawn
