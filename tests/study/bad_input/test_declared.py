"""Whatever is wrong with a declared input, one line names the key or the file and the line."""

from __future__ import annotations

import pytest
from tests.shared import shipped
from tests.study.bad_input.conftest import DIGITISED

from study.declared.documents import ConfigError
from study.declared.references import merged
from study.declared.selection import NamedTables
from study.run.config import read_inputs, validate

CONFIG, MATERIALS, CONTACTS = "config.yaml", "materials.csv", "contacts.csv"
LABORATORY, PRINTED, EXTERNAL = "laboratory.yaml", "printed_values.csv", "external.csv"
COULOMB, OBLIQUE, SET_UPS = (
    f"analyses/{name}.yaml"
    for name in (
        "fig17_coulomb_friction",
        "fig06_12_oblique_experiments",
        "fig01_03_13_19_22_schematics",
    )
)
POINTS = "digitised/fig14.csv"

RESTITUTION = "restitution: {value: 0.80, evidence: derived,"
STEEL = "stainless-steel-316,youngs_modulus,193,GPa,,,found,maker's data sheets of AISI 316"
DIAMETER = "stainless-steel-316,silicon,diameter,62,um,printed,Section 2.4.1"
GIVEN = "stainless-steel-316,silicon,diameter,62,um,assumed,as told"
ANCHOR = "capture_velocity_psl_quartz,0.967,,,m/s,"

# File, text there, what replaces it, words of the one line.
# fmt: off
CASES = [
    # YAML as such
    (CONFIG, "seed: {value: 20011,", "seed: {value: 20011", ["config.yaml, line 9", "not valid YAML"]),
    (CONFIG, "materials: config/materials.csv", "materials: a\nmaterials: b", ["config.yaml, line", "'materials' is given twice"]),
    (CONFIG, "seed: {value: 20011,", "seed: {value: *nowhere,", ["config.yaml, line 9", "undefined alias"]),
    (CONFIG, "seed: {", "seed: !!python/object/apply:os.system ['true']\nother: {", ["config.yaml, line 9", "could not determine a constructor"]),
    (CONFIG, "value: 20011", "value: " + "9" * 5000, ["config.yaml", "not valid YAML", "digits"]),
    (CONFIG, "value: 20011", "value: 0777", ["config.yaml, line 9", "a leading zero", "'0777"]),
    (CONFIG, "value: 20011", "value: 1:30", ["config.yaml, line 9", "a colon is read in base 8 or 60", "'1:30"]),
    # keys
    (CONFIG, "seed: {", "sead: {", ["sead: unknown key (did you mean 'seed'?)", "seed: missing"]),
    (COULOMB, "fig17_coulomb_friction:", "fig17_coulomb_frction:", ["did you mean 'fig17_coulomb_friction'?", "fig17_coulomb_friction: missing"]),
    (COULOMB, "  spin_friction: {", "  spin_fricton: {", ["fig17_coulomb_friction.spin_fricton: unknown key", "fig17_coulomb_friction.spin_friction: missing"]),
    # values and their provenance
    (LABORATORY, RESTITUTION, RESTITUTION.replace("0.80", "1.5"), ["cases.steel-mirror front.restitution: 1.5", "less than or equal to 1"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("0.80", ".nan"), ["cases.steel-mirror front.restitution: nan", "finite"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("0.80", "7e-1"), ["cases.steel-mirror front.restitution: '7e-1'"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("0.80", "[0.70]"), ["cases.steel-mirror front.restitution.value", "single value"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("0.80", ""), ["cases.steel-mirror front.restitution"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("derived", "guessed"), ["cases.steel-mirror front.restitution.evidence: 'guessed' must be one of"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("derived", "[derived]"), ["cases.steel-mirror front.restitution.evidence: ['derived'] must be one of"]),
    (LABORATORY, RESTITUTION, RESTITUTION.replace("value:", "vale:"), ["cases.steel-mirror front.restitution"]),
    (COULOMB, "friction: {values: [0.05, 0.10, 0.15, 0.20]", "friction: {values: 0.05", ["fig17_coulomb_friction.friction.values: 0.05 must be a list"]),
    (COULOMB, "friction: {values: [0.05, 0.10", "friction: {values: [0.05, -0.10", ["fig17_coulomb_friction.friction[1]: -0.1"]),
    (COULOMB, "points: {value: 360,", "points: {value: 360.5,", ["fig17_coulomb_friction.points: 360.5"]),
    (CONFIG, "seed: {value: 20011", "seed: {value: -1", ["seed: -1"]),
    (CONFIG, "source: \"root of every random draw; an analysis takes its seed from this and its name, unless it gives one\"", "source: ''", ["seed.source: '' must say where"]),
    (COULOMB, "fig17_coulomb_friction:\n", "fig17_coulomb_friction: 3\nwas:\n", ["fig17_coulomb_friction: 3 must be a mapping"]),
    # names that are not declared
    ("analyses/fig20_force_history.yaml", "case: {from: impact.force_history}", "case: fluorescein-molybdenum, nomial", ["fig20_force_history.case: 'fluorescein-molybdenum, nomial' is not declared in cases (did you mean 'fluorescein-molybdenum, nominal'?)"]),
    (LABORATORY, "    surface: {from: surfaces.Formica}", "    surface: formcia", ["cases.steel-formica.surface: 'formcia' is not declared in config/materials.csv (did you mean 'formica'?)"]),
    (OBLIQUE, "printed: impulse_ratio_plateau", "printed: impulse_ratio_plat", ["fig06_12_oblique_experiments.series.silicon front.marks.printed plateau.printed: 'impulse_ratio_plat' is not declared in config/printed_values.csv", "did you mean 'impulse_ratio_plateau'?"]),
    (PRINTED, "1.59 to 1.69,50 to 15", "1.59 to fast,50 to 15", ["printed_values.csv, line", "speed_m_per_s: '1.59 to fast' must be numbers, as 49; 62 or 15 to 85, or empty"]),
    (PRINTED, "\ndoe_small_variation,", "\ndoe_variation,", ["printed_values.csv: doe_small_variation: missing; fig24_25_doe reads it"]),
    (LABORATORY, "    case: steel-formica", "    case: stainless-steel-316 on formcia", ["drops.steel on Formica.case: 'stainless-steel-316 on formcia' is not declared in cases (did you mean 'stainless-steel-316 on formica'?)"]),
    ("analyses/calibration.yaml", "    steel-formica: {from: cases.steel-formica}\n", "", ["cases.steel-formica: is named, but calibration does not calibrate it"]),
    (CONTACTS, "stainless-steel-316,formica,work_of_adhesion", "stainless-steel-316,formcia,work_of_adhesion", ["contacts.csv: stainless-steel-316 on formica: the pair", "is incomplete; give work_of_adhesion", "unknown material 'formcia' (did you mean 'formica'?)"]),
    ("analyses/campaign.yaml", "speeds: [{from: speeds.fast},", "speeds: [{from: speeds.fats},", ["campaign.blocks.SST65 on silicon.speeds[0].from: 'speeds.fats' is not declared (did you mean 'fast'?)"]),
    (CONFIG, "materials: config/materials.csv", "materials: config/material.csv", ["materials: 'config/material.csv' must be a file; there is none"]),
    # slips of lists, kinds and units
    (COULOMB, "friction: {values: [0.05, 0.10, 0.15, 0.20]", "friction: {values: []", ["fig17_coulomb_friction.friction: [] must hold at least one number"]),
    (COULOMB, "friction: {values: [0.05, 0.10, 0.15, 0.20]", "friction: {value: 0.3", ["fig17_coulomb_friction.friction: 0.3 must be a list, as [0.3]"]),
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: 1.0e+8", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s: 1e+08 m/s must be from 0 to 1000 m/s"]),
    (LABORATORY, "kind: truncated_normal\n      mean: {value: 54.0", "kind: gaussian\n      mean: {value: 54.0", ["particles.glass spheres.diameter_um.kind: 'gaussian' must be one of constant, uniform, normal"]),
    # references
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: {from: speeds.nominl}", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s.from: 'speeds.nominl' is not declared (did you mean 'nominal'?)"]),
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: {from: track_imaging.angles_deg}", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s.from: 'track_imaging.angles_deg' is not declared"]),
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: {from: 3}", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s.from: '3' is not declared"]),
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: {from: surfaces.Formica}", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s.from: no speed_m_per_s in surfaces.Formica"]),
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: {from: speeds.nominal, valu: 3}", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s.valu: unknown key"]),
    (SET_UPS, "speed_m_per_s: {from: speeds.nominal}", "speed_m_per_s: {from: speeds.nominal, value: -3}", ["fig01_03_13_19_22_schematics.rebound.speed_m_per_s: -3"]),
    (LABORATORY, "mirror front, speeds.nominal]", "mirror font, speeds.nominal]", ["drops.steel on mirror.from: 'surfaces.mirror font' is not declared (did you mean 'mirror front'?)"]),
    (LABORATORY, "other pairs: {from: frictions.steel on silicon", "other pairs: {from: frictions.other pairs", ["frictions.other pairs", "refers to itself"]),
    ("analyses/fig04_05_normal_experiments.yaml", "populations: {from: impact}", "populations: [SST65, SST125]", ["fig04_05_normal_experiments.populations: ['SST65', 'SST125'] must be a mapping"]),
    (LABORATORY, "target_radius_mm: {value: 5.0", "target_radius_mm: {value: 5.5", ["pile.target_radius_mm: 5.5 must be one of radii_mm, [3, 5, 10]"]),
    ("analyses/claim_numbers.yaml", "angles_deg: {values: [50, 10]", "angles_deg: {values: [5, 10]", ["claim_numbers.C13.angles_deg: [5, 10] must descend"]),
    (LABORATORY, "speed_range_m_per_s: {values: [1.6, 1.72]", "speed_range_m_per_s: {values: [1.72, 1.6]", ["speeds.nominal.speed_range_m_per_s: [1.72, 1.6] must ascend"]),
    (LABORATORY, "angles_deg: {values: [85, 80, 75, 70, 60, 55, 50, 45, 40, 30, 20, 15, 10, 5]", "angles_deg: {values: [95]", ["experiment.angles_deg[0]: 95 must be less than or equal to 90"]),
    (LABORATORY, "      mean: {value: 50.0, evidence", "      mode: 3\n      mean: {value: 50.0, evidence", ["particles.SST65.diameter_um.mode: unknown key"]),
    (LABORATORY, "surfaces:\n", "surfaces: 3\nnone:\n", ["surfaces: 3 must be a mapping"]),
    ("analyses/fig23_monte_carlo.yaml", "      low: {value: 1.61,", "      lower: {value: 1.61,", ["speed_m_per_s.low: missing", "speed_m_per_s.lower: unknown key"]),
    # declared tables
    (MATERIALS, "material,property", "material;property", ["materials.csv: the header is"]),
    (MATERIALS, STEEL, STEEL + ",more", ["materials.csv, line 2: must have 8 fields"]),
    (MATERIALS, STEEL, "stainless-steel-316,youngs_modulus,193,GPa", ["materials.csv, line 2: must have 8 fields"]),
    (MATERIALS, STEEL, STEEL.replace("193", "193 GPa"), ["materials.csv, line 2, value: '193 GPa' must be a valid number"]),
    (MATERIALS, STEEL, STEEL.replace("193", "1,93"), ["materials.csv, line 2"]),
    (MATERIALS, STEEL, STEEL.replace("193", "nan"), ["materials.csv, line 2, value: nan must be a finite number"]),
    (MATERIALS, STEEL, STEEL.replace("193", "-193"), ["material 'stainless-steel-316'", "youngs_modulus", "> 0, got -193000000000"]),
    (MATERIALS, STEEL, STEEL.replace("193", "0"), ["material 'stainless-steel-316'", "youngs_modulus"]),
    (MATERIALS, STEEL, STEEL.replace("193", ""), ["materials.csv, line 2, value: None must be"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", "psi"), ["material 'stainless-steel-316', youngs_modulus", "psi"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", "um"), ["material 'stainless-steel-316', youngs_modulus", "um"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", ""), ["materials.csv, line 2, unit: '' must not be empty"]),
    (MATERIALS, STEEL, STEEL.replace("found", "rumour"), ["materials.csv, line 2, evidence: 'rumour' must be one of"]),
    (MATERIALS, STEEL, STEEL.replace("maker's data sheets of AISI 316", " "), ["materials.csv, line 2, source: ' ' must not be empty"]),
    (MATERIALS, STEEL, STEEL.replace("youngs_modulus", "young_modulus"), ["property 'young_modulus' unknown (did you mean 'youngs_modulus'?)"]),
    (MATERIALS, STEEL, STEEL + "\n" + STEEL, ["material 'stainless-steel-316': youngs_modulus is declared twice"]),
    (MATERIALS, STEEL + "\n", "", ["material 'stainless-steel-316': youngs_modulus not declared"]),
    (MATERIALS, "poissons_ratio,0.28,-,0.27,0.30", "poissons_ratio,0.6,-,,", ["material 'stainless-steel-316'", "poissons_ratio", "0.6"]),
    (MATERIALS, "0.28,-,0.27,0.30", "0.28,-,0.30,0.27", ["materials.csv, line 3, low: 0.3 must be below high, 0.27"]),
    (MATERIALS, "0.28,-,0.27,0.30", "0.28,-,0.29,0.30", ["materials.csv, line 3, value: 0.28 must be from low to high, 0.29 to 0.3"]),
    (MATERIALS, "0.28,-,0.27,0.30", "0.28,-,0.27,0.6", ["materials.csv: material 'stainless-steel-316'", "poissons_ratio", "0.6"]),
    (MATERIALS, STEEL, STEEL.replace(",,,", ",-1,200,"), ["materials.csv: material 'stainless-steel-316'", "youngs_modulus", "> 0, got -1000000000"]),
    (MATERIALS, STEEL, '"' + STEEL, ["materials.csv, line"]),
    (MATERIALS, STEEL, STEEL.replace("GPa", "Pa"), ["config/materials.csv: stainless-steel-316: youngs_modulus = 193 Pa is not from"]),
    (MATERIALS, STEEL, STEEL.replace("193", "193000000000"), ["config/materials.csv: stainless-steel-316: youngs_modulus = ", "is not from"]),
    (MATERIALS, "density,8000,kg/m3", "density,8,kg/m3", ["config/materials.csv: stainless-steel-316: density = 8 kg/m3 is not from 10 to 30000 kg/m3: in g/cm3?"]),
    (CONTACTS, DIAMETER, GIVEN.replace("62,um", "0.000062,um"), ["config/contacts.csv: stainless-steel-316 on silicon: diameter = 6.2e-11 m is not from 1e-09 to 0.005 m"]),
    (CONTACTS, DIAMETER, GIVEN.replace("62,um", "62,m"), ["config/contacts.csv: stainless-steel-316 on silicon: diameter = 62 m is not"]),
    (CONTACTS, DIAMETER, GIVEN.replace("62", "sixty-two"), ["contacts.csv, line 2, value: 'sixty-two' must be a valid number"]),
    (CONTACTS, DIAMETER, GIVEN.replace(",um,", ",J/m2,"), ["contact 'stainless-steel-316' on 'silicon', diameter"]),
    (CONTACTS, DIAMETER, GIVEN.replace("diameter", "diametre"), ["property 'diametre' unknown (did you mean 'diameter'?)"]),
    (CONTACTS, DIAMETER, DIAMETER.replace("printed", ""), ["contacts.csv, line 2, evidence: '' must be one of"]),
    (CONTACTS, "stainless-steel-316,silicon,friction,0.15,-,printed,Sections 2.4.1 and 2.4.2", "stainless-steel-316,silicon,friction,-0.15,-,assumed,as told", ["config/contacts.csv: stainless-steel-316 on silicon: friction must be", ">= 0", "-0.15"]),
    (CONTACTS, DIAMETER, GIVEN.replace("62", "0"), ["config/contacts.csv: stainless-steel-316 on silicon: diameter must be"]),
    (PRINTED, ANCHOR, ANCHOR.replace("0.967", ""), ["printed_values.csv, line 2, value: None must be"]),
    (PRINTED, ANCHOR, ANCHOR.replace("m/s", ""), ["printed_values.csv, line 2, unit: '' must not be empty"]),
    (PRINTED, ANCHOR, ANCHOR.replace("m/s", "mm/s"), ["printed.capture_velocity_psl_quartz: the unit mm/s must be m/s, as that of calibration.by_work_of_adhesion.polystyrene-latex-fused-silica.capture_velocity_m_per_s"]),
    (CONTACTS, "lycopodium,silicon,diameter,33,um", "lycopodium,silicon,diameter,0.033,mm", ["contacts.lycopodium on silicon.diameter: the unit mm must be um, as that of "]),
    (CONTACTS, DIAMETER, GIVEN.replace(",um,", ",J/m2,"), ["config/contacts.csv: contact 'stainless-steel-316' on 'silicon', diameter: unit 'J/m2' must be one of"]),
    (EXTERNAL, "A,1.84,", "A,steep,", ["external.csv, line 2, at: 'steep' must be a valid number"]),
    (EXTERNAL, ",0.015,found", ",-0.015,found", ["external.csv, line 2, reading_error: -0.015 must be greater than or equal to 0"]),
    (EXTERNAL, ",2.6,6.9,um", ",6.9,2.6,um", ["external.csv, line", "low: 6.9 must be below high, 2.6"]),
    (PRINTED, "pile_up_speed_sst_silicon,,0.2,0.3", "pile_up_speed_sst_silicon,,0.3,0.2", ["printed_values.csv, line 10, low: 0.3 must be below high, 0.2"]),
    (EXTERNAL, ",0.79344,", ",,", ["external.csv, line 2, value: None must be"]),
    ("analyses/oblique_data.yaml", "external: kharaz2001", "external: kharas2001", ["oblique_data.external: 'kharas2001' is not declared in config/external.csv (did you mean 'kharaz2001'?)"]),
    (PRINTED, "key,value", "name,value", ["printed_values.csv: the header is name, value"]),
    # digitised points: run/test_digitised.py has all that may be wrong in a file
    (POINTS, "1.0,0.5,0.4,0.6", "1.0,0.5,0.6,0.4", ["fig14.csv, line 5"]),
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


def test_unspoilt_inputs_are_read(declared):
    settings, found = declared.read()
    assert "fig14" in found.digitised
    assert set(settings.rows) == set(settings.branches)


BYTES = [
    (CONFIG, b"\xff\xfe\x00", "config.yaml: not valid YAML"),
    (CONFIG, b"", "config.yaml: must hold a mapping"),
    (MATERIALS, b"", "materials.csv: the header is"),
    (MATERIALS, b"material,\xe9\n", "materials.csv: must be a text in UTF-8, byte 9 is not"),
]  # fmt: skip


# What a user lays over the files as shipped, and the lines that refuse it.
OVERLAYS = [
    ({"fig20_force_history": {"diameter_um": 4, "9": None}}, ["fig20_force_history.9: unknown key (known here: angle_deg,"]),  # {diameter_um: 4,9}
    ({"nonsense": None}, ["nonsense: unknown key"]),
    ({"fig17_coulomb_friction": {"spin_friction": "0.3"}}, ["fig17_coulomb_friction.spin_friction: '0.3' must be a valid number (it is text: write it without quotes"]),
    ({"pathvars": {"reslts": "x"}}, ["pathvars.reslts: unknown key (did you mean 'results'?)"]),
    ({"fig14_restitution_trends": {"largest_speed_m_per_s": 0.5}}, ["fig14_restitution_trends.largest_speed_m_per_s: 0.5 must be above capture_speed_m_per_s, 1"]),
    ({"rival_explanations": {"slow_speed_m_per_s": 0.21}}, ["rival_explanations.slow_speed_m_per_s: 0.21 must be one of pile_up.speeds_m_per_s ["]),
    ({"fig17_coulomb_friction": {"points": {"value": 9, "evidence": "chosen"}}}, ["fig17_coulomb_friction.points.source: None must say where"]),
    ({"fig17_coulomb_friction": {"points": {"value": 9, "values": [9], "evidence": "chosen", "source": "x"}}}, ["fig17_coulomb_friction.points: give either value (one) or values"]),
    ({"particles": None}, ["particles: missing"]),
    ({"particles": {"SST77": None}}, ["particles.SST77: None must be a mapping"]),
    ({"particles": {"SST77": {"particle": "glass", "particle_slope": 0.1}}}, [f"particles.SST77.{key}: changes nothing: no analysis names it" for key in ("particle", "particle_slope")]),
    ({"speeds": {"nominal": {"speed_m_per_s": 0}}}, ["speeds.nominal.speed_m_per_s: 0 must be greater than 0", "inference."]),
    ({"fig23_monte_carlo": {"process": {"diameter_um": {"kind": "constant", "at": 6.2e-5}}}}, ["fig23_monte_carlo.process.diameter_um.at: 6.2e-05 um must be from 0.001 to 5000 um"]),
    ({"fig23_monte_carlo": {"process": {"diameter_um": {"kind": "histogram", "edges": [5e-5, 6e-5], "counts": [1]}}}}, ["fig23_monte_carlo.process.diameter_um.edges[0]: 5e-05 um must be", "fig23_monte_carlo.process.diameter_um.edges[1]: 6e-05 um must be"]),
    ({"fig23_monte_carlo": {"process": {"slope": 0.3}}}, ["fig23_monte_carlo.process.slope: 0.3 must be a mapping with the key kind: constant, uniform,"]),
    ({"fig23_monte_carlo": {"process": {"slope": {"kind": ["normal"]}}}}, ["fig23_monte_carlo.process.slope.kind: \"['normal']\" must be one of constant, uniform,"]),
    # what is allowed alone, but contradicts something else
    ({"particles": {"SST76": {"mean_diameter_um": 60}}}, ["particles.SST76: mean_diameter_um 60 must be the mean of diameter_um, 62: change both"]),
    ({"fig23_monte_carlo": {"process": {"diameter_um": {"kind": "truncated_normal", "mean": 50, "sd": 9, "low": 100, "high": 110}}}}, ["fig23_monte_carlo.process.diameter_um: from 100 to 110, only 1e-08 of mean 50, sd 9 is left"]),
    ({"fig06_12_oblique_experiments": {"series": {"silicon front": {"speed_m_per_s": 3.0}}}}, ["fig06_12_oblique_experiments.series.silicon front.speed_m_per_s: 3 must be within speed_range_m_per_s, [1.6, 1.72]"]),
    ({"drops": {"steel on silicon": {"case": "steel-formica"}}}, ["drops.steel on silicon.case: 'steel-formica' is of stainless-steel-316 on formica, must be of stainless-steel-316 on silicon"]),
    ({"cases": {"steel-silicon, n = 1": {"rate_exponent": 1.5}}}, ["cases.steel-silicon, n = 1.rate_exponent: 1.5: declare a case 'steel-silicon, n = 1.5' for it"]),
    ({"cases": {"steel-silicon, n = 1": {"law": "jkr"}}}, ["cases.steel-silicon, n = 1.law: 'jkr' has no n: declare a case of another name"]),
    ({"fig04_05_normal_experiments": {"populations": {"spores": {"from": "particles.Lycopodium"}}}}, ["fig04_05_normal_experiments.populations.spores.particle: 'lycopodium' must be stainless-steel-316, as of the case 'steel-silicon, n = 1'"]),
    ({"figures": {"formats": ["eps"]}}, ["figures.formats[0]: 'eps' must be 'svg', 'png' or 'pdf'"]),
    ({"figures": {"leave_out": ["fig99"]}}, ["figures.leave_out: 'fig99' is no figure (did you mean 'fig19'?)"]),
    ({"figures": {"scale": 0}}, ["figures.scale: 0 must be greater than 0"]),
    ({"figures": {"palette": ["blue"] * 7}}, ["figures.palette: 'blue': must be 7 colours or more, as '#0072b2'"]),
    ({"figures": {"palette": ["#0072b2"]}}, ["figures.palette: 1 of them: must be 7 colours or more, as '#0072b2'"]),
    ({"properties": {"materials": {"silicon": {"density": "dense"}}}}, ["properties.materials.silicon.density: 'dense': must be a number with its unit, as 2329 kg/m3"]),
    ({"properties": {"contacts": {"silicon": {"friction": 0.1}}}}, ["properties.contacts.silicon: 'silicon': must be particle and surface, as glass on silicon"]),
    ({"properties": {"metals": {}}}, ["properties.metals: unknown key (did you mean 'materials'?)"]),
    ({"impact": {"back": {"from": "surfaces.Formica"}}}, ["impact.back.surface: 'formica' must be silicon, as in front"]),
    ({"impact": {"case": {"from": "impact"}}}, ["impact.case.from: no case in impact"]),
    ({"pair_search": {"from": "particles.Lycopodium"}}, ["pair_search.particle: 'lycopodium' must be stainless-steel-316, as of the case 'steel-silicon, n = 1'"]),
    ({"fig06_12_oblique_experiments": {"series": {"spore on Formica": None}}}, ["fig06_12_oblique_experiments.compared_with_all: 'spore on Formica' must be one of"]),
    ({"fig17_coulomb_friction": {"friction": [0.1, 0.1]}}, ["fig17_coulomb_friction.friction: 0.1 is repeated"]),
    ({"surfaces": {"silicon front": {"surface_slope": 1.5}}}, ["surfaces.silicon front.surface_slope: 1.5 rad must be from -0.5 to 0.5 rad"]),
    ({"fig20_force_history": {"points": 10000000}}, ["fig20_force_history.points: 10000000 must be less than or equal to 100000"]),
    ({"seed": 10**44}, [f"seed: {10**44} must be less than {2**63}"]),
    ({"size_law": {"laws": ["JRK, viscous", "ring force"]}}, ["size_law.laws[0]: 'JRK, viscous' is not declared in inference.pairs.laws (did you mean 'JKR, viscous'?)"]),
    ({"claim_numbers": {"draws": {"scenarios": ["with v_c"]}}}, ["claim_numbers.draws.scenarios[0]: 'with v_c' is not declared in inference.pairs.scenarios"]),
    ({"pathvars": "build/x"}, ["pathvars: 'build/x' must be a mapping"]),
    ({"pathvars": {"results": ""}}, ["pathvars.results: '' must not be empty"]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("\ufeff# seen\r\n58.1\r\n60\r\n", ""),
        ("58.1\n6e-5\n", "diameter_um: 6e-05 um must be from 0.001 to 5000 um"),
        ("58,1\n", "diameter_um.path: sizes.txt, line 1: '58,1' must be one finite number"),
        ("", "diameter_um.path: sizes.txt: must hold at least one number, got none"),
    ],
)
def test_a_file_of_values(tmp_path, text, line):
    file = tmp_path / "sizes.txt"
    file.write_text(text, encoding="utf-8", newline="")
    sizes = {"kind": "sample_file", "path": str(file)}
    config = merged(shipped(), {"fig23_monte_carlo": {"process": {"diameter_um": sizes}}})
    if not line:
        validate(config, shipped())
        return
    with pytest.raises(ConfigError) as caught:
        validate(config, shipped())
    assert str(caught.value) == f"fig23_monte_carlo.process.{line.replace('sizes.txt', str(file))}"


@pytest.mark.parametrize(("overlay", "lines"), OVERLAYS, ids=range(len(OVERLAYS)))
def test_an_overlay_is_refused_in_a_line_a_key(overlay, lines):
    with pytest.raises(ConfigError) as caught:
        validate(merged(shipped(), overlay), shipped())
    found = str(caught.value).splitlines()
    assert len(found) == len(lines)
    for told, line in zip(found, lines, strict=True):
        assert told.startswith(line)


@pytest.mark.parametrize(
    ("table", "name", "rows", "told"),
    [
        (
            "materials",
            "silicon",
            {"density": 2329},
            "material 'silicon', density: unit '-' must be",
        ),
        (
            "materials",
            "gold",
            {"density": "19300 kg/m3"},
            "material 'gold': youngs_modulus, poissons",
        ),
        ("materials", "silicon", {"densty": "2 kg/m3"}, "property 'densty' unknown .did you mean"),
        ("contacts", "glas on silicon", {"friction": 0.1}, "unknown material 'glas' .did you mean"),
    ],
)
def test_a_given_property_is_refused_as_one_of_the_file(table, name, rows, told):
    settings = validate(merged(shipped(), {"properties": {table: {name: rows}}}), shipped())
    with pytest.raises(ValueError, match=f"config/{table}.csv and properties: .*{told}"):
        read_inputs(settings)


@pytest.mark.parametrize(("name", "content", "words"), BYTES, ids=range(len(BYTES)))
def test_a_file_that_is_none(declared, name, content, words):
    declared.write(name, content)
    with pytest.raises((ValueError, OSError)) as caught:
        declared.read()
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 3


def test_a_byte_order_mark_and_other_line_ends_do_no_harm(declared):
    for name in (CONFIG, MATERIALS, CONTACTS, COULOMB):
        text = (declared.root / "config" / name).read_text(encoding="utf-8")
        declared.write(name, b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    declared.write(POINTS, DIGITISED.replace("\n", "\r\n").encode())
    assert declared.read()[0].general.seed == 20011


def test_a_study_whose_branch_names_no_rows(declared):
    rows = declared.read()[0].rows["rolling_dissipation"]
    assert set(rows) == {"materials"}
    with pytest.raises(ValueError, match="no rows of 'printed': the study's branch must name some"):
        NamedTables({})["printed"]
