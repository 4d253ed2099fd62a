"""The page of the explorer and the scripts beside it, from the tables of its study."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from microimpact.model.dynamics.normal import HOPELESS_ADHESION_GROUP, HOPELESS_HERTZ_GROUP
from microimpact.model.rigid_body.algebra import INERTIA
from microimpact.report.explorer import FILES, SCRIPTS
from microimpact.report.site.pages import render
from microimpact.studies.models.explorer_tables.coordinates import (
    IMPULSE_EXPONENT,
    SLOW_PASSAGE,
    THRESHOLD_EXPONENT,
)

HERE = Path(__file__).parent

# Single precision is ten times finer than the interpolation, but e near the threshold goes with
# the square root of an error of the threshold.
TABLES = {
    "threshold": ("double", 2),
    "restitution": ("single", 3),
    "impulses": ("single", 3),
}
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
FORMATS = {"double": "<f8", "single": "<f4"}


def page_files(tables: Mapping[str, pd.DataFrame], largest_damping: float) -> dict[str, str]:
    """Return the page and its scripts by their place in the report.

    Parameters
    ----------
    tables
        The tables of the study `explorer_tables`, by name.
    largest_damping
        End of the tables' axis of damping.
    """
    accuracy = tables["explorer_accuracy"]
    page = render(
        "explorer.html",
        templates=HERE / "templates",
        here="explorer",
        wide=True,
        numbers=numbers(tables, largest_damping),
        accuracy=accuracy.to_dict("records"),
        restitution_error=_restitution_error(accuracy),
        largest_damping=largest_damping,
        scripts=SCRIPTS,
        power=power_of_ten,
    )
    files = {"explorer.html": page}
    return files | {
        f"explorer/{name}": (HERE / "assets" / name).read_text(encoding="utf-8") for name in FILES
    }


def numbers(tables: Mapping[str, pd.DataFrame], largest_damping: float) -> dict[str, Any]:
    """Return what the page's scripts compute from, ready for JSON.

    Values are packed as little-endian numbers in base64: text would take three times the room.
    """
    return {
        "constants": {
            "largest_damping": largest_damping,
            "threshold_exponent": THRESHOLD_EXPONENT,
            "impulse_exponent": IMPULSE_EXPONENT,
            "slow_passage": SLOW_PASSAGE,
            "inertia": INERTIA,
            "hopeless_hertz_group": HOPELESS_HERTZ_GROUP,
            "hopeless_adhesion_group": HOPELESS_ADHESION_GROUP,
        },
        "tables": {
            name: _packed(tables[f"explorer_{name}"], precision, axes)
            for name, (precision, axes) in TABLES.items()
        },
        "materials": tables["explorer_materials"].to_dict("records"),
        "contacts": [
            {key: None if pd.isna(value) else value for key, value in row.items()}
            for row in tables["explorer_contacts"].to_dict("records")
        ],
    }


def power_of_ten(value: float) -> str:
    """Return a number as readers write it, with two digits: 1.1×10⁻⁶."""
    mantissa, power = f"{value:.1e}".split("e")
    return f"{mantissa}×10{str(int(power)).translate(RAISED)}"


def _packed(table: pd.DataFrame, precision: str, axes: int) -> dict[str, Any]:
    form = FORMATS[precision]
    return {
        "precision": precision,
        "axes": [np.unique(table.iloc[:, i].to_numpy()).tolist() for i in range(axes)],
        "columns": {
            str(name): base64.b64encode(column.to_numpy(dtype=form).tobytes()).decode("ascii")
            for name, column in table.iloc[:, axes:].items()
        },
    }


def _restitution_error(accuracy: pd.DataFrame) -> tuple[float, int]:
    """Return the largest error of e anywhere, and at how many points it was looked for."""
    rows = accuracy[accuracy["quantity"] == "coefficient_of_restitution"]
    return float(rows["largest"].max()), int(rows["points"].sum())
