"""The page of the explorer and the scripts beside it, with declared and calibrated contacts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from microimpact.model.choices import NUMBERS
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import (
    ALWAYS_CAPTURED_ADHESION_GROUP,
    ALWAYS_CAPTURED_HERTZ_GROUP,
)
from microimpact.model.pairs import pair_contact
from microimpact.model.rigid_body.algebra import INERTIA
from study.contacts import calibrated_contact, declared
from study.report.explorer import FILES, SCRIPTS
from study.report.site.pages import render

HERE = Path(__file__).parent

MATERIAL = ("youngs_modulus", "poissons_ratio", "density")


def page_files(inputs: Mapping[str, pd.DataFrame]) -> dict[str, str]:
    """Return the page and its scripts by their place in the report.

    Parameters
    ----------
    inputs
        ``materials``, ``contacts``: all declared rows; ``calibration``: the table of that study.
    """
    page = render(
        "explorer.html",
        templates=HERE / "templates",
        here="explorer",
        wide=True,
        numbers=numbers(inputs),
        scripts=SCRIPTS,
    )
    files = {"explorer.html": page}
    return files | {
        f"explorer/{name}": (HERE / "assets" / name).read_text(encoding="utf-8") for name in FILES
    }


def numbers(inputs: Mapping[str, pd.DataFrame]) -> dict[str, Any]:
    """Return the constants, materials and contacts of the page, ready for JSON, in SI units.

    ``constants`` of the model, ``materials`` as declared, ``contacts``: the calibrated cases, then
    the declared pairs of other materials; a field that nobody declared is None.

    Parameters
    ----------
    inputs
        As of `page_files`.
    """
    materials, pairs = declared(inputs)
    solved = inputs["calibration"].query("role == 'parameter'")
    cases = dict.fromkeys(solved["case"])
    bodies = solved[["particle", "surface"]]
    calibrated = set(bodies.itertuples(index=False, name=None))
    return {
        "constants": {
            "inertia": INERTIA,
            "always_captured_hertz_group": ALWAYS_CAPTURED_HERTZ_GROUP,
            "always_captured_adhesion_group": ALWAYS_CAPTURED_ADHESION_GROUP,
        },
        "materials": [
            {"material": material.name} | {name: getattr(material, name) for name in MATERIAL}
            for material in materials.values()
        ],
        "contacts": [
            *(_row("calibrated", case, calibrated_contact(inputs, case)) for case in cases),
            *(
                _row("declared", " on ".join(pair), pair_contact(*pair, materials, pairs))
                for pair in pairs
                if pair not in calibrated
            ),
        ],
    }


def _row(origin: str, name: str, contact: Contact) -> dict[str, Any]:
    bodies = {"particle": contact.particle.name, "surface": contact.surface.name}
    values = {field: getattr(contact, field) for field in NUMBERS}
    return {"origin": origin, "contact": name} | bodies | values
