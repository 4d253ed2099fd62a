"""The stamp of a run: configuration, versions, commit and time.

A results folder holds results of one set of inputs. The folder that the shipped configuration names
is kept for the inputs of that file: an overlay that changes one names a folder of its own.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from microimpact.core.files import sha256, write_file
from study.declared.provenance import plain
from study.declared.references import FROM, is_reference

STAMP = "run.json"
NO_FILES: Mapping[str, str] = {}
# Other files, as an overlay in the clone, decide nothing of what is shipped.
DECIDING = ("Snakefile", "config", "requirements", "src", "workflow")
PACKAGES = (
    *("microimpact", "numpy", "scipy", "pandas"),
    *("matplotlib", "numba", "pydantic", "snakemake"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A key of the configuration that is not as shipped; None where there is none."""

    key: str
    shipped: Any
    used: Any


def changes(config: Mapping[str, Any], shipped: Mapping[str, Any]) -> tuple[Change, ...]:
    """Return the keys at which two configurations have different values.

    Evidence and source are not compared, and neither is the place of the results.
    """
    if config == shipped:
        return ()
    before, after = (dict(_leaves(plain(node))) for node in (shipped, config))
    return tuple(
        Change(key=key, shipped=before.get(key), used=after.get(key))
        for key in dict.fromkeys((*before, *after))
        if before.get(key) != after.get(key) and not key.startswith("pathvars")
    )


def _leaves(node: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    if is_reference(node) and {*node} & {"value", "values"}:
        yield key, node.get("value", node.get("values"))
    elif is_reference(node) and len(node) == 1:
        yield key, f"as {node[FROM]}"
    elif isinstance(node, Mapping):
        for name, child in node.items():
            yield from _leaves(child, f"{key}.{name}".removeprefix("."))
    elif isinstance(node, list) and any(isinstance(item, Mapping | list) for item in node):
        for i, item in enumerate(node):
            yield from _leaves(item, f"{key}[{i}]")
    else:
        yield key, node


def require_own_root(config: Mapping[str, Any], base: Mapping[str, Any]) -> None:
    """Refuse an overlay, merged into the base, that changes inputs but not the place of results.

    Raises ValueError, naming what is changed, and what to add.
    """
    changed = [change.key for change in changes(config, base)]
    if changed and results_root(config) == results_root(base):
        more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        raise ValueError(
            f"pathvars.results: the overlay changes {changed[0]}{more}, so its results need a "
            f"folder of their own, not {results_root(base)!r}; add to it a line as "
            "pathvars: {results: build/my-run}"
        )


def require_results_folder(folder: Path | str) -> None:
    """Refuse a place for results that holds something else.

    Raises ValueError unless `folder` is new, empty, or has the stamp of an earlier run.
    """
    folder = Path(folder)
    if folder.is_dir():
        # A run that was killed while it wrote its stamp leaves a part of it.
        others = [path for path in folder.iterdir() if not path.name.startswith(f".{STAMP}.")]
        is_usable = (folder / STAMP).is_file() or not others
    else:
        is_usable = not folder.exists() and not set(str(folder)) & set("{}<>~")
    if not is_usable:
        raise ValueError(
            f"pathvars.results: {str(folder)!r} must be a new or empty folder, without any of "
            f"{{ }} < > ~ in its name, or one of earlier results, with their {STAMP}"
        )


def results_root(config: Mapping[str, Any]) -> str:
    """Return where the results of a configuration go."""
    return str(Path(config.get("pathvars", {}).get("results", "results")))


def write_stamp(
    path: Path | str,
    config: Mapping[str, Any],
    project: Path | str,
    started: datetime,
    *,
    ended: datetime | None = None,
    files: Mapping[str, str] = NO_FILES,
) -> None:
    """Write the stamp of a run as JSON.

    Parameters
    ----------
    path
        File to write.
    config
        Merged configuration of the run.
    project
        Root of the project, whose commit is recorded.
    started
        Begin of the run, see `run_date`.
    ended
        End of a run that went well; None while it goes on, and after a failure.
    files
        Checksums of the declared files, see `checksums`.
    """
    stamp = {
        "started": started.isoformat(),
        "ended": ended and ended.isoformat(),
        **origin(config, project),
        "files": dict(files),
        "config": config,
    }
    write_file(path, json.dumps(stamp, indent=2, ensure_ascii=False, default=str) + "\n")


def checksums(places: Mapping[str, Path | str]) -> dict[str, str]:
    """Return the SHA-256 of declared files by their names; of a folder, of every file in it."""
    return {
        path.relative_to(Path(place).parent).as_posix(): sha256(path)
        for place in places.values()
        for path in (sorted(Path(place).iterdir()) if Path(place).is_dir() else [Path(place)])
        if path.is_file() and not path.name.startswith(".")
    }


def run_date() -> datetime:
    """Return the date of SOURCE_DATE_EPOCH, or the present one, in UTC to the second."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch:
        return datetime.fromtimestamp(int(epoch), UTC)
    return datetime.now(UTC).replace(microsecond=0)


def origin(config: Mapping[str, Any], project: Path | str) -> dict[str, Any]:
    """Return commit, seed, and the versions of all that decides numbers and pictures."""
    packages: dict[str, str | None] = dict.fromkeys(PACKAGES)
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            packages[name] = version(name)
    return {
        "git": git_state(Path(project)),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "packages": packages,
        "seed": plain(config.get("seed")),
    }


def git_state(project: Path) -> dict[str, str | bool | None]:
    """Return commit of a project, and whether a file that decides its results differs from it.

    Both are None if it is no git checkout.
    """

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(project), *arguments]
        return subprocess.check_output(
            command, stderr=subprocess.DEVNULL, text=True, timeout=30
        ).strip()

    with suppress(OSError, subprocess.SubprocessError):
        # A project copied into some other repository has no commit of its own.
        if Path(git("rev-parse", "--show-toplevel")).resolve() == project.resolve():
            dirty = bool(git("status", "--porcelain", "--", *DECIDING))
            return {"commit": git("rev-parse", "--verify", "HEAD"), "dirty": dirty}
    return {"commit": None, "dirty": None}
