"""One figure with its data, inputs, equations and claims."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from study import studies
from study.figures.registry import CURVES
from study.ledgers.claims.words import in_words
from study.report.site.graph import needs, upstream
from study.report.site.ledgers import Row, read_rows
from study.report.site.record import Record, Rule

ARTICLE = re.compile(r"fig(\d\d)")
ACRONYMS = {"ptis", "pdpa"}
# Names of the declared tables in a study, and those of their files.
TABLES = {
    "materials": "materials",
    "contacts": "contacts",
    "printed": "printed_values",
    "external": "external",
}
# Values of a study that say which impact it computes, and the fields of the explorer.
EXPLORED = {
    "case": "contact",
    "diameter_um": "d",
    "speed_m_per_s": "v",
    "angle_deg": "angle",
    "spin_rad_per_s": "spin",
    "friction": "f",
}
_MICROMETRE = re.compile(r"\bum\b")
_ITEM = re.compile(r"\[\d+\]$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Marks:
    """One evidence class in a figure and the series that have it, in words, by panel."""

    evidence: str
    series: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Inputs of one study: values of its branch and rows of the declared tables."""

    values: tuple[Row, ...]
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """One figure: words, files relative to the results, inputs, equations and claims.

    Tables of its study that belong with it have a sentence each, functions of its code a role.
    `explorer` is the fragment that opens the explorer with its impact; empty if it has none.
    """

    name: str
    label: str
    title: str
    finding: str
    caption: str
    method: str
    article: str
    study: str
    data: tuple[str, ...]
    tables: Mapping[str, str]
    marks: tuple[Marks, ...]
    inputs: Inputs
    upstream: tuple[str, ...]
    code: Mapping[str, str]
    explorer: str
    departures: tuple[Row, ...]
    contacts: tuple[str, ...]
    equations: tuple[Row, ...]
    claims: tuple[Row, ...]
    is_narrow: bool

    @property
    def alternative(self) -> str:
        """Alternative text of the picture."""
        shown = ", ".join(mark.evidence for mark in self.marks)
        words = f"{self.title}. {self.finding} {self.caption}"
        return f"{self.label}. {words} Marks: {shown or 'none'}."


def _line(words: str) -> str:
    """Return words in one line, with the sign of micrometres."""
    return _MICROMETRE.sub("µm", " ".join(words.split()))


def label(name: str) -> str:
    """Return the label of a figure: ``fig04`` is the article's Figure 4, others have a name."""
    match = ARTICLE.fullmatch(name)
    if match:
        return f"Figure {int(match[1])}"
    first, *rest = name.split("_")
    return " ".join([first.upper() if first in ACRONYMS else first.capitalize(), *rest])


def figures(
    results: Path, record: Record, ledgers: Mapping[str, Sequence[Row]], declared: Sequence[Row]
) -> list[Figure]:
    """Return all figures of a run, those of the article first.

    Parameters
    ----------
    results
        Results folder; a figure that is not there is left out.
    record
        Registry and rules of the run.
    ledgers
        Rows of ``claims`` and ``equations``.
    declared
        Rows of the table of inputs.
    """
    needed = needs(record.rules)
    calibration = read_rows(results / "tables/calibration.csv")
    rules = {rule.name: rule for rule in record.rules}
    homes = studies.homes()
    there = [name for name in record.figures if (results / f"figures/{name}.svg").is_file()]

    def figure(name: str) -> Figure:
        entry = record.figures[name]
        study, data = entry["study"], tuple(f"data/{table}.csv" for table in entry["data"])
        module = entry.get("module", CURVES)
        tables = {f"tables/{table}.csv": words for table, words in entry.get("tables", {}).items()}
        return Figure(
            name=name,
            label=label(name),
            title=entry["title"],
            **{key: _line(entry.get(key, "")) for key in ("finding", "caption", "method")},
            article=" ".join(entry.get("article", "").split()),
            study=study,
            data=data,
            tables={file: words for file, words in tables.items() if (results / file).is_file()},
            marks=_marks([results / file for file in data], entry.get("panels", {})),
            inputs=_inputs(rules.get(study, Rule(name=study)), declared),
            upstream=upstream(study, needed),
            code={
                "drawing": f"{module}.{entry.get('function', 'draw')}",
                "analysis": f"{homes.get(study, '')}.run",
            },
            explorer=explored(study, declared),
            departures=departures(declared, [study], needed),
            contacts=() if ".schematics." in module else contacts(entry, declared, calibration),
            equations=tuple(
                row for row in ledgers["equations"] if row["equation"] in entry.get("equations", ())
            ),
            claims=tuple(row for row in ledgers["claims"] if name in row["figures"].split()),
            is_narrow=entry.get("width") == "single",
        )

    return [figure(n) for n in sorted(there, key=lambda n: (not ARTICLE.fullmatch(n), n))]


def _marks(paths: Iterable[Path], panels: Mapping[str, Mapping[str, Any]]) -> tuple[Marks, ...]:
    marks: dict[str, dict[str, dict[str, None]]] = {}
    for path in filter(Path.is_file, paths):
        with path.open(encoding="utf-8", newline="") as stream:
            rows = csv.reader(stream)
            next(rows)  # panel, series, evidence and the numbers
            for panel, series, evidence in dict.fromkeys(tuple(row[:3]) for row in rows):
                named = marks.setdefault(evidence, {}).setdefault(panel, {})
                named[_series_words(series, panel, panels)] = None
    return tuple(
        Marks(
            evidence=evidence,
            series={_panel_words(panel, panels): tuple(names) for panel, names in by_panel.items()},
        )
        for evidence, by_panel in marks.items()
    )


def _panel_words(panel: str, panels: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the title of a panel, or the label of its upright axis."""
    spec = panels.get(panel, {})
    return " ".join((spec.get("title") or spec.get("y_label") or in_words(panel)).split())


def _series_words(name: str, panel: str, panels: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the label of a series in a legend of the figure, its own panel first, or its name.

    The effects of a response are series, too: ``v_c: AB``; and so are the rows of a picture.
    """
    first = panels.get(panel, {})
    start, colon, effect = name.partition(": ")
    for spec in (first, *panels.values()):
        series = spec.get("series", {})
        for key, rest in ((name, ""), (start, colon + effect)):
            label = series.get(key, {}).get("label", "_")
            if not label.startswith("_"):
                return " ".join(f"{label}{rest}".split())
    return "grey levels of its rows" if name.isdigit() else " ".join(in_words(name).split())


def _inputs(rule: Rule, declared: Sequence[Row]) -> Inputs:
    named = {
        (TABLES[table], key)
        for table, keys in rule.declared.items()
        if table in TABLES
        for key in keys
    }
    values = [
        row | {"key": row["key"].removeprefix(f"{rule.name}.")}
        for row in declared
        if row["file"] == "config" and row["key"].startswith(f"{rule.name}.")
    ]
    return Inputs(
        values=tuple(joined(values)),
        rows=tuple(row for row in declared if (row["file"], owner(row)) in named),
    )


def explored(study: str, declared: Sequence[Row]) -> str:
    """Return the state of the explorer for the impact of a study, empty without a single one."""
    values = {
        row["key"].removeprefix(f"{study}."): row["value"]
        for row in declared
        if row["file"] == "config" and row["key"].startswith(f"{study}.")
    }
    if not {"case", "speed_m_per_s"} <= set(values):
        return ""
    return urlencode({field: values[key] for key, field in EXPLORED.items() if key in values})


def departures(
    declared: Sequence[Row], names: Iterable[str], needed: Mapping[str, Sequence[str]]
) -> tuple[Row, ...]:
    """Return the inputs that studies, or those they rest on, have in place of the laboratory's."""
    concerned = {each for study in names for each in (study, *upstream(study, needed))}
    return tuple(
        row for row in declared if row["overrides"] and row["key"].partition(".")[0] in concerned
    )


def contacts(
    entry: Mapping[str, Any], declared: Sequence[Row], calibration: Sequence[Row]
) -> tuple[str, ...]:
    """Return the calibrated contacts that a figure names, or else all that its study uses.

    A study names one by a value, as ``case``, or by a branch.

    Parameters
    ----------
    entry
        Of the figure in the registry.
    declared, calibration
        Rows of the tables of inputs and of the calibration.
    """
    branch = [row for row in declared if row["key"].startswith(f"{entry['study']}.")]
    values, keys = {row["value"] for row in branch}, "\n".join(f"{row['key']}." for row in branch)
    cases = dict.fromkeys(row["case"] for row in calibration)
    used = [case for case in cases if case in values or f".{case}." in keys]
    return tuple([case for case in used if case in str(entry)] or used)


# The study of all claims; each rests on the tables that it was computed from.
CLAIM_STUDY = "claim_numbers"


def studies_behind(claim: Row, record: Record) -> set[str]:
    """Return the studies that a claim rests on: of its figures, and of the tables it reads."""
    drawn = {record.figures[n]["study"] for n in claim["figures"].split() if n in record.figures}
    makers = studies.needs(CLAIM_STUDY)
    read = {makers[name] for name in claim.get("inputs", "").split() if name in makers}
    drawn_from = {"inference"} if claim.get("shares") else set()
    return drawn | read | drawn_from | {CLAIM_STUDY}


def owner(row: Row) -> str:
    """Return the material, contact, printed value or source that a row of the inputs belongs to."""
    if row["file"] == "external":
        return row["key"].partition(".")[0]
    return row["key"].rpartition(".")[0] or row["key"]


def joined(rows: Iterable[Row]) -> list[Row]:
    """Put the items of a list, where nothing but the value differs, into one row."""
    merged: list[Row] = []
    for row in rows:
        key = _ITEM.sub("", row["key"])
        same = {name: row[name] for name in ("unit", "evidence", "source", "overrides")}
        last = merged[-1] if merged else None
        if key != row["key"] and last and last == last | same | {"key": key}:
            last["value"] += f", {row['value']}"
        else:
            merged.append(row | {"key": key})
    return merged
