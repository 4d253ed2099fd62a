"""Whatever is wrong with a declared input, one line names the key or the file and the line."""

from __future__ import annotations

import pytest
from tests.bad_input.conftest import DIGITIZED

from microimpact.declared.selection import NamedTables

CONFIG, MATERIALS, CONTACTS = "config.yaml", "materials.csv", "contacts.csv"
PRINTED, FIGURES, POINTS = "printed_values.csv", "figures.yaml", "digitized/fig16.csv"

RESTITUTION = "restitution: {value: 0.70, evidence: printed,"
STEEL = "stainless-steel-316,youngs_modulus,193,GPa,,,found,maker's data sheets of AISI 316"
DIAMETER = "stainless-steel-316,silicon,diameter,62,um,printed,"
ANCHOR = "capture_velocity_psl_quartz,0.967,,,m/s,"

# File, text there, what replaces it, words of the one line.
# fmt: off
CASES = [
    # YAML as such
    (CONFIG, "seed: {value: 20011,", "seed: {value: 20011", ["config.yaml, line 10", "not valid YAML"]),
    (CONFIG, "seed: {", "\tseed: {", ["config.yaml, line 10, column 1", "\\t"]),
    (CONFIG, "seed: {", "seed: [", ["config.yaml, line 10", "not valid YAML"]),
    (CONFIG, "materials: config/materials.csv", "materials: a\nmaterials: b", ["config.yaml, line", "'materials' stands there twice"]),
    (CONFIG, "coulomb_friction:\n", "coulomb_friction:\n  points: 3\n", ["'points' stands there twice"]),
    (CONFIG, "seed: {value: 20011,", "seed: {value: *nowhere,", ["config.yaml, line 10", "undefined alias"]),
    (CONFIG, "seed: {", "seed: !!python/object/apply:os.system ['true']\nother: {", ["config.yaml, line 10", "could not determine a constructor"]),
    (CONFIG, "seed: {", "seed: \x07{", ["config.yaml", "not valid YAML"]),
    (CONFIG, "value: 20011", "value: " + "9" * 5000, ["config.yaml", "not valid YAML", "digits"]),
    # keys
    (CONFIG, "seed: {", "sead: {", ["sead: unknown key (did you mean 'seed'?)", "seed: missing"]),
    (CONFIG, "coulomb_friction:", "coulomb_frction:", ["did you mean 'coulomb_friction'?", "coulomb_friction: missing"]),
    (CONFIG, "  spin_friction: {", "  spin_fricton: {", ["coulomb_friction.spin_fricton: unknown key", "coulomb_friction.spin_friction: missing"]),
    (CONFIG, "seed: {value: 20011", "1: 2\nseed: {value: 20011", ["1: unknown key"]),
    # values and their provenance
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "1.5"), ["coulomb_friction.restitution: 1.5", "less than or equal to 1"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "-0.1"), ["coulomb_friction.restitution: -0.1"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", ".nan"), ["coulomb_friction.restitution: nan", "finite"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", ".inf"), ["coulomb_friction.restitution: inf"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "yes"), ["coulomb_friction.restitution: True"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "'0.70'"), ["coulomb_friction.restitution: '0.70'"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "7e-1"), ["coulomb_friction.restitution: '7e-1'"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "0,70"), ["coulomb_friction.restitution"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "2026-11-21"), ["coulomb_friction.restitution"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", "[0.70]"), ["coulomb_friction.restitution.value", "single value"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("0.70", ""), ["coulomb_friction.restitution"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("printed", "guessed"), ["coulomb_friction.restitution.evidence: 'guessed' must be one of"]),
    (CONFIG, RESTITUTION, RESTITUTION.replace("value:", "vale:"), ["coulomb_friction.restitution"]),
    (CONFIG, "friction: {values: [0.05, 0.10, 0.15, 0.20]", "friction: {values: 0.05", ["coulomb_friction.friction.values: 0.05 must be a list"]),
    (CONFIG, "friction: {values: [0.05, 0.10", "friction: {values: [0.05, -0.10", ["coulomb_friction.friction[1]: -0.1"]),
    (CONFIG, "points: {value: 360,", "points: {value: 360.5,", ["coulomb_friction.points: 360.5"]),
    (CONFIG, "points: {value: 360,", "points: {value: 0,", ["coulomb_friction.points: 0"]),
    (CONFIG, "seed: {value: 20011", "seed: {value: -1", ["seed: -1"]),
    (CONFIG, "source: root of every random draw", "source: ''", ["seed.source: '' must say where"]),
    (CONFIG, "coulomb_friction:\n", "coulomb_friction: 3\nwas:\n", ["coulomb_friction: 3 must be a mapping"]),
    # names that are not declared
    (CONFIG, "particle: stainless-steel-316\n  surface: silicon", "particle: stainles-steel-316\n  surface: silicon", ["materials.csv", "no rows for 'stainles-steel-316'", "did you mean 'stainless-steel-316'?"]),
    (CONFIG, "surface: molybdenum", "surface: silicon", ["contacts.csv", "no rows for 'ammonium-fluorescein on silicon'"]),
    (CONFIG, "- plateau_end_angle", "- plateau_end", ["printed_values.csv: no rows for 'plateau_end'"]),
    (CONFIG, "materials: config/materials.csv", "materials: config/material.csv", ["config/material.csv"]),
    (CONFIG, "digitized: config/digitized", "digitized: config/nowhere", ["digitized: 'config/nowhere' must be a folder"]),
    (CONFIG, "figures: config/figures.yaml", "figures: config/materials.csv", ["config/materials.csv"]),
    # declared tables
    (MATERIALS, "material,property", "material;property", ["materials.csv: the header is"]),
    (MATERIALS, STEEL, STEEL + ",more", ["materials.csv, line 2: must have 8 fields"]),
    (MATERIALS, STEEL, "stainless-steel-316,youngs_modulus,193,GPa", ["materials.csv, line 2: must have 8 fields"]),
    (MATERIALS, STEEL, STEEL.replace("193", "193 GPa"), ["materials.csv, line 2: value '193 GPa' must be a finite number"]),
    (MATERIALS, STEEL, STEEL.replace("193", "1,93"), ["materials.csv, line 2"]),
    (MATERIALS, STEEL, STEEL.replace("193", "nan"), ["materials.csv, line 2: value 'nan' must be a finite number"]),
    (MATERIALS, STEEL, STEEL.replace("193", "-193"), ["material 'stainless-steel-316'", "youngs_modulus", "> 0, got -193000000000"]),
    (MATERIALS, STEEL, STEEL.replace("193", "0"), ["material 'stainless-steel-316'", "youngs_modulus"]),
    (MATERIALS, STEEL, STEEL.replace("193", ""), ["materials.csv, line 2: value '' must be a finite number"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", "psi"), ["material 'stainless-steel-316', youngs_modulus", "psi"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", "um"), ["material 'stainless-steel-316', youngs_modulus", "um"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", ""), ["materials.csv, line 2: unit is empty"]),
    (MATERIALS, STEEL, STEEL.replace("found", "rumour"), ["materials.csv, line 2: evidence 'rumour' must be one of"]),
    (MATERIALS, STEEL, STEEL.replace("maker's data sheets of AISI 316", " "), ["materials.csv, line 2: source is empty"]),
    (MATERIALS, STEEL, STEEL.replace("youngs_modulus", "young_modulus"), ["property 'young_modulus' unknown (did you mean 'youngs_modulus'?)"]),
    (MATERIALS, STEEL, STEEL + "\n" + STEEL, ["material 'stainless-steel-316': youngs_modulus is declared twice"]),
    (MATERIALS, STEEL + "\n", "", ["material 'stainless-steel-316': youngs_modulus not declared"]),
    (MATERIALS, "poissons_ratio,0.28", "poissons_ratio,0.6", ["material 'stainless-steel-316'", "poissons_ratio", "0.6"]),
    (MATERIALS, STEEL, '"' + STEEL, ["materials.csv, line"]),
    (CONTACTS, DIAMETER, DIAMETER.replace("62", "sixty-two"), ["contacts.csv, line 2: value 'sixty-two' must be a finite number"]),
    (CONTACTS, DIAMETER, DIAMETER.replace("um", "J/m2"), ["contact 'stainless-steel-316' on 'silicon', diameter"]),
    (CONTACTS, DIAMETER, DIAMETER.replace("diameter", "diametre"), ["property 'diametre' unknown (did you mean 'diameter'?)"]),
    (PRINTED, ANCHOR, ANCHOR.replace("0.967", ""), ["printed_values.csv, line 2: value '' must be a finite number"]),
    (PRINTED, ANCHOR, ANCHOR.replace("m/s", ""), ["printed_values.csv, line 2: unit is empty"]),
    (PRINTED, "key,value", "name,value", ["printed_values.csv: the header is name, value"]),
    # figure registry
    (FIGURES, "\nfig14:", "\nfigure14:", ["figure14"]),
    (FIGURES, "study: restitution_trends", "study: restitution_trend", ["'restitution_trend' is no study (did you mean 'restitution_trends'?)"]),
    (FIGURES, "[[set_ups.disk_slots]]", "[[set_ups.disk_slot]]", ["no parameter 'set_ups.disk_slot' (did you mean 'disk_slots'?)"]),
    (FIGURES, "module: microimpact.figures.", "module: os.", ["module"]),
    (FIGURES, "x_range: [", "x_range: [9.0e9, ", ["x_range"]),
    (FIGURES, "width: double", "width: triple", ["width: 'triple'"]),
    # digitised points
    (POINTS, "# licence: CC0-1.0\n", "", ["fig16.csv", "licence"]),
    (POINTS, "# source: made up", "# source:", ["fig16.csv", "source"]),
    (POINTS, "1.0,0.5,0.4,0.6", "1.0,0.5,0.6,0.4", ["fig16.csv, line 5"]),
    (POINTS, "1.0,0.5,0.4,0.6", "one,0.5,0.4,0.6", ["fig16.csv, line 5", "'one'"]),
    (POINTS, "1.0,0.5,0.4,0.6", "1.0,0.5", ["fig16.csv, line 5"]),
    (POINTS, "1.0,0.5,0.4,0.6", "1.0,inf,,", ["fig16.csv, line 5", "'inf'"]),
    (POINTS, "another,2.0,0.5,,", "a series,1.0,0.5,0.4,0.6", ["fig16.csv, line 6"]),
    (POINTS, "series,x,y", "series,y,x", ["fig16.csv"]),
]
# fmt: on


@pytest.mark.parametrize(("name", "old", "new", "words"), CASES, ids=range(len(CASES)))
def test_one_clear_error(declared, name, old, new, words):
    declared.replace(name, old, new)
    with pytest.raises((ValueError, OSError)) as caught:
        declared.read()
    told = str(caught.value)
    for word in words:
        assert word in told
    assert len(told.splitlines()) <= len(words) + 1
    assert "Traceback" not in told
    assert "pydantic" not in told


def test_there_are_many_of_them():
    assert len(CASES) >= 60


def test_unspoilt_inputs_are_read(declared):
    settings, found = declared.read()
    assert "fig16" in found.digitized
    assert set(found.rows) == set(settings.branches)


BYTES = [
    (CONFIG, b"\xff\xfe\x00", "config.yaml: not valid YAML"),
    (CONFIG, b"", "config.yaml: must hold a mapping"),
    (CONFIG, b"- 1\n", "config.yaml: must hold a mapping"),
    (CONFIG, b"[" * 100_000, "config.yaml: not valid YAML: nested too deeply"),
    (CONFIG, b"a: &a [*a]\n", "with its aliases written out it holds more than"),
    (
        CONFIG,
        b"".join(b"a%d: &a%d [%s]\n" % (i, i, b",".join([b"*a%d" % (i - 1) if i else b"1"] * 10)) for i in range(12)),
        "with its aliases written out it holds more than",
    ),
    (MATERIALS, b"", "materials.csv: the header is"),
    (MATERIALS, b"\x00\x01", "materials.csv"),
    (MATERIALS, b"material,\xe9\n", "materials.csv: must be a text in UTF-8, byte 9 is not"),
    (CONTACTS, b"particle,surface\n", "contacts.csv: the header is particle, surface;"),
    (POINTS, b"# source: a", "fig16.csv, line 1, header"),
    (POINTS, b"\xff", "fig16.csv"),
    (FIGURES, b"fig14: 3\n", "fig14: 3 must be a mapping"),
    (FIGURES, b"fig14: {study: {}}\n", "fig14.study: {} is no study"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content", "words"), BYTES, ids=range(len(BYTES)))
def test_a_file_that_is_none(declared, name, content, words):
    declared.write(name, content)
    with pytest.raises((ValueError, OSError)) as caught:
        declared.read()
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 3


def test_a_byte_order_mark_and_other_line_ends_do_no_harm(declared):
    for name in (CONFIG, MATERIALS, CONTACTS, FIGURES):
        text = (declared.root / "config" / name).read_text(encoding="utf-8")
        declared.write(name, b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    declared.write(POINTS, DIGITIZED.replace("\n", "\r\n").encode())
    assert declared.read()[0].general.seed == 20011


def test_a_study_whose_branch_names_no_rows(declared):
    declared.replace(
        CONFIG,
        "  anchors: [peak_adhesion_over_peak_hertz, peak_adhesion_dissipation_over_adhesion]\n",
        "  anchors: []\n",
    )
    rows = declared.read()[1].rows["force_history"]
    assert set(rows) == {"materials", "contacts"}
    with pytest.raises(ValueError, match="no rows of 'anchors': the study's branch must name some"):
        NamedTables(rows)["anchors"]
