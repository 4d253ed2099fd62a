"""Files that speak to archives say the same as the package."""

from __future__ import annotations

import json
import tomllib

import yaml
from tests.shared import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_version_licence_and_description_are_the_package_s():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    codemeta = json.loads((ROOT / "codemeta.json").read_text())
    assert citation["version"] == codemeta["version"] == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]
    assert codemeta["license"].endswith(f"/{PROJECT['license']}")
    assert codemeta["description"] == PROJECT["description"]
