"""A crate of a finished run: the demands of its profiles, and nothing false."""

from __future__ import annotations

import json
import re
from urllib.parse import unquote

import pytest
from rocrate.rocrate import ROCrate
from tests.shared import ROOT, execute
from tests.study.report.results_roots import results, write

from study.report.check.results import ResultsError
from study.report.crate import declared_inputs, write_crate

DATE = "2026-01-02T03:04:05+00:00"
STAMP = {
    "started": "2026-01-02T02:00:00+00:00",
    "ended": DATE,
    "git": {"commit": None, "dirty": None},
    "packages": {"microimpact": "0.1.0", "numpy": "2.4.6", "snakemake": "9.27.1", "absent": None},
    "config": {"materials": "config/materials.csv", "digitised": "config/digitised", "seed": 1},
}
PROJECT = {
    "Snakefile": 'include: "workflow/rules/a.smk"\n',
    "LICENSE": "MIT License\n\nCopyright\n",
    "config/config.yaml": "seed: 1\n",
    "config/laboratory.yaml": "particles: {}\n",
    "config/analyses/models.yaml": "fig: {}\n",
    "config/unused.yaml": "seed: 2\n",
    "config/materials.csv": "material\nsteel\n",
    "config/digitised/fig14.csv": "x,y\n1,2\n",
    "config/digitised/README.md": "points\n",
    "workflow/rules/a.smk": "",
    "workflow/scripts/run_study.py": "",
}
RO_CRATE = "https://w3id.org/ro/crate/1.1"
WORKFLOW = "https://w3id.org/workflowhub/workflow-ro-crate/1.0"
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5",
    "https://w3id.org/ro/wfrun/workflow/0.5",
    WORKFLOW,
}


def finished(root, **changes):
    """A finished run with one figure, its tables, a log and a benchmark."""
    traces = {"logs/fig14.log": "", "benchmarks/fig14.tsv": "s\n1\n", "README.md": "results\n"}
    return write(results(root), {**traces, "run.json": json.dumps({**STAMP, **changes})})


def ids(value):
    return [item["@id"] for item in (value if isinstance(value, list) else [value])]


def references(node):
    """Every `@id` that an entity refers to."""
    if isinstance(node, dict):
        return [node["@id"]] if set(node) == {"@id"} else references(list(node.values()))
    return [name for child in node for name in references(child)] if isinstance(node, list) else []


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder of a crate, and its entities."""
    folder = tmp_path_factory.mktemp("crate")
    path = write_crate(finished(folder / "results"), write(folder / "project", PROJECT))
    assert path == folder / "results/ro-crate-metadata.json"
    return path.parent, json.loads(path.read_text(encoding="utf-8"))["@graph"]


@pytest.fixture
def root(made):
    return made[0]


@pytest.fixture
def entities(made):
    return {entity["@id"]: entity for entity in made[1]}


@pytest.fixture
def action(entities):
    (entity,) = (entity for entity in entities.values() if entity["@type"] == "CreateAction")
    return entity


def test_the_crate_names_its_profiles_and_is_read_back(root, entities):
    assert set(ids(entities["./"]["conformsTo"])) == PROFILES
    assert entities[entities["./"]["license"]["@id"]]["name"] == "MIT License"
    crate = ROCrate(root)
    assert (crate.version, crate.mainEntity.lang.name) == ("1.1", "Snakemake")


def test_ro_crate_ids_are_unique_and_every_reference_leads_to_an_entity(made, entities):
    assert len(entities) == len(made[1])
    # Vocabulary of others: named by URI, not described here.
    outer = {RO_CRATE, *ids(entities["ro-crate-metadata.json"]["conformsTo"])}
    language = entities["https://w3id.org/workflowhub/workflow-ro-crate#snakemake"]
    outer |= set(references([language["url"], language["identifier"]]))
    named = {name for entity in made[1] for name in references(list(entity.values()))}
    assert named - set(entities) <= outer


def test_ro_crate_every_file_is_there_and_part_of_the_root(root, entities):
    files = {name for name, entity in entities.items() if "File" in entity["@type"]}
    assert files == set(ids(entities["./"]["hasPart"]))
    assert all((root / unquote(name)).is_file() for name in files)


def test_workflow_crate_the_main_entity_is_the_snakefile_with_its_parts_and_software(entities):
    main = entities[entities["./"]["mainEntity"]["@id"]]
    assert main["@id"] == "crate/Snakefile"
    parts = {"crate/workflow/rules/a.smk", "crate/workflow/scripts/run_study.py"}
    assert set(ids(main["hasPart"])) == parts
    software = [entities[name] for name in ids(main["softwareRequirements"])]
    versions = {name: version for name, version in STAMP["packages"].items() if version}
    assert {item["name"]: item["softwareVersion"] for item in software} == versions


def test_run_crate_the_run_leads_from_declared_inputs_to_all_results(root, entities, action):
    assert action["instrument"] == entities["./"]["mainEntity"]
    assert action["@id"] in ids(entities["./"]["mentions"])
    inputs = ("config/analyses/models.yaml", "config/config.yaml", "config/digitised/fig14.csv")
    inputs += ("config/laboratory.yaml", "config/materials.csv")
    assert ids(action["object"]) == [f"crate/{name}" for name in inputs]
    assert {entities[f"crate/{name}"]["alternateName"] for name in inputs} == set(inputs)
    there = {
        path.relative_to(root).as_posix()
        for folder in ("tables", "data", "figures")
        for path in (root / folder).iterdir()
    }
    assert set(ids(action["result"])) == there
    assert (action["startTime"], action["endTime"]) == (STAMP["started"], DATE)


def test_every_claim_has_a_review_with_its_verdict(entities):
    review = entities["#C02"]
    assert (review["@type"], review["claimReviewed"]) == ("ClaimReview", "sticks")
    assert entities[review["reviewRating"]["@id"]]["alternateName"] == "not reproduced"
    assert review["isBasedOn"]["@id"] in entities
    assert {"#C01", "#C02"} <= set(ids(entities["./"]["mentions"]))


def test_the_same_run_gives_the_same_bytes_and_no_leftovers(tmp_path):
    project = write(tmp_path / "project", PROJECT)
    written = [write_crate(finished(tmp_path / name), project).read_bytes() for name in "ab"]
    write(tmp_path / "b", {"crate/config/gone.csv": "x\n"})
    assert write_crate(tmp_path / "b", project).read_bytes() == written[0] == written[1]
    assert not (tmp_path / "b/crate/config/gone.csv").exists()


def test_results_of_another_commit_are_refused(tmp_path):
    project = write(tmp_path / "project", PROJECT)
    identity = ("-c", "user.name=a", "-c", "user.email=a@b")
    for words in (("init", "-q"), ("add", "."), (*identity, "commit", "-q", "-m", "a")):
        execute("git", "-C", project, *words)
    root = finished(tmp_path / "results", git={"commit": "abc", "dirty": False})
    with pytest.raises(ResultsError, match="the run is of commit abc, the project is at"):
        write_crate(root, project)
    assert not (root / "crate").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"ended": "today"}, "ended: 'today' must be a valid datetime"),
        ({"ended": None}, "the run has not ended well"),
        ({"outdated": ["data/fig14.csv"]}, "from other inputs: data/fig14.csv;"),
        ({"config": {"materials": "/etc/hostname"}}, "materials: '/etc/hostname' must be"),
    ],
)
def test_a_malformed_stamp_is_refused(tmp_path, change, words):
    project = write(tmp_path / "project", PROJECT)
    root = finished(tmp_path / "results", **change)
    with pytest.raises(ResultsError, match=re.escape(words)):
        write_crate(root, project)
    assert not (root / "crate").exists()
    assert not (root / "ro-crate-metadata.json").exists()


def test_the_declared_inputs_of_the_project_are_complete():
    from study.run.config import read_configuration

    paths = {path.as_posix() for path in declared_inputs(read_configuration(ROOT / "config"), ROOT)}
    assert {"config/config.yaml", "config/materials.csv", "config/claims.yaml"} <= paths
