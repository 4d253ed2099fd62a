"""A finished run as a Workflow Run RO-Crate: workflow, inputs, run and results, linked.

The results folder itself is the crate's root, so that no result is copied. A crate must contain
its data entities, and the workflow and its declared inputs lie outside of that folder; small as
they are (1 MB), they are copied to ``crate/`` below the root, each at its place in the project,
which its ``alternateName`` tells. The package is described by name and version: the commit has its
code.

Profiles: Workflow Run Crate 0.5, which extends Process Run Crate 0.5 and Workflow RO-Crate 1.0, on
RO-Crate 1.1. What the run stamp ``run.json`` does not know is left out: who ran the workflow
(``agent``). The run began when the workflow was read and ended when the last result was there; both
are the one date of a run under ``SOURCE_DATE_EPOCH``.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from importlib.metadata import metadata
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import AwareDatetime
from rocrate.model.contextentity import ContextEntity
from rocrate.rocrate import ROCrate

from microimpact.core.files import write_file
from study.report.check.results import (
    CLAIMS,
    TABLE_FOLDERS,
    ResultsError,
    built,
    read_json,
    require_results,
)
from study.report.site.ledgers import read_rows
from study.run.stamp import STAMP, git_state

METADATA = "ro-crate-metadata.json"
COPIES = "crate"
WORKFLOW = "Snakefile"
CONFIGURATION = ("config/config.yaml", "config/laboratory.yaml", "config/analyses")
# What a Snakefile includes, runs, checks by and reports with.
WORKFLOW_PARTS = ("rules/*.smk", "scripts/*.py", "report/*.rst")
RESULTS = (*TABLE_FOLDERS, "figures")
# Not results: what the engine and the jobs tell of the run.
TRACES = ("benchmarks", "logs")

PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": ("Process Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/workflow/0.5": ("Workflow Run Crate", "0.5"),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": ("Workflow RO-Crate", "1.0"),
}
RUN_TERMS = "https://w3id.org/ro/terms/workflow-run/context"

FORMATS = {
    ".csv": "text/csv",
    ".gz": "application/gzip",
    ".json": "application/json",
    ".md": "text/markdown",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".py": "text/x-python",
    ".svg": "image/svg+xml",
    ".tsv": "text/tab-separated-values",
    ".yaml": "application/yaml",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """Fields of a run stamp that a crate describes."""

    started: AwareDatetime
    ended: AwareDatetime  # When its last result was there
    git: dict[str, str | bool | None]  # Commit, None where it was no git checkout; and if dirty
    packages: dict[str, str | None]  # Versions; None for a package that was not there
    config: dict[str, Any]
    identifier: str  # Begin of the stamp's SHA-256: names this run

    @property
    def commit(self) -> str:
        """The commit of the project in words."""
        state = " with uncommitted changes" if self.git["dirty"] else ""
        return f"commit {self.git['commit']}{state}" if self.git["commit"] else "no recorded commit"


def write_crate(results: Path, project: Path) -> Path:
    """Describe a finished run as a Workflow Run RO-Crate, in its results folder.

    The same results and the same project give the same bytes.

    Parameters
    ----------
    results
        Results folder of a run: the root of the crate. Its subfolder ``crate`` is written anew.

    Raises
    ------
    ResultsError
        If the folder holds no finished run, or the project is not the one that was run.
    """
    require_results(results)
    run = read_run(results / STAMP)
    _require_same_project(run, project, results)
    inputs = declared_inputs(run.config, project)
    # Without metadata a crate that was not finished is none.
    (results / METADATA).unlink(missing_ok=True)
    shutil.rmtree(results / COPIES, ignore_errors=True)

    crate = ROCrate(version="1.1")
    crate.metadata.extra_contexts.append(RUN_TERMS)
    action = _add_entity(
        crate,
        f"#run-{run.identifier}",
        "CreateAction",
        name="Run of the microimpact study",
        description=(
            f"snakemake, project at {run.commit}. {STAMP} holds the merged configuration, "
            "with all that was changed by --configfile and --config."
        ),
        instrument=_add_workflow(crate, run, project),
        object=[_add_copy(crate, project, name) for name in inputs],
        result=[_add_file(crate, results, name) for name in _files(results, RESULTS)],
        startTime=run.started.isoformat(),
        endTime=run.ended.isoformat(),
        actionStatus="http://schema.org/CompletedActionStatus",
    )
    for name in (STAMP, *_files(results, TRACES)):
        _add_file(crate, results, name)["about"] = action
    if (results / "README.md").is_file():
        _add_file(crate, results, "README.md")["about"] = crate.root_dataset
    _describe_root(crate, run, project, [action, *_add_reviews(crate, results)])
    for entity in crate.data_entities:
        entity.write(results)
    text = json.dumps(crate.metadata.generate(), indent=4, sort_keys=True, ensure_ascii=False)
    write_file(results / METADATA, text)
    return results / METADATA


def read_run(path: Path) -> Run:
    """Read a run stamp.

    Raises ResultsError if it is missing, or naming the key that is not as a stamp has it.
    """
    if not path.is_file():
        raise ResultsError(f"{path}: missing; a run writes it when the last result is there")
    stamp = read_json(path)
    if stamp.get("ended", "") is None:
        raise ResultsError(f"{path}: the run has not ended well; finish it with `snakemake`")
    content = stamp | {"identifier": hashlib.sha256(path.read_bytes()).hexdigest()[:12]}
    return built(Run, {field.name: content.get(field.name) for field in fields(Run)}, str(path))


def _require_same_project(run: Run, project: Path, results: Path) -> None:
    for name in (WORKFLOW, "LICENSE"):
        if not (project / name).is_file():
            raise ResultsError(f"{project}: not the project: it has no {name}")
    # Copies of other files than those that ran would be a false record.
    recorded, present = run.git["commit"], git_state(project)["commit"]
    if recorded and present and recorded != present:
        raise ResultsError(
            f"{results / STAMP}: the run is of commit {recorded}, the project is at {present}: "
            "check that one out, or run again"
        )


def declared_inputs(config: Mapping[str, Any], project: Path) -> list[str]:
    """Return the declared input files of a run, relative to the project, sorted.

    These are the default configuration and the files that the merged one names at its top level; of
    a folder, the tables in it. Raises ResultsError, naming the key whose file is missing or outside
    of the project.
    """
    root = project.resolve()
    paths: set[Path] = set()
    shipped = {f"configfile {i}": name for i, name in enumerate(CONFIGURATION, 1)}
    for key, name in {**shipped, **config}.items():
        if not isinstance(name, str):
            continue
        path = (root / name).resolve()
        if not path.exists() or not path.is_relative_to(root):
            raise ResultsError(f"{key}: {name!r} must be a file or folder in {project}")
        paths.update(chain(path.glob("*.csv"), path.glob("*.yaml")) if path.is_dir() else [path])
    return sorted(path.relative_to(root).as_posix() for path in paths)


def _add_workflow(crate: Any, run: Run, project: Path) -> Any:
    """Add the Snakefile as the crate's main entity, with its parts and the software it needs."""
    workflow = crate.add_workflow(
        project / WORKFLOW,
        f"{COPIES}/{WORKFLOW}",
        main=True,
        lang="snakemake",
        lang_version=run.packages.get("snakemake"),
        properties={
            "name": "Workflow of the microimpact study",
            "alternateName": WORKFLOW,
            "description": f"Project at {run.commit}.",
            "encodingFormat": "text/plain",
        },
    )
    # By name and version, as in the lock files; where it is fetched from is the user's affair.
    software = {name: version for name, version in sorted(run.packages.items()) if version}
    if "microimpact" in software:
        workflow["version"] = software["microimpact"]
    paths = sorted(chain(*((project / "workflow").glob(part) for part in WORKFLOW_PARTS)))
    workflow["hasPart"] = [
        _add_copy(crate, project, path.relative_to(project).as_posix()) for path in paths
    ]
    workflow["softwareRequirements"] = [
        _add_entity(
            crate, f"#{name}-{version}", "SoftwareApplication", name=name, softwareVersion=version
        )
        for name, version in software.items()
    ]
    return workflow


def _add_reviews(crate: Any, results: Path) -> list[Any]:
    """Add a review of each claim, with its verdict as the rating."""
    rows = read_rows(results / CLAIMS)
    ratings = {
        verdict: _add_entity(
            crate, f"#{verdict.replace(' ', '-')}", "Rating", alternateName=verdict
        )
        for verdict in dict.fromkeys(row["verdict"] for row in rows)
    }
    return [
        _add_entity(
            crate,
            f"#{row['id']}",
            "ClaimReview",
            name=row["id"],
            claimReviewed=row["statement"],
            reviewRating=ratings[row["verdict"]],
            isBasedOn={"@id": CLAIMS},
        )
        for row in rows
    ]


def _describe_root(crate: Any, run: Run, project: Path, mentioned: list[Any]) -> None:
    about = metadata("microimpact")
    licence = about["License-Expression"]
    crate.name = "Results of the microimpact study"
    crate.description = about["Summary"]
    crate.datePublished = run.ended.isoformat()
    crate.license = _add_entity(
        crate,
        f"https://spdx.org/licenses/{licence}",
        "CreativeWork",
        name=(project / "LICENSE").read_text(encoding="utf-8").splitlines()[0],
        description=f"Full text in {COPIES}/LICENSE.",
        identifier=licence,
    )
    _add_copy(crate, project, "LICENSE")
    crate.root_dataset["mentions"] = mentioned
    crate.root_dataset["conformsTo"] = [
        _add_entity(crate, uri, "CreativeWork", name=name, version=version)
        for uri, (name, version) in PROFILES.items()
    ]


def _files(root: Path, folders: Iterable[str]) -> list[str]:
    """Return the files below folders of a root, relative to it."""
    paths = sorted(path for folder in folders for path in (root / folder).rglob("*"))
    visible = (path for path in paths if path.is_file() and not path.name.startswith("."))
    return [path.relative_to(root).as_posix() for path in visible]


def _add_file(crate: Any, root: Path, name: str, copy_to: str = "") -> Any:
    kind = FORMATS.get(Path(name).suffix, "text/plain")
    properties = {"name": name, "encodingFormat": kind}
    return crate.add_file(root / name, f"{copy_to}{name}", properties=properties)


def _add_copy(crate: Any, project: Path, name: str) -> Any:
    file = _add_file(crate, project, name, f"{COPIES}/")
    file["alternateName"] = name
    return file


def _add_entity(crate: Any, name_in_crate: str, kind: str, /, **properties: Any) -> Any:
    return crate.add(ContextEntity(crate, name_in_crate, properties={"@type": kind, **properties}))
