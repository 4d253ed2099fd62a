"""Files that tell others how to cite, list and follow the project."""

from __future__ import annotations

import re
import tomllib

import yaml
from tests.shared import ROOT

from study.run.config import read_configuration

PACKAGE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
TEXT = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
CITATION = yaml.safe_load(TEXT)

# Citation File Format 1.2.0: keys of the root, of a person and of an entity (those of use here).
REQUIRED = {"cff-version", "message", "title", "authors"}
KNOWN = REQUIRED | {
    "abstract",
    "commit",
    "contact",
    "date-released",
    "doi",
    "identifiers",
    "keywords",
    "license",
    "license-url",
    "preferred-citation",
    "references",
    "repository",
    "repository-artifact",
    "repository-code",
    "type",
    "url",
    "version",
}
AUTHOR = {"family-names", "given-names", "name", "orcid", "affiliation", "website"}


def test_the_citation_has_what_its_format_requires_and_nothing_unknown():
    assert set(CITATION) >= REQUIRED
    assert set(CITATION) <= KNOWN
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] in {"software", "dataset"}
    assert all(isinstance(CITATION[key], str) and CITATION[key] for key in REQUIRED - {"authors"})
    assert len(set(CITATION["keywords"])) == len(CITATION["keywords"])


def test_every_author_is_a_person_or_an_entity_and_no_address_is_given():
    for authors in (CITATION["authors"], *(item["authors"] for item in CITATION["references"])):
        assert authors
        for author in authors:
            assert set(author) <= AUTHOR
            assert ("name" in author) != ("family-names" in author)
    assert "@" not in TEXT


def test_the_citation_is_of_this_package():
    assert CITATION["version"] == PACKAGE["version"]
    assert CITATION["license"] == PACKAGE["license"]
    assert CITATION["keywords"] == PACKAGE["keywords"]


def test_the_article_is_referred_to():
    (article,) = CITATION["references"]
    assert {"type", "title", "authors"} <= set(article)
    assert article["type"] == "article"
    assert [author["family-names"] for author in article["authors"]] == ["Brach", "Dunn", "Li"]
    assert (article["volume"], article["year"]) == (74, 2000)
    assert re.fullmatch(r"10\.\d{4,9}/\S+", article["doi"])


def test_the_catalogue_entry_has_its_form():
    path = ROOT / ".snakemake-workflow-catalog.yml"
    usage = yaml.safe_load(path.read_text(encoding="utf-8"))["usage"]
    assert set(usage) == {"mandatory-flags", "software-stack-deployment"}
    assert all(isinstance(usage["mandatory-flags"][key], str) for key in ("desc", "flags"))
    deployment = usage["software-stack-deployment"]
    assert set(deployment) == {"conda", "apptainer", "apptainer+conda", "report"}
    assert all(isinstance(flag, bool) for flag in deployment.values())
    # A method of deployment may be promised only where rules declare environments.
    rules = "".join(path.read_text("utf-8") for path in (ROOT / "workflow/rules").glob("*.smk"))
    assert deployment["conda"] == bool(re.search(r"^\s+conda:", rules, re.MULTILINE))


def test_the_catalogue_finds_what_standardised_usage_demands():
    # main workflow definition, how it is configured, and what to show of it
    for path in ("workflow/Snakefile", "config/README.md", ".snakemake-workflow-catalog.yml"):
        assert (ROOT / path).is_file()
    words = (ROOT / "README.md").read_text(encoding="utf-8").lower()
    assert "snakemake" in words
    assert "workflow" in words


def test_the_guide_to_the_configuration_names_every_key_and_every_file():
    text = (ROOT / "config/README.md").read_text(encoding="utf-8")
    for key in read_configuration(ROOT / "config"):
        assert f"`{key}`" in text
    files = [path for path in (ROOT / "config").iterdir() if path.name != "README.md"]
    for path in files:
        assert f"`{path.name}{'/' if path.is_dir() else ''}`" in text


def test_the_changelog_has_sections_of_the_agreed_names():
    lines = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "# Changelog"
    versions = [line for line in lines if line.startswith("## ")]
    assert versions[0] == "## [Unreleased]"
    assert all(re.fullmatch(r"## \[[\d.]+\] - \d{4}-\d\d-\d\d", line) for line in versions[1:])
    kinds = {line.removeprefix("### ") for line in lines if line.startswith("### ")}
    assert kinds
    assert kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
