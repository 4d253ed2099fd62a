"""A finished run as a Workflow Run RO-Crate: workflow, inputs, run and results, linked.

The results folder itself is the crate's root, so that no result is copied. The workflow and its
declared inputs lie outside of it; small as they are (1 MB), they are copied to ``crate/`` below the
root, each at its place in the project. Versions, seed and configuration are in the run stamp
``run.json``. Profiles: Workflow Run Crate 0.5, which extends Process Run Crate 0.5 and Workflow
RO-Crate 1.0, on RO-Crate 1.1.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from importlib.metadata import metadata
from pathlib import Path
from typing import Any

from rocrate.model.contextentity import ContextEntity
from rocrate.rocrate import ROCrate

from microimpact.core.files import write_file
from study.report.check import results as run_results
from study.report.check.results import TABLE_FOLDERS, ResultsError
from study.run.stamp import STAMP, git_state

METADATA = "ro-crate-metadata.json"
COPIES = "crate"
WORKFLOW = "Snakefile"
CONFIGURATION = (
    "config/config.yaml",
    "config/laboratory.yaml",
    "config/analyses",
    "config/equations.yaml",
    "config/amendments.csv",
)
WORKFLOW_PARTS = ("workflow/rules/*.smk", "workflow/scripts/*.py", "workflow/report/*.rst")
# Results, and what the engine and the jobs tell of the run.
RESULTS, TRACES = (*TABLE_FOLDERS, "figures"), ("benchmarks", "logs")
PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": ("Process Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/workflow/0.5": ("Workflow Run Crate", "0.5"),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": ("Workflow RO-Crate", "1.0"),
}
RUN_TERMS = "https://w3id.org/ro/terms/workflow-run/context"
FORMATS = {".csv": "text/csv", ".json": "application/json", ".pdf": "application/pdf"}
FORMATS |= {".png": "image/png", ".svg": "image/svg+xml", ".yaml": "application/yaml"}


def write_crate(results: Path, project: Path) -> Path:
    """Describe a finished run as a Workflow Run RO-Crate, in its results folder.

    The same results and the same project give the same bytes. The subfolder ``crate`` is written
    anew. Raises ResultsError if the folder holds no finished run, or the project is not the one
    that was run.
    """
    run_results.require_results(results)
    made = _files(results, *(f"{folder}/**/*" for folder in RESULTS))
    stamp = _finished(results / STAMP, project)
    inputs = declared_inputs(stamp["config"], project)
    # Without metadata a crate that was not finished is none.
    (results / METADATA).unlink(missing_ok=True)
    shutil.rmtree(results / COPIES, ignore_errors=True)

    crate = ROCrate(version="1.1")
    crate.metadata.extra_contexts.append(RUN_TERMS)
    workflow = crate.add_workflow(
        project / WORKFLOW,
        f"{COPIES}/{WORKFLOW}",
        main=True,
        lang="snakemake",
        lang_version=stamp.get("packages", {}).get("snakemake"),
        properties={"name": "Workflow of the microimpact study"},
    )
    workflow["hasPart"] = [
        _add(crate, project, n, COPIES) for n in _files(project, *WORKFLOW_PARTS)
    ]
    action = _entity(
        crate,
        "#run",
        "CreateAction",
        name="Run of the microimpact study",
        description=f"Project at commit {stamp['git'].get('commit')}; {STAMP} has all else.",
        instrument=workflow,
        object=[_add(crate, project, name, COPIES) for name in inputs],
        result=[_add(crate, results, name) for name in made],
        startTime=stamp["started"],
        endTime=stamp["ended"],
        actionStatus="http://schema.org/CompletedActionStatus",
    )
    for name in _files(results, STAMP, *(f"{folder}/**/*" for folder in TRACES)):
        _add(crate, results, name)["about"] = action
    about, licence = metadata("microimpact"), _add(crate, project, "LICENSE", COPIES)
    crate.name, crate.description = "Results of the microimpact study", about["Summary"]
    crate.datePublished, crate.license = stamp["ended"], licence
    crate.root_dataset["mentions"] = [action]
    crate.root_dataset["conformsTo"] = [
        _entity(crate, uri, "CreativeWork", name=name, version=version)
        for uri, (name, version) in PROFILES.items()
    ]
    for entity in crate.data_entities:
        entity.write(results)
    text = json.dumps(crate.metadata.generate(), indent=4, sort_keys=True, ensure_ascii=False)
    write_file(results / METADATA, text)
    return results / METADATA


def _finished(path: Path, project: Path) -> dict[str, Any]:
    """Return the stamp of a run that has ended well, of the commit at which the project is."""
    if not path.is_file():
        raise ResultsError(f"{path}: missing; a run writes it when the last result is there")
    stamp = run_results.read_json(path)
    if lacking := [name for name in ("started", "git", "config") if not stamp.get(name)]:
        raise ResultsError(f"{path}: has no {', '.join(lacking)}")
    if not stamp.get("ended"):
        raise ResultsError(f"{path}: the run has not ended well; finish it with `snakemake`")
    recorded, present = stamp["git"].get("commit"), git_state(project)["commit"]
    if recorded and present and recorded != present:
        raise ResultsError(f"{path}: the run is of commit {recorded}, the project is at {present}")
    return stamp


def declared_inputs(config: Mapping[str, Any], project: Path) -> list[str]:
    """Return the declared input files of a run, relative to the project, sorted.

    The default configuration, and what the merged one names at its top level; of a folder the
    tables in it. Raises ResultsError, naming the key of a file that is not in the project.
    """
    root, names = project.resolve(), list[str]()
    for key, name in {**dict(zip(CONFIGURATION, CONFIGURATION, strict=True)), **config}.items():
        if not isinstance(name, str):
            continue
        path = (root / name).resolve()
        if not path.exists() or not path.is_relative_to(root):
            raise ResultsError(f"{key}: {name!r} must be a file or folder in {project}")
        names += [f"{name}/*.csv", f"{name}/*.yaml"] if path.is_dir() else [name]
    return _files(root, *names)


def _files(root: Path, *patterns: str) -> list[str]:
    """Return the files below a root that match patterns, relative to it, sorted."""
    files = {path for pattern in patterns for path in root.glob(pattern) if path.is_file()}
    return sorted(p.relative_to(root).as_posix() for p in files if not p.name.startswith("."))


def _add(crate: Any, root: Path, name: str, folder: str = "") -> Any:
    kind = FORMATS.get(Path(name).suffix, "text/plain")
    properties = {"name": name, "encodingFormat": kind}
    return crate.add_file(root / name, f"{folder}/{name}".lstrip("/"), properties=properties)


def _entity(crate: Any, identity: str, kind: str, **properties: Any) -> Any:
    return crate.add(ContextEntity(crate, identity, properties={"@type": kind, **properties}))
