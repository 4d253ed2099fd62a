"""Heavy studies in parts: what is gathered does not depend on how many parts there are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.shared import ROOT
from tests.workflow.conftest import TINY
from workflow.scripts.parts import part_from_text, part_text

from microimpact import studies
from microimpact.core.tables import parse_table, read_table
from microimpact.declared.documents import load
from microimpact.declared.parameters import build
from microimpact.declared.references import merged
from microimpact.run.config import read_configuration, validate
from microimpact.studies.contacts import DRAWN, calibrated_contact

STUDIES = ("campaign", "claim_numbers", "fit_coverage", "interval_coverage", "monte_carlo")


@pytest.fixture(scope="module")
def settings():
    shipped = read_configuration(ROOT / "config")
    return validate(merged(merged(shipped, load(ROOT / "config/ci.yaml")), TINY), shipped)


def test_these_are_all_the_studies_in_parts():
    modules = {name: studies.study(name) for name in studies.homes()}
    assert {name for name, module in modules.items() if hasattr(module, "part")} == set(STUDIES)


@pytest.mark.parametrize("name", STUDIES)
def test_the_number_of_parts_changes_no_bit(name, settings, monkeypatch):
    study = studies.study(name)
    if name == "claim_numbers":
        # its parts are draws; the rest, which is not in parts, rests on tables of many studies
        monkeypatch.setattr(study, "_ascending", lambda: ["C01"])
    params = build(study.Params, settings.branches[name])
    if name == "campaign":
        # every fourth block has impacts of either instrument; counted are those of all blocks
        monkeypatch.setattr(study, "check_counts", lambda *_: None)
        params = replace(params, blocks=params.blocks[::4])
    inputs = {key: parse_table(text) for key, text in settings.rows[name].items()}
    for table in ("calibration", "restitution_fits"):
        inputs[table] = read_table(ROOT / f"tests/reference/tables/{table}.csv")
    if name == "claim_numbers":
        inputs["admissible_contacts"] = draws_of(params, inputs)
    # As the workflow does: parts are made by themselves, in any order, and pass through files.
    parts = [part_text(study.part(params, inputs, i, 3)) for i in (2, 0, 1)]
    gathered = study.gather(params, inputs, [part_from_text(part) for part in parts])
    whole = study.run(params, inputs)
    assert list(gathered) == list(whole)
    for key, table in whole.items():
        pd.testing.assert_frame_equal(gathered[key], table, check_exact=True)


def draws_of(params, inputs):
    """Return calibrated contacts in the form of admissible ones."""
    wanted, rows = params.draws, []
    for number, case in enumerate(2 * params.steel.cases):
        contact = calibrated_contact(inputs, case)
        row = {name: float(getattr(contact, field)) for name, field in DRAWN.items()}
        row |= {
            "case": wanted.case,
            "draw": number,
            "particle": contact.particle.name,
            "surface": contact.surface.name,
            "friction_basis": "compressive",
            "diameter_um": 1e6 * row["diameter_um"],
        }
        rows += [row | {"variant": variant} for variant in wanted.variants]
    return pd.DataFrame(rows)


def test_values_come_back_to_the_last_bit():
    part = [
        (0, {"a": np.float64(0.1) + 0.2, "b": np.nan, "c": -np.inf, "d": np.int64(3), "e": None})
    ]
    ((number, row),) = part_from_text(part_text(part))
    assert number == 0
    assert (row["a"], row["c"], row["d"], row["e"]) == (0.1 + 0.2, -np.inf, 3, None)
    assert np.isnan(row["b"])
    assert isinstance(row["d"], int)


def test_only_plain_values_are_written():
    with pytest.raises(TypeError, match="plain values only, not PosixPath"):
        part_text([Path()])
