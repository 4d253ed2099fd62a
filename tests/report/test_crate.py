"""A crate of a finished run: what its profiles demand, and that it says nothing false."""

from __future__ import annotations

import json
import re
import shutil
from datetime import datetime
from pathlib import Path
from urllib.parse import unquote

import pytest
from rocrate.rocrate import ROCrate
from tests.report.results_roots import results, run
from tests.shared import ROOT, execute

from microimpact.report.check.results import ResultsError
from microimpact.report.crate import declared_inputs, write_crate

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
PROCESS_RUN = "https://w3id.org/ro/wfrun/process/0.5"
WORKFLOW_RUN = "https://w3id.org/ro/wfrun/workflow/0.5"
WORKFLOW = "https://w3id.org/workflowhub/workflow-ro-crate/1.0"
RO_CRATE = "https://w3id.org/ro/crate/1.1"


def write(root, files):
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return root


def finished(root, **changes):
    """A finished run with one figure, its tables, a log and a benchmark."""
    traces = {"logs/fig14.log": "", "benchmarks/fig14.tsv": "s\n1\n", "README.md": "results\n"}
    write(results(root), {**traces, "run.json": json.dumps({**STAMP, **changes})})
    return root


def as_list(value):
    return value if isinstance(value, list) else [value]


def ids(value):
    return [item["@id"] for item in as_list(value)]


def types(entity):
    return set(as_list(entity["@type"]))


def references(node):
    """Every `@id` that an entity refers to."""
    if isinstance(node, dict):
        return [node["@id"]] if set(node) == {"@id"} else references(list(node.values()))
    return (
        [found for child in node for found in references(child)] if isinstance(node, list) else []
    )


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder of a crate, and its entities by `@id`."""
    folder = tmp_path_factory.mktemp("crate")
    root = finished(folder / "results")
    found = write_crate(root, write(folder / "project", PROJECT))
    assert found == root / "ro-crate-metadata.json"
    graph = json.loads(found.read_text(encoding="utf-8"))["@graph"]
    return root, {entity["@id"]: entity for entity in graph}, graph


@pytest.fixture
def root(made):
    return made[0]


@pytest.fixture
def entities(made):
    return made[1]


@pytest.fixture
def action(entities):
    (found,) = (entity for entity in entities.values() if "CreateAction" in types(entity))
    return found


# RO-Crate 1.1


def test_ro_crate_descriptor_names_the_root_and_the_version(entities):
    descriptor = entities["ro-crate-metadata.json"]
    assert types(descriptor) == {"CreativeWork"}
    assert descriptor["about"] == {"@id": "./"}
    assert RO_CRATE in ids(descriptor["conformsTo"])


def test_ro_crate_graph_is_flat_with_types_and_unique_ids(made):
    _, entities, graph = made
    assert len(entities) == len(graph)
    assert all(types(entity) for entity in graph)


def test_ro_crate_root_is_described_dated_and_licensed(entities):
    root = entities["./"]
    assert types(root) == {"Dataset"}
    assert root["name"]
    assert root["description"]
    assert datetime.fromisoformat(root["datePublished"]) == datetime.fromisoformat(DATE)
    licence = entities[root["license"]["@id"]]
    assert licence["@id"] == "https://spdx.org/licenses/MIT"
    assert licence["name"] == "MIT License"
    assert entities["crate/LICENSE"]["encodingFormat"] == "text/plain"


def test_ro_crate_every_reference_leads_to_an_entity(entities):
    # Vocabulary of others: named by URI, not described here.
    outer = {RO_CRATE, *ids(entities["ro-crate-metadata.json"]["conformsTo"])}
    language = entities["https://w3id.org/workflowhub/workflow-ro-crate#snakemake"]
    outer |= set(references([language["url"], language["identifier"]]))
    found = {to for entity in entities.values() for to in references(list(entity.values()))}
    assert found - set(entities) <= outer


def test_ro_crate_every_file_is_there_and_part_of_the_root(root, entities):
    files = {name for name, entity in entities.items() if "File" in types(entity)}
    assert files == set(ids(entities["./"]["hasPart"]))
    for name in files:
        path = root / unquote(name)
        assert path.resolve().is_relative_to(root.resolve())
        assert path.is_file(), name
        assert re.fullmatch(r"[a-z]+/[a-z0-9.+-]+", entities[name]["encodingFormat"])
        assert entities[name]["name"]


# Workflow RO-Crate 1.0


def test_workflow_crate_main_entity_is_the_snakefile(entities):
    main = entities[entities["./"]["mainEntity"]["@id"]]
    assert main["@id"] == "crate/Snakefile"
    assert types(main) == {"File", "SoftwareSourceCode", "ComputationalWorkflow"}
    language = entities[main["programmingLanguage"]["@id"]]
    assert types(language) == {"ComputerLanguage"}
    assert language["name"] == "Snakemake"
    assert language["version"] == "9.27.1"
    assert WORKFLOW in ids(entities["ro-crate-metadata.json"]["conformsTo"])


def test_workflow_has_its_parts_and_the_versions_it_ran_with(entities):
    main = entities["crate/Snakefile"]
    assert set(ids(main["hasPart"])) == {
        "crate/workflow/rules/a.smk",
        "crate/workflow/scripts/run_study.py",
    }
    software = [entities[name] for name in ids(main["softwareRequirements"])]
    assert {item["name"]: item["softwareVersion"] for item in software} == {
        "microimpact": "0.1.0",
        "numpy": "2.4.6",
        "snakemake": "9.27.1",
    }


# Process Run Crate 0.5 and Workflow Run Crate 0.5


def test_run_crate_root_conforms_to_the_versioned_profiles(entities):
    assert set(ids(entities["./"]["conformsTo"])) == {PROCESS_RUN, WORKFLOW_RUN, WORKFLOW}
    for uri in (PROCESS_RUN, WORKFLOW_RUN, WORKFLOW):
        assert types(entities[uri]) == {"CreativeWork"}
        assert entities[uri]["version"] == uri.rsplit("/", 1)[1]


def test_run_crate_the_run_has_the_main_workflow_as_its_instrument(entities, action):
    assert action["instrument"] == entities["./"]["mainEntity"]
    assert action["@id"] in ids(entities["./"]["mentions"])
    assert action["name"]
    assert action["description"]


def test_run_crate_objects_are_the_declared_inputs_and_no_others(entities, action):
    assert ids(action["object"]) == [
        "crate/config/analyses/models.yaml",
        "crate/config/config.yaml",
        "crate/config/digitised/fig14.csv",
        "crate/config/laboratory.yaml",
        "crate/config/materials.csv",
    ]
    for name in ids(action["object"]):
        assert entities[name]["alternateName"] == name.removeprefix("crate/")
        assert entities[name]["encodingFormat"] in {"text/csv", "application/yaml"}


def test_run_crate_results_are_all_tables_data_and_figures(root, entities, action):
    there = {
        path.relative_to(root).as_posix()
        for folder in ("tables", "data", "figures")
        for path in (root / folder).iterdir()
    }
    assert set(ids(action["result"])) == there
    assert entities["figures/fig14.svg"]["encodingFormat"] == "image/svg+xml"
    assert entities["figures/fig14.png"]["encodingFormat"] == "image/png"
    assert entities["data/fig14.csv"]["encodingFormat"] == "text/csv"


def test_run_crate_logs_and_stamp_are_about_the_run_and_no_results(entities, action):
    for name in ("run.json", "logs/fig14.log", "benchmarks/fig14.tsv"):
        assert entities[name]["about"] == {"@id": action["@id"]}
        assert name not in ids(action["result"])


def test_run_crate_tells_what_the_stamp_knows_and_no_more(action):
    assert action["endTime"] == DATE
    assert action["startTime"] == STAMP["started"]
    assert "agent" not in action


# Beyond the profiles


def test_the_library_reads_the_crate_back(root):
    crate = ROCrate(root)
    assert crate.mainEntity.lang.name == "Snakemake"
    assert crate.version == "1.1"


def test_same_run_same_bytes_and_no_leftovers(tmp_path):
    written = []
    for name in ("a", "b"):
        root = finished(tmp_path / name)
        project = write(tmp_path / "project", PROJECT)
        written.append(write_crate(root, project).read_bytes())
    write(root, {"crate/config/gone.csv": "x\n"})
    assert write_crate(root, project).read_bytes() == written[0] == written[1]
    assert not (root / "crate/config/gone.csv").exists()


@pytest.mark.parametrize(
    ("git", "words"),
    [
        ({"commit": None, "dirty": None}, "no recorded commit"),
        ({"commit": "abc", "dirty": False}, "commit abc."),
        ({"commit": "abc", "dirty": True}, "commit abc with uncommitted changes"),
    ],
)
def test_the_commit_is_told_as_the_stamp_has_it(tmp_path, git, words):
    project = write(tmp_path / "project", PROJECT)
    text = write_crate(finished(tmp_path / "results", git=git), project).read_text()
    assert words in text


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
        ({"ended": "2026-01-02T03:04:05"}, "must have timezone"),
        ({"ended": None}, "the run has not ended well"),
        ({"outdated": ["data/fig14.csv"]}, "from other inputs: data/fig14.csv;"),
        ({"started": None}, "started: None must be a valid datetime"),
        ({"git": "abc"}, "git: 'abc' must be a mapping"),
        ({"packages": []}, "packages: [] must be a mapping"),
        ({"config": {"materials": "config/none.csv"}}, "materials: 'config/none.csv' must be"),
        ({"config": {"materials": "/etc/hostname"}}, "materials: '/etc/hostname' must be"),
    ],
)
def test_a_stamp_that_is_none_is_refused(tmp_path, change, words):
    project = write(tmp_path / "project", PROJECT)
    root = finished(tmp_path / "results", **change)
    with pytest.raises(ResultsError, match=re.escape(words)):
        write_crate(root, project)
    assert not (root / "crate").exists()
    assert not (root / "ro-crate-metadata.json").exists()


def test_the_command_writes_a_crate_or_says_in_one_line_why_not(tmp_path):
    project = write(tmp_path / "project", PROJECT)
    root = finished(tmp_path / "results")
    code, out, _ = run("crate", root, "--project", project)
    assert (code, out) == (0, f"Crate: {root / 'ro-crate-metadata.json'}\n")

    (root / "run.json").unlink()
    shutil.copytree(root / "logs", tmp_path / "empty")
    for folder, owner, words in (
        (root, project, "run.json: missing"),
        (tmp_path / "empty", project, "not a results folder"),
        (tmp_path / "nowhere", project, "no such folder"),
        (finished(tmp_path / "other"), tmp_path, "not the project: it has no Snakefile"),
    ):
        code, out, err = run("crate", folder, "--project", owner)
        assert (code, out) == (2, "")
        assert words in err
        assert err.count("\n") == 1


def test_the_project_s_own_declared_inputs_are_found():
    from microimpact.run.config import read_configuration

    project = ROOT
    found = declared_inputs(read_configuration(project / "config"), project)
    assert {Path("config/config.yaml"), Path("config/materials.csv")} <= set(found)
