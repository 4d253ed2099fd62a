"""Files that tell others how to cite, list and configure the project."""

from __future__ import annotations

import re
import tomllib

import yaml
from tests.shared import ROOT

from study import analyses
from study.run.config import read_configuration

PACKAGE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_citation_is_of_this_package_and_names_the_article():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    citation = yaml.safe_load(text)
    assert (citation["cff-version"], citation["type"]) == ("1.2.0", "software")
    assert all(citation[key] for key in ("message", "title", "authors"))
    for key in ("version", "license", "keywords"):
        assert citation[key] == PACKAGE[key]
    (article,) = citation["references"]
    assert [author["family-names"] for author in article["authors"]] == ["Brach", "Dunn", "Li"]
    assert (article["type"], article["volume"], article["year"]) == ("article", 74, 2000)
    assert re.fullmatch(r"10\.\d{4,9}/\S+", article["doi"])
    assert "@" not in text


def test_the_catalogue_entry_has_its_form():
    path = ROOT / ".snakemake-workflow-catalog.yml"
    usage = yaml.safe_load(path.read_text(encoding="utf-8"))["usage"]
    assert all(isinstance(usage["mandatory-flags"][key], str) for key in ("desc", "flags"))
    deployment = usage["software-stack-deployment"]
    assert set(deployment) == {"conda", "apptainer", "apptainer+conda"}
    assert usage["report"] is True
    # A method of deployment may be promised only where rules declare environments.
    rules = "".join(path.read_text("utf-8") for path in (ROOT / "workflow/rules").glob("*.smk"))
    assert deployment["conda"] == bool(re.search(r"^\s+conda:", rules, re.MULTILINE))
    assert (ROOT / "workflow/Snakefile").is_file()


def test_the_guide_to_the_configuration_names_every_key_and_every_file():
    text = (ROOT / "config/README.md").read_text(encoding="utf-8")
    files = [path for path in (ROOT / "config").iterdir() if path.name != "README.md"]
    names = [f"{path.name}{'/' if path.is_dir() else ''}" for path in files]
    shared = set(read_configuration(ROOT / "config")) - set(analyses.homes())
    assert not [name for name in (*shared, *names) if f"`{name}`" not in text]
