"""The site of a run: every page and file of ``report/``, from results and record."""

from __future__ import annotations

import csv
import re
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile, ZipInfo

from microimpact.core.files import write_file
from study.figures.registry import FORMATS
from study.ledgers.claims import words
from study.ledgers.claims.words import in_words
from study.report.site import PAGES, code, ledgers
from study.report.site.chains import FILE as CHAINS
from study.report.site.chains import chains_json
from study.report.site.claims import FILE as CLAIMS_FILE
from study.report.site.claims import SCHEMA, claims_json, schema_json
from study.report.site.datapackage import FILE as DATAPACKAGE
from study.report.site.datapackage import datapackage
from study.report.site.figures import (
    CLAIM_STUDY,
    Figure,
    departures,
    figures,
    label,
    studies_behind,
)
from study.report.site.formula import prose
from study.report.site.glossary import definitions
from study.report.site.graph import needs
from study.report.site.ledgers import read_rows
from study.report.site.pages import ASSETS, EXPLORER, NAVIGATION, render
from study.report.site.record import Record, Rule

REPORT = "report"
# Folders of the report that belong to the site alone: made anew each time.
FOLDERS = ("code", "figures", "files")
# What is copied into the report, so that it can be moved and sent alone.
COPIED = {
    "figures": tuple(f"*.{kind}" for kind in FORMATS),
    "tables": ("*.csv",),
    "data": ("*.csv",),
}
ARCHIVE = "files/figures.zip"
# Figures whose findings are at the head of the front page, that of the main picture first.
FIRST = ("evidence", "capture_laws", "rival_restitution")
# Claims that decide most of the article's argument.
FIRST_CLAIMS = frozenset(("C03", "C09", "C16", "C19", "C27", "C34", "C36", "C43", "C45", "C66"))

# Tables with rows of single claims.
PARTS_OF_CLAIMS = {
    "results": "results",
    "shares": "shares",
    "facts": "evidence",
    "amendments": "amendments",
}
# Tables that the page of claims shows below them.
BESIDE = ("rival_explanations", "capture_evidence", "rival_forces", "external_evidence")
# In the words of a rule: a table, then what it holds.
_TOLD = re.compile(r"((?:tables|data)/\w+\.csv): ([^;]+?)(?:[;.] |\.?$)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """One table of the results as the page of tables shows it, with a sentence on it."""

    file: str
    words: str
    columns: tuple[str, ...]
    rows: int
    maker: Rule | None

    @property
    def name(self) -> str:
        """The name by which studies take it."""
        return self.file.rpartition("/")[2].removesuffix(".csv")

    @property
    def folder(self) -> str:
        """The folder of the results that contains it."""
        return self.file.partition("/")[0]


def write_site(results: Path, record: Record) -> list[Path]:
    """Write the site of a run to ``report/`` in its results folder.

    The same results and record give the same bytes. Files of others in ``report/`` stay.

    Parameters
    ----------
    results
        Results folder.
    record
        What is known of the run.

    Raises
    ------
    ValueError
        If there is nothing to show.
    """
    pages = site_pages(results, record)
    report = results / REPORT
    for folder in FOLDERS:
        shutil.rmtree(report / folder, ignore_errors=True)
    for source, target in _copies(results):
        write_file(report / target, source.read_bytes())
    write_file(report / ARCHIVE, _archive(results))
    for name, text in pages.items():
        write_file(report / name, text)
    return [report / name for name in pages]


def _copies(results: Path) -> list[tuple[Path, str]]:
    return [(path, f"assets/{path.name}") for path in sorted(ASSETS.iterdir())] + [
        (path, f"files/{folder}/{path.name}")
        for folder, patterns in COPIED.items()
        for pattern in patterns
        for path in _visible(results / folder, pattern)
    ]


def _archive(results: Path) -> bytes:
    """Return all figures in one archive: not compressed, so that its bytes hang on them alone."""
    stream = BytesIO()
    with ZipFile(stream, "w") as archive:
        for pattern in COPIED["figures"]:
            for path in _visible(results / "figures", pattern):
                archive.writestr(ZipInfo(f"figures/{path.name}"), path.read_bytes())
    return stream.getvalue()


def _visible(folder: Path, pattern: str) -> list[Path]:
    return [path for path in sorted(folder.glob(pattern)) if not path.name.startswith(".")]


def site_pages(results: Path, record: Record) -> dict[str, str]:
    """Return the text of each page by its place in the report."""
    claims, equations, errata, declared = (
        read_rows(results / f"tables/{name}.csv")
        for name in ("claims", "equations", "errata", "inputs")
    )
    shown = figures(results, record, {"claims": claims, "equations": equations}, declared)
    by_name = {figure.name: figure for figure in shown}
    tables = _tables(results, record, shown)
    if not shown and not tables:
        raise ValueError(f"{results}: no figures and no tables to report on")
    explored = (results / REPORT / f"{EXPLORER}.html").is_file()
    evidence = Counter(row["evidence"] for row in declared)
    needed = needs(record.rules) | {CLAIM_STUDY: ()}
    common: dict[str, Any] = {
        "record": record,
        "ledgers": ledgers,
        "claims": claims,
        "departures": {
            row["id"]: departures(declared, studies_behind(row, record), needed) for row in claims
        },
        "equations": equations,
        "beside": {name: read_rows(results / f"tables/{name}.csv") for name in BESIDE},
        "errata": errata,
        "claim_counts": ledgers.counts(ledgers.counted(claims), ledgers.CLAIM_VERDICTS),
        **{
            name: ledgers.by_claim(read_rows(results / f"tables/claim_{table}.csv"))
            for name, table in PARTS_OF_CLAIMS.items()
        },
        "words": words,
        "equation_counts": ledgers.counts(equations, ledgers.EQUATION_VERDICTS),
        "shown": shown,
        "first_claims": FIRST_CLAIMS,
        "first": [by_name[name] for name in FIRST if name in by_name] or shown[: len(FIRST)],
        "place": code.place,
        "prose": prose,
        "in_words": in_words,
        "names": {figure.name for figure in shown},
        "label": label,
        "evidence": sorted(evidence.items(), key=lambda item: (-item[1], item[0])),
        "tables": tables,
        # No link to an explorer that was not written.
        "navigation": [e for e in NAVIGATION if explored or e[0] != EXPLORER],
        "explored": explored,
        "definitions": definitions(),
    }
    wide = {"index", "figures", "claims", "equations", "tables"}
    pages = {
        f"{name}.html": render(f"{name}.html", **common, here=name, wide=name in wide)
        for name in PAGES
    }
    named = [name for row in claims for name in row["code"].split()]
    named += [row["function"] for row in equations]
    named += [name for figure in shown for name in figure.code.values()]
    parts = common["results"], common["shares"], common["amendments"]
    commit = str(record.git.get("commit") or "") or None
    return (
        pages
        | {DATAPACKAGE: datapackage(results, tables)}
        | {CLAIMS_FILE: claims_json(claims, *parts, commit), SCHEMA: schema_json()}
        | {CHAINS: chains_json((row for row in claims if row["id"] in FIRST_CLAIMS), commit)}
        | _figure_pages(shown, common)
        | {
            f"{code.FOLDER}/{module.name}.html": render(
                "code.html", **common, module=module, root="../"
            )
            for module in code.modules(named)
        }
    )


def _figure_pages(shown: Sequence[Figure], common: Mapping[str, Any]) -> dict[str, str]:
    before, after = [None, *shown[:-1]], [*shown[1:], None]
    return {
        f"figures/{figure.name}.html": render(
            "figure.html",
            **common,
            figure=figure,
            previous=previous,
            following=following,
            here="figures",
            root="../",
        )
        for previous, figure, following in zip(before, shown, after, strict=True)
    }


def _tables(results: Path, record: Record, shown: Sequence[Figure]) -> list[Table]:
    makers = {file: rule for rule in record.rules for file in rule.outputs}
    words = _words(record, shown)
    listed = []
    for folder in ("tables", "data"):
        for path in _visible(results / folder, "*.csv"):
            file = f"{folder}/{path.name}"
            with path.open(encoding="utf-8", newline="") as stream:
                lines = csv.reader(stream)
                columns = tuple(next(lines, ()))
                rows = sum(1 for _ in lines)
            listed.append(
                Table(
                    file=file,
                    words=words.get(file, ""),
                    columns=columns,
                    rows=rows,
                    maker=makers.get(file),
                )
            )
    return listed


def _words(record: Record, shown: Sequence[Figure]) -> dict[str, str]:
    """Return a sentence on each table: of the rule that makes it, or of its figure."""
    sentences = {
        file: f"{words[:1].upper()}{words[1:]}."
        for rule in record.rules
        for file, words in _TOLD.findall(rule.purpose)
    }
    drawn = {
        file: f"Data of {figure.label}: {figure.title}." for figure in shown for file in figure.data
    }
    return sentences | drawn | {file: words for f in shown for file, words in f.tables.items()}
