"""Pages of the documentation whose numbers come from a full run, and the tables behind them.

The tables that the pages read are kept in the repository: a test renders the pages from them. The
page of deviations from the article takes all words and numbers from the two ledgers and the file of
claims.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import jinja2
import yaml

from microimpact.core.files import write_file
from study.figures.declaration import all_figures
from study.judge import amendments, counts
from study.judge.criteria import declared_claims
from study.judge.words import agreement, readable, with_unit
from study.report.site.figures import label
from study.report.site.ledgers import by_claim
from study.report.site.pages import render
from study.report.site.record import read_record
from study.tables import ResultTables, TableError, text_rows

DEVIATIONS, SUFFIX = "deviations.md", ".jinja"
# Tables of the page of deviations and of the counts in the README.
LEDGERS = ("claims", "equations", "claim_evidence", "claim_results")
CODECHECK = "../codecheck.yml"
README = {"readme.md": "../README.md"}
ABOUT = "<!-- Made by `make pages` from {template} and tables of a full run; do not edit. -->\n\n"


class PageError(ValueError):
    """A template that asks for a number that no table contains."""


def _fixed(value: float, digits: int) -> str:
    """Return a number with `digits` after the point, and a true minus sign."""
    text = f"{value:.{digits}f}"
    text = text.removeprefix("-") if float(text) == 0.0 else text
    return text.replace("-", "−")


def _percent(value: float, digits: int = 0) -> str:
    return f"{_fixed(100.0 * value, digits)} %"


_ENVIRONMENT = jinja2.Environment(
    undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False
)
_ENVIRONMENT.filters |= {"fixed": _fixed, "percent": _percent}


def pages(results: Path, docs: Path) -> tuple[dict[str, str], tuple[str, ...]]:
    """Return the text of each page by its name, and the names of the tables read.

    Parameters
    ----------
    results
        Folder with ``tables`` of a full run.
    docs
        Folder of the templates.

    Raises
    ------
    PageError
        If a table, column or row is missing.
    """
    table = ResultTables(results)
    environment = _ENVIRONMENT.overlay()
    ledgers = {name: text_rows(results / f"tables/{name}.csv") for name in ("claims", "equations")}
    environment.globals = {
        **_ENVIRONMENT.globals,
        **ledgers,
        "table": table,
        "counts": counts,
        "amendments": amendments(),
        "figures": all_figures(),
    }
    texts = {
        DEVIATIONS: deviations(results),
        CODECHECK: codecheck(all_figures()),
    }
    for template in sorted(docs.glob(f"*{SUFFIX}")):
        text = template.read_text(encoding="utf-8")
        try:
            body = environment.from_string(text).render()
        except (TableError, jinja2.TemplateError) as error:
            raise PageError(f"{template}: {error}") from None
        name = template.name.removesuffix(SUFFIX)
        texts[README.get(name, name)] = ABOUT.format(template=template.name) + body
    # The pages of figures read these, and a test has them say all of it.
    for figure in all_figures().values():
        figure.compared(table)
    return texts, tuple(sorted({*LEDGERS, *table.read}))


def codecheck(figures: Iterable[str]) -> str:
    """Return the outputs that a person who repeats the run compares (CODECHECK, version 1)."""
    manifest = [
        {"file": f"results/figures/{name}.svg", "comment": label(name)} for name in sorted(figures)
    ]
    manifest.append({"file": "results/tables/claims.csv", "comment": "Verdicts on the article"})
    about = {
        "version": "https://codecheck.org.uk/spec/config/1.0/",
        "source": "make reproduce",
        "paper": {
            "title": "Experiments and Engineering Models of Microparticle Impact and Deposition",
            "authors": [{"name": name} for name in ("R. M. Brach", "P. F. Dunn", "X. Li")],
            "reference": "https://doi.org/10.1080/00218460008034531",
        },
        "manifest": manifest,
        "codechecker": [],
        "summary": "",
        "repository": "",
        "report": "",
    }
    return yaml.safe_dump(about, sort_keys=False, allow_unicode=True, width=100)


def deviations(results: Path) -> str:
    """Return the page of corrections, failed reproductions and changes, in Markdown.

    Parameters
    ----------
    results
        Folder with the tables `LEDGERS`.

    Raises
    ------
    ValueError
        If the table and the file do not hold the same claims.
    """
    claims, equations, facts = (
        text_rows(results / f"tables/{name}.csv")
        for name in ("claims", "equations", "claim_evidence")
    )
    declared = declared_claims()
    if strangers := {row["id"] for row in claims} ^ set(declared):
        raise ValueError(
            f"{results / 'tables/claims.csv'} and the code do not hold the same claims:"
            f" {', '.join(sorted(strangers))} in one of them only; run the study again"
        )
    page = render(
        f"{DEVIATIONS}{SUFFIX}",
        templates=Path(__file__).parent,
        counts=counts,
        equations=equations,
        claims=claims,
        declared=declared,
        amendments=amendments(),
        evidence=by_claim(facts),
        agreement=agreement,
        readable=readable,
        with_unit=with_unit,
    )
    return page.rstrip() + "\n"


def renew(results: Path, docs: Path, kept: Path) -> list[Path]:
    """Write the pages, and keep the tables that they read; return the files that changed.

    Raises PageError if the run is not one of the shipped configuration, or lacks a number.
    """
    _require_full(results, kept)
    texts, names = pages(results, docs)
    wanted = {docs / name: text.encode() for name, text in texts.items()}
    # Data of figures are large; the references of the small run have them.
    tables = [name for name in names if (results / f"tables/{name}.csv").is_file()]
    wanted |= {
        kept / f"tables/{name}.csv": (results / f"tables/{name}.csv").read_bytes()
        for name in tables
    }
    changed = [p for p, data in wanted.items() if not p.is_file() or p.read_bytes() != data]
    for path in changed:
        write_file(path, wanted[path])
    gone = [path for path in (kept / "tables").glob("*.csv") if path.stem not in tables]
    for path in gone:
        path.unlink()
    return sorted([*changed, *gone])


def _require_full(results: Path, kept: Path) -> None:
    if results.resolve() != kept.resolve() and (changes := read_record(results).changes):
        keys = ", ".join(change.key for change in changes[:3])
        raise PageError(
            f"{results}: {len(changes)} keys of its configuration differ from the shipped one"
            f" ({keys}, ...); the pages take their numbers from a run of `make reproduce`"
        )
