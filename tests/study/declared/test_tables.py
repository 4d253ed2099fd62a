"""Tables on disk, selection of declared rows, provenance."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from tests.shared import ROOT

from study import tables
from study.declared import selection
from study.declared.parameters import (
    CaseName,
    CounterpartName,
    Known,
    MaterialName,
    PrintedName,
    build,
    explain,
)
from study.declared.provenance import unit_of


def test_numbers_survive_the_way_to_disk_and_back(tmp_path):
    numbers = np.array([0.1 + 0.2, 1e-300, -math.pi * 1e17, math.nan])
    table = pd.DataFrame({"name": ["a", "NA", "None", "d,e"], "number": numbers})
    path = tmp_path / "deep/table.csv"
    tables.write_table(table, path)
    back = tables.read_table(path, ["name", "number"])
    assert back["number"].equals(table["number"])
    assert list(back["name"]) == ["a", "NA", "None", "d,e"]
    assert [p.name for p in path.parent.iterdir()] == ["table.csv"]


def test_unknown_evidence_is_refused():
    with pytest.raises(ValueError, match="evidence: 'guessed' must be one of"):
        tables.series_frame(
            panel="p", series="s", evidence="guessed", x=1, y=1, x_unit="m", y_unit="m"
        )


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("a.speed_m_per_s", "m/s"),
        ("a.speed_m_per_s.mean", "m/s"),
        ("diameter_um.edges[1]", "um"),
        ("diameter_um.geometric_sd", "-"),
        ("diameter_um", "um"),
        ("damping_s_per_m", "s/m"),
        ("work_of_adhesion_J_per_m2", "J/m2"),
        ("density_kg_per_m3", "kg/m3"),
        ("spin_rad_per_s", "rad/s"),
        ("angle_deg[3]", "deg"),
        ("points", "-"),
        ("spin_ratio", "-"),
    ],
)
def test_units_in_names(key, unit):
    assert unit_of(key) == unit


def test_only_named_rows_are_selected(tmp_path):
    header = "material,property,value,unit,low,high,evidence,source"
    steel = 'steel,density,8000,kg/m3,,,found,"data, sheet"'
    silicon = "silicon,density,2330,kg/m3,2320,2340,textbook,handbook"
    path = tmp_path / "materials.csv"
    path.write_text("\n".join([header, steel, silicon, ""]))
    table = selection.read_declared(str(path), "materials")
    assert table.text({"steel"}) == f"{header}\n{steel}\n"


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropped:
    particle: MaterialName
    surface: CounterpartName
    case: CaseName
    marks: tuple[PrintedName, ...]


GIVEN = {
    "particle": "ammonium-fluorescein",
    "surface": "molybdenum",
    "case": "steel-formica",
    "marks": ["capture_velocity_af_mica"],
}
BODIES = {"steel-formica": ("stainless-steel-316", "formica")}


@pytest.fixture(scope="module")
def declared():
    paths = {name: str(ROOT / f"config/{name}.csv") for name in selection.TABLES}
    return selection.read_all(paths)


def known(declared):
    return Known(declared.names() | {"cases": ("cases", set(BODIES))})


def test_printed_numbers_of_contacts_are_those_that_are_printed(declared):
    printed = {(row["where"], row["value"]) for row in declared.printed_values.rows}
    rows = [row for row in declared.contacts.rows if row["evidence"] == "printed"]
    contacts = {(row["source"], row["value"]) for row in rows if row["property"] != "ring_force"}
    assert len(contacts) >= 4
    assert contacts <= printed


def test_the_rows_of_a_branch_follow_from_what_its_types_call_names(declared):
    names = known(declared)
    build(Dropped, GIVEN, names)
    rows = declared.named(names.named, BODIES)
    materials = {line.split(",")[0] for line in rows["materials"].splitlines()[1:]}
    assert materials == {"ammonium-fluorescein", "molybdenum", *BODIES["steel-formica"]}
    assert {line.split(",")[1] for line in rows["contacts"].splitlines()[1:]} == {"molybdenum"}
    assert rows["printed"].count("\n") == 2
    assert declared.named([], BODIES) == {}


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"particle": "ammonium"}, "x.particle: 'ammonium' is not declared in .*materials.csv"),
        ({"surface": "mica-2"}, "'ammonium-fluorescein on mica-2' is not declared .*did you mean"),
        ({"case": "steel-formic"}, r"'steel-formic' is not declared in cases \(did you mean"),
        ({"marks": ["friction"]}, r"x.marks\[0\]: 'friction' is not declared in .*printed"),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest(declared, change, line):
    with pytest.raises(ValidationError) as caught:
        build(Dropped, GIVEN | change, known(declared))
    assert re.search(line, explain(caught.value, Dropped, "x")[0])


def test_a_zero_has_no_sign():
    frame = tables.series_frame(
        panel="main", series="a", evidence="computed", x=-0.0, y=[-0.0], x_unit="s", y_unit="N"
    )
    assert "-0.0" not in frame.to_csv()
