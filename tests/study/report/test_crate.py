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
from study.report.crate import PROFILES, declared_inputs, write_crate

STAMP = {
    "started": "2026-01-02T02:00:00+00:00",
    "ended": "2026-01-02T03:04:05+00:00",
    "git": {"commit": None, "dirty": None},
    "packages": {"microimpact": "0.1.0", "numpy": "2.4.6", "snakemake": "9.27.1", "absent": None},
    "config": {"materials": "config/materials.csv", "digitised": "config/digitised", "seed": 1},
}
INPUTS = {
    "config/amendments.csv": "id\nC01\n",
    "config/analyses/pile_up.yaml": "pile_up: {}\n",
    "config/config.yaml": "seed: 1\n",
    "config/digitised/fig14.csv": "x,y\n1,2\n",
    "config/equations.yaml": "'1': {}\n",
    "config/laboratory.yaml": "particles: {}\n",
    "config/materials.csv": "material\nsteel\n",
}
PARTS = {"workflow/rules/a.smk": "", "workflow/scripts/run_study.py": ""}
PROJECT = {
    "Snakefile": 'include: "workflow/rules/a.smk"\n',
    "LICENSE": "MIT License\n\nCopyright\n",
    "config/unused.yaml": "seed: 2\n",
    "config/digitised/README.md": "points\n",
    **INPUTS,
    **PARTS,
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
def root(tmp_path_factory):
    """The folder of a crate."""
    folder = tmp_path_factory.mktemp("crate")
    return write_crate(finished(folder / "results"), write(folder / "project", PROJECT)).parent


@pytest.fixture(scope="module")
def entities(root):
    listed = json.loads((root / "ro-crate-metadata.json").read_text(encoding="utf-8"))["@graph"]
    by_id = {entity["@id"]: entity for entity in listed}
    assert len(by_id) == len(listed)
    return by_id


def test_the_crate_is_read_back_and_every_file_and_reference_is_there(root, entities):
    main = entities["./"]
    assert set(ids(main["conformsTo"])) == set(PROFILES)
    assert main["license"]["@id"] == "crate/LICENSE"
    crate = ROCrate(root)
    assert (crate.version, crate.mainEntity.lang.name) == ("1.1", "Snakemake")
    files = {name for name, entity in entities.items() if "File" in entity["@type"]}
    assert files == set(ids(main["hasPart"]))
    assert all((root / unquote(name)).is_file() for name in files)
    # Vocabulary of others: named by URI, not described here.
    language = entities["https://w3id.org/workflowhub/workflow-ro-crate#snakemake"]
    outer = {
        "https://w3id.org/ro/crate/1.1",
        *references([language["url"], language["identifier"]]),
    }
    outer |= set(ids(entities["ro-crate-metadata.json"]["conformsTo"]))
    named = {name for entity in entities.values() for name in references(list(entity.values()))}
    assert named - set(entities) <= outer


def test_the_run_leads_from_the_workflow_and_declared_inputs_to_all_results(root, entities):
    main = entities[entities["./"]["mainEntity"]["@id"]]
    assert main["@id"] == "crate/Snakefile"
    assert ids(main["hasPart"]) == [f"crate/{name}" for name in PARTS]
    (action,) = (entity for entity in entities.values() if entity["@type"] == "CreateAction")
    assert action["@id"] in ids(entities["./"]["mentions"])
    assert ids(action["instrument"]) == [main["@id"]]
    assert [entities[name]["name"] for name in ids(action["object"])] == list(INPUTS)
    made = (path for name in ("tables", "data", "figures") for path in (root / name).iterdir())
    assert set(ids(action["result"])) == {path.relative_to(root).as_posix() for path in made}
    assert (action["startTime"], action["endTime"]) == (STAMP["started"], STAMP["ended"])


def test_the_same_run_gives_the_same_bytes_and_no_leftovers(tmp_path):
    project = write(tmp_path / "project", PROJECT)
    written = [write_crate(finished(tmp_path / name), project).read_bytes() for name in "ab"]
    write(tmp_path / "b", {"crate/config/gone.csv": "x\n"})
    assert write_crate(tmp_path / "b", project).read_bytes() == written[0] == written[1]
    assert not (tmp_path / "b/crate/config/gone.csv").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"git": None}, "run.json: has no git"),
        ({"ended": None}, "the run has not ended well"),
        ({"config": {"materials": "/etc/hostname"}}, "materials: '/etc/hostname' must be"),
        ({"git": {"commit": "abc", "dirty": False}}, "is of commit abc, the project is at"),
    ],
)
def test_a_malformed_stamp_or_another_commit_is_refused(tmp_path, change, words):
    project = write(tmp_path / "project", PROJECT)
    identity = ("-c", "user.name=a", "-c", "user.email=a@b")
    for command in (("init", "-q"), ("add", "."), (*identity, "commit", "-q", "-m", "a")):
        execute("git", "-C", project, *command)
    root = finished(tmp_path / "results", **change)
    with pytest.raises(ResultsError, match=re.escape(words)):
        write_crate(root, project)
    assert not (root / "crate").exists()
    assert not (root / "ro-crate-metadata.json").exists()


def test_the_declared_inputs_of_the_project_are_complete():
    from study.run.config import read_configuration

    paths = declared_inputs(read_configuration(ROOT / "config"), ROOT)
    assert {"config/config.yaml", "config/materials.csv", "config/amendments.csv"} <= {*paths}
