"""The validator of the configuration: what it refuses, and in which words."""

from __future__ import annotations

import copy
from functools import cache

import jsonschema
import pytest
from tests.shared import ROOT, shipped

from study import analyses
from study.declared.documents import ConfigError, load
from study.declared.references import merged
from study.run.config import validate
from study.run.schema import schemas

BASE = shipped()


def changed(**branches):
    """Return the shipped configuration with keys of branches replaced."""
    config = copy.deepcopy(BASE)
    for name, keys in branches.items():
        if isinstance(keys, dict) and isinstance(config.get(name), dict):
            config[name].update(keys)
        else:
            config[name] = keys
    return config


def lines(config):
    with pytest.raises(ConfigError) as caught:
        validate(config, BASE)
    return str(caught.value).splitlines()


def test_shipped_configuration_is_valid_and_every_number_has_evidence_and_source():
    settings = validate(BASE, BASE)
    assert set(settings.branches) == set(analyses.homes())
    assert settings.declared
    for row in settings.declared:
        assert row.evidence != "user", row.key
        assert row.source, row.key


def test_given_properties_stand_beside_the_shipped_ones_or_replace_them():
    properties = {
        "materials": {"silicon": {"density": "2400 kg/m3"}},
        "contacts": {"glass on silicon": {"friction": 0.2}},
    }
    tables = validate(changed(properties=properties), BASE).tables
    shipped_tables = validate(BASE, BASE).tables
    assert len(tables.materials.rows) == len(shipped_tables.materials.rows)
    assert len(tables.contacts.rows) == len(shipped_tables.contacts.rows) + 1
    (density,) = set(tables.materials.text().splitlines()) - set(
        shipped_tables.materials.text().splitlines()
    )
    assert density.startswith("silicon,density,2400,kg/m3,,,user,")
    assert tables.pairs()["glass on silicon"]["friction"].value == 0.2


def test_an_analysis_has_a_file_of_its_name():
    files = (ROOT / "config/analyses").glob("*.yaml")
    assert {path.stem: list(load(path)) for path in files} == {n: [n] for n in analyses.homes()}


def test_values_are_plain_and_typed():
    branch = validate(BASE, BASE).branches["fig17_coulomb_friction"]
    assert branch["friction"] == [0.05, 0.10, 0.15, 0.20]
    assert isinstance(branch["points"], int)
    one = validate(changed(fig17_coulomb_friction={"restitution": 1}), BASE)
    assert isinstance(one.branches["fig17_coulomb_friction"]["restitution"], float)


def test_all_problems_are_listed():
    config = changed(
        fig17_coulomb_friction={
            "restitution": 2,
            "frictoin": 1,
            "points": {"valu": 1, "source": "x"},
        },
        fig14_restitution_trends={"points": "many"},
        sed=1,
        seed="many",
    )
    found = "\n".join(lines(config))
    for key in (
        "\nseed:",
        "restitution:",
        "frictoin:",
        "points.valu:",
        "fig14_restitution_trends.points:",
        "sed:",
    ):
        assert key in found


def test_a_missing_key_and_a_missing_branch_are_named():
    config = changed()
    del config["fig17_coulomb_friction"]["points"], config["fig14_restitution_trends"]
    assert lines(config) == [
        "fig14_restitution_trends: missing",
        "fig17_coulomb_friction.points: missing",
    ]


def declared(config, key):
    (row,) = (row for row in validate(config, BASE).declared if row.key == key)
    return row


def test_a_bare_number_and_a_changed_value_are_the_users():
    key = "fig17_coulomb_friction.spin_friction"
    assert declared(BASE, key).evidence == "printed"
    assert declared(changed(fig17_coulomb_friction={"spin_friction": 0.3}), key).evidence == "user"
    inside = copy.deepcopy(BASE)
    inside["fig17_coulomb_friction"]["spin_friction"]["value"] = 0.3
    assert declared(inside, key).evidence == "user"
    own = {"value": 0.3, "evidence": "assumed", "source": "mine"}
    assert declared(changed(fig17_coulomb_friction={"spin_friction": own}), key).source == "mine"


def test_a_parameter_follows_the_printed_value_that_it_names(tmp_path):
    path = tmp_path / "printed_values.csv"
    printed = (ROOT / "config/printed_values.csv").read_text(encoding="utf-8")
    path.write_text(printed.replace("force_history_diameter,4.9,", "force_history_diameter,2.58,"))
    settings = validate(BASE | {"printed_values": str(path)}, BASE)
    assert settings.branches["fig20_force_history"]["diameter_um"] == 2.58


@cache
def validator(name):
    schema = schemas()[f"{name}.schema.json"]
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_shipped_files_meet_the_schemas():
    validator("config").validate(BASE)
    validator("equations").validate(load(ROOT / "config/equations.yaml"))
    overlays = [ROOT / "config/ci.yaml", *(ROOT / "config/examples").glob("*.yaml")]
    assert len(overlays) > 3
    for path in overlays:
        validator("config").validate(load(path))
        validate(merged(BASE, load(path)), BASE)


@pytest.mark.parametrize(
    "overlay",
    [
        {"coulomb_frction": {}},
        {"fig17_coulomb_friction": {"restitution": 1.5}},
        {
            "fig17_coulomb_friction": {
                "restitution": {"value": 1.5, "evidence": "user", "source": "x"}
            }
        },
        {"fig23_monte_carlo": {"process": {"slope": {"kind": "normal", "sd": "steep"}}}},
        {"seed": "1"},
    ],
)
def test_a_schema_refuses_what_the_validator_refuses(overlay):
    assert not validator("config").is_valid(overlay)


def test_every_yaml_file_names_its_schema():
    names = set(schemas())
    for path in (ROOT / "config").rglob("*.yaml"):
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith("# yaml-language-server: $schema="), path
        schema = (path.parent / first.partition("=")[2]).resolve()
        assert schema.parent == ROOT / "workflow/schemas"
        assert schema.name in names
