"""A folder of declared inputs in which one text can be spoilt."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
import yaml
from tests.shared import ROOT, shipped

from study.run.config import read_configuration, read_inputs, validate

DIGITISED = """# source: made up
# licence: CC0-1.0
# digitised_by: nobody
series,x,y,y_low,y_high
a series,1.0,0.5,0.4,0.6
another,2.0,0.5,,
"""


# All files but one are as shipped: their text is parsed once. What cannot be read is not kept.
PARSED = cache(yaml.load)


class Declared:
    """A copy of the declared inputs."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def read(self):
        """Read all of it as a run does, from the folder that holds it."""
        before = Path.cwd()
        os.chdir(self.root)
        try:
            settings = validate(read_configuration("config"), shipped())
            return settings, read_inputs(settings)
        finally:
            os.chdir(before)

    def replace(self, name: str, old: str, new: str) -> None:
        """Replace the first occurrence of a text in a file."""
        file = self.root / "config" / name
        text = file.read_text(encoding="utf-8")
        assert old in text, f"{old!r} is not in {name}"
        file.write_text(text.replace(old, new, 1), encoding="utf-8")

    def write(self, name: str, content: str | bytes) -> None:
        """Write a whole file."""
        data = content.encode() if isinstance(content, str) else content
        (self.root / "config" / name).write_bytes(data)


@pytest.fixture
def declared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Declared]:
    monkeypatch.setattr(yaml, "load", PARSED)
    shutil.copytree(ROOT / "config", tmp_path / "config")
    (tmp_path / "config/digitised/fig14.csv").write_text(DIGITISED, encoding="utf-8")
    return Declared(tmp_path)
