"""The last configuration that was found valid, so that only a changed one is checked.

Checking takes the parameters of all studies, and loading all studies takes a third of a run that
finds nothing to do. What is kept counts as long as all that decides is the same: both
configurations and every line of the package. It can be deleted at any time.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from microimpact.core.files import write_file
from microimpact.declared.provenance import Declared
from microimpact.run.config import General, Pathvars, Settings, validate

PACKAGE = Path(__file__).parents[1]


def validated(config: Mapping[str, Any], base: Mapping[str, Any], path: Path) -> Settings:
    """Check a merged configuration as `run.config.validate` does, or remember that it was.

    Parameters
    ----------
    config, base
        The merged configuration, and the one as shipped.
    path
        Where the last valid one is kept; a file that cannot be read or written is no error.

    Raises
    ------
    ConfigError
        Naming the dotted key of every problem, one line each.
    """
    decides = _fingerprint(config, base)
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        if kept["decided by"] == decides:
            return _settings(kept["settings"])
    except (OSError, ValueError, TypeError, KeyError):
        pass
    settings = validate(config, base)
    with suppress(OSError, TypeError):  # nowhere to write, or a value that JSON does not know
        write_file(path, json.dumps({"decided by": decides, "settings": asdict(settings)}))
    return settings


def _fingerprint(config: Mapping[str, Any], base: Mapping[str, Any]) -> str:
    """Return a name that changes with anything that could change the verdict or the values."""
    # Not as JSON, in which the keys 1 and "1" are the same.
    told = hashlib.sha256(repr((config, base, sys.version, version("pydantic"))).encode())
    for source in sorted(PACKAGE.rglob("*.py")):
        told.update(f"\n{source.relative_to(PACKAGE)}\n".encode() + source.read_bytes())
    return told.hexdigest()


def _settings(kept: dict[str, Any]) -> Settings:
    general = kept["general"] | {"pathvars": Pathvars(**kept["general"]["pathvars"])}
    return Settings(
        general=General(**general),
        branches=kept["branches"],
        declared=tuple(Declared(**each) for each in kept["declared"]),
    )
