"""Memory of branches that were found valid, so that checking them again costs no imports.

Importing every study to check its branch takes a second or more. Whether a branch is valid
depends on its values and on the files behind its study alone; a hash of both is the key.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from microimpact.closure import source_files
from microimpact.files import write_file

CAPACITY = 500


class Memory:
    """Checked branches by key, kept in a JSON file.

    Parameters
    ----------
    path
        The file; one that is missing or damaged counts as empty.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known: dict[str, dict[str, Any]] = {}
        self._changed = False
        try:
            self._known = dict(json.loads(path.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            self._changed = True

    def recall(self, study: str, values: object) -> dict[str, Any] | None:
        """Return the checked values of a branch if just these were found valid before."""
        return self._known.get(_key(study, values))

    def keep(self, study: str, values: object, checked: Mapping[str, Any]) -> None:
        """Remember that the values of a branch are valid, and what they became."""
        self._known[_key(study, values)] = dict(checked)
        self._changed = True

    def save(self) -> None:
        """Write the file if there is something new, without the oldest entries."""
        if self._changed:
            latest = dict(list(self._known.items())[-CAPACITY:])
            write_file(self._path, json.dumps(latest))
            self._changed = False


def _key(study: str, values: object) -> str:
    text = json.dumps([study, values, version("pydantic"), _files(study)], default=repr)
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def _files(study: str) -> str:
    """Return a hash of everything that decides what a study accepts."""
    digest = hashlib.sha256()
    for file in source_files(f"microimpact.studies.{study}", "microimpact.config"):
        digest.update(Path(file).read_bytes())
        digest.update(b"\0")
    return digest.hexdigest()
