"""The site of a run: every page and file of ``report/``, from results and record."""

from __future__ import annotations

import csv
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from microimpact.core.files import write_file
from study.figures.declaration import FORMATS
from study.judge import words
from study.judge.counts import errors, revisions
from study.report.site import FOLDERS, PAGES, ledgers
from study.report.site.exports import claims_json, schema_json
from study.report.site.figures import (
    OTHER,
    SUBJECTS,
    Figure,
    departures,
    figures,
    label,
    studies_behind,
)
from study.report.site.formula import prose
from study.report.site.glossary import definitions
from study.report.site.pages import ASSETS, EXPLORER, NAVIGATION, render
from study.report.site.record import Record
from study.tables import text_rows

REPORT = "report"
# What is copied into the report, so that it can be moved and sent alone.
COPIED = {
    "figures": tuple(f"*.{kind}" for kind in FORMATS),
    "tables": ("*.csv",),
    "data": ("*.csv",),
}
# Folder of the packages, whose modules are copied where a figure, claim or equation names them.
SOURCES = Path(__file__).parents[3]
# Figures whose findings are at the head of the front page, that of the main picture first.
FIRST = ("capture_velocity_summary", "capture_laws", "rival_restitution")
# Claims that decide most of the article's argument.
FIRST_CLAIMS = frozenset(("C03", "C16", "C19", "C27", "C34", "C36", "C43", "C45", "C66"))

# Tables with rows of single claims.
PARTS_OF_CLAIMS = {
    "results": "results",
    "shares": "shares",
    "facts": "evidence",
    "amendments": "amendments",
}
# Tables that the page of claims shows below them.
BESIDE = ("rival_explanations", "capture_evidence", "rival_forces", "external_evidence")
# Tables that belong to no figure, and what they are about.
LEDGERS = "Inputs, claims and equations"
WORDS = {
    "inputs": "Every declared number with unit, evidence class and source.",
    "claims": "Every claim of the article, the numbers behind it and the verdict.",
    "claim_results": "Every number of every claim, its bounds, and whether it lies within them.",
    "claim_amendments": "Every change of a claim after it was first judged, with its reason.",
    "claim_draws": "Numbers of the claims for each drawn contact.",
    "claim_evidence": "Facts found by others that speak about a claim.",
    "claim_numbers": "Numbers of the claims as their functions return them.",
    "external_evidence": "Facts found by others, beside what the model gives.",
    "claim_shares": "Shares of the drawn contacts that meet each claim.",
    "equations": "Every equation as printed and as used, judged.",
    "errata": "Slips of the text outside its equations.",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """One table of the results as the page of tables shows it, with a sentence on it."""

    file: str
    words: str
    columns: tuple[str, ...]
    rows: int
    subject: str

    @property
    def name(self) -> str:
        """The name by which studies take it."""
        return self.file.rpartition("/")[2].removesuffix(".csv")


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


def _visible(folder: Path, pattern: str) -> list[Path]:
    return [path for path in sorted(folder.glob(pattern)) if not path.name.startswith(".")]


@cache
def code_module(function: str) -> Path | None:
    """Return the module of a function by its full name, relative to the packages; None, if none."""
    *parents, _ = function.split(".")
    for end in range(len(parents), 0, -1):
        stem = Path(*parents[:end])
        for module in (stem.with_suffix(".py"), stem / "__init__.py"):
            if (SOURCES / module).is_file():
                return module
    return None


def code_copy(function: str) -> str:
    """Return the address in the report of a copy of a function's module; empty without one."""
    module = code_module(function)
    return f"files/code/{module.with_suffix('.txt').as_posix()}" if module else ""


def site_pages(results: Path, record: Record) -> dict[str, str]:
    """Return the text of each page by its place in the report."""
    claims, equations, errata, declared = (
        text_rows(results / f"tables/{name}.csv")
        for name in ("claims", "equations", "errata", "inputs")
    )
    shown = figures(results, record, {"claims": claims, "equations": equations}, declared)
    by_name = {figure.name: figure for figure in shown}
    tables = _tables(results, shown)
    if not shown and not tables:
        raise ValueError(f"{results}: no figures and no tables to report on")
    explored = (results / REPORT / f"{EXPLORER}.html").is_file()
    evidence = Counter(row["evidence"] for row in declared)
    common: dict[str, Any] = {
        "record": record,
        "ledgers": ledgers,
        "claims": claims,
        "departures": {
            row["id"]: departures(declared, studies_behind(row, record)) for row in claims
        },
        "equations": equations,
        "beside": {name: text_rows(results / f"tables/{name}.csv") for name in BESIDE},
        "errata": errata,
        "revised": revisions(text_rows(results / "tables/claim_amendments.csv")),
        "claim_counts": ledgers.tally(claims, ledgers.CLAIM_VERDICTS),
        **{
            name: ledgers.by_claim(text_rows(results / f"tables/claim_{table}.csv"))
            for name, table in PARTS_OF_CLAIMS.items()
        },
        "words": words,
        "equation_errors": errors(equations),
        "equation_counts": ledgers.tally(equations, ledgers.EQUATION_VERDICTS),
        "shown": shown,
        "subjects": (*SUBJECTS, OTHER, LEDGERS),
        "first_claims": FIRST_CLAIMS,
        "first": [by_name[name] for name in FIRST if name in by_name] or shown[: len(FIRST)],
        "prose": prose,
        "code_copy": code_copy,
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
    parts = common["results"], common["shares"], common["amendments"]
    commit = str(record.git.get("commit") or "") or None
    functions = [name for row in claims for name in row["code"].split()]
    functions += [row["function"] for row in equations if row["function"]]
    functions += [name for figure in shown for name in (figure.drawing, figure.analysis)]
    return (
        pages
        | {
            "files/claims.json": claims_json(claims, *parts, commit),
            "files/claims.schema.json": schema_json(),
        }
        | _figure_pages(shown, common)
        | {
            code_copy(name): (SOURCES / module).read_text(encoding="utf-8")
            for name in functions
            if (module := code_module(name))
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


def _tables(results: Path, shown: Sequence[Figure]) -> list[Table]:
    words = {f"tables/{name}.csv": text for name, text in WORDS.items()}
    subjects: dict[str, str] = {}
    for figure in shown:
        words |= dict.fromkeys(figure.data, f"Data of {figure.label}: {figure.title}.")
        subjects |= dict.fromkeys((*figure.data, *figure.tables), figure.subject)
    words |= {file: text for figure in shown for file, text in figure.tables.items()}
    listed = []
    for folder in ("tables", "data"):
        for path in _visible(results / folder, "*.csv"):
            file = f"{folder}/{path.name}"
            with path.open(encoding="utf-8", newline="") as stream:
                lines = csv.reader(stream)
                columns = tuple(next(lines, ()))
                rows = sum(1 for _ in lines)
            said, about = words.get(file, ""), subjects.get(file, LEDGERS)
            listed.append(Table(file=file, words=said, columns=columns, rows=rows, subject=about))
    return listed
