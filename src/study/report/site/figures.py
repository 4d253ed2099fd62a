"""One figure with its data, inputs, equations and claims."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from study import analyses
from study.figures.declaration import FORMATS, all_figures
from study.report.site.ledgers import Row
from study.report.site.record import Record
from study.run.study import settings_as_shipped
from study.tables import ResultTables, text_rows

ARTICLE = re.compile(r"fig(\d\d)")
ACRONYMS = {"ptis", "pdpa"}
# What figures and tables are about, by the analyses that make them, as pages group them.
SUBJECTS = {
    "Capture velocity": (
        *("capture_velocities", "inference", "fig15_16_restitution_fits", "rival_explanations"),
        *("pile_up", "size_law", "calibration", "fig14_restitution_trends"),
    ),
    "Normal impact": (
        *("fig04_05_normal_experiments", "fig20_force_history", "edge_speed"),
        "particle_separation",
    ),
    "Oblique impact": ("fig06_12_oblique_experiments", "mechanisms", "oblique_data"),
    "Friction and rolling": (
        *("fig17_coulomb_friction", "fig18_21_oblique_impact", "rolling_dissipation"),
    ),
    "Roughness": ("fig23_monte_carlo", "roughness_expansions"),
    "Instruments and set-ups": (
        *("fig01_03_13_19_22_schematics", "pair_search", "track_imaging", "campaign"),
    ),
    "Statistics and sensitivity": ("fig24_25_doe", "sensitivity", "interval_coverage"),
}
OTHER = "Further analyses"
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
CLAIM_STUDY = "claim_numbers"
_MICROMETRE = re.compile(r"\bum\b")
_ITEM = re.compile(r"\[\d+\]$")


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """One figure: words, files relative to the results, inputs, equations and claims.

    Tables of its study that belong with it have a sentence each. `evidence` has the classes of
    what is drawn, `values` the inputs in the branch of its study, and `rows` those of declared
    tables. `explorer` is the fragment that opens the explorer with its impact, or empty.
    """

    name: str
    label: str
    subject: str
    title: str
    finding: str
    caption: str
    method: str
    article: str
    is_of_article: bool  # Title and caption are as shipped
    disagreement: Sequence[str]
    agreement: Sequence[str]
    data: tuple[str, ...]
    tables: Mapping[str, str]
    evidence: tuple[str, ...]
    values: tuple[Row, ...]
    rows: tuple[Row, ...]
    upstream: tuple[str, ...]
    drawing: str
    analysis: str
    explorer: str
    departures: tuple[Row, ...]
    equations: tuple[Row, ...]
    claims: tuple[Row, ...]
    is_narrow: bool
    formats: tuple[str, ...]  # In which there is a picture

    @property
    def alternative(self) -> str:
        """Alternative text of the picture."""
        words = f"{self.title}. {self.finding} {self.caption}"
        return f"{self.label}. {words} Evidence: {', '.join(self.evidence) or 'none'}."


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


def subject(analysis: str) -> str:
    """Return the subject of an analysis, under which pages list its figures and tables."""
    return next((words for words, names in SUBJECTS.items() if analysis in names), OTHER)


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
    tables_of_run = ResultTables(results)
    there = [name for name in record.figures if (results / f"figures/{name}.svg").is_file()]

    def figure(name: str) -> Figure:
        entry = record.figures[name]
        study, data = entry["analysis"], tuple(f"data/{table}.csv" for table in entry["data"])
        is_of_article = shows_article(name, entry)
        disagreement, agreement = (
            all_figures()[name].compared(tables_of_run) if is_of_article else ([], [])
        )
        tables = {f"tables/{table}.csv": words for table, words in entry.get("tables", {}).items()}
        return Figure(
            name=name,
            label=label(name),
            subject=subject(study),
            title=entry["title"],
            finding=_line(finding(results / f"figures/{name}.csv")),
            **{key: _line(entry.get(key, "")) for key in ("caption", "method")},
            article=" ".join(entry.get("article", "").split()),
            is_of_article=is_of_article,
            disagreement=[_line(words) for words in disagreement],
            agreement=[_line(words) for words in agreement],
            data=data,
            tables={file: words for file, words in tables.items() if (results / file).is_file()},
            evidence=_evidence([results / file for file in data]),
            values=tuple(joined(_branch(study, declared))),
            rows=_rows(record.rows.get(study, {}), declared),
            upstream=upstream(study),
            drawing=entry["drawing"],
            analysis=f"{analyses.homes()[study]}.run",
            explorer=explored(study, declared),
            departures=departures(declared, [study]),
            equations=tuple(
                row for row in ledgers["equations"] if row["equation"] in entry.get("equations", ())
            ),
            claims=tuple(row for row in ledgers["claims"] if name in row["figures"].split()),
            is_narrow=entry.get("width") == "single",
            formats=tuple(k for k in FORMATS if (results / f"figures/{name}.{k}").is_file()),
        )

    return [figure(n) for n in sorted(there, key=lambda n: (not ARTICLE.fullmatch(n), n))]


def shows_article(name: str, entry: Mapping[str, Any]) -> bool:
    """Tell whether a figure of the registry shows the impacts that it shows as shipped.

    Of others the article says nothing. Title and caption name particles, surfaces and speeds.
    """
    if name not in all_figures():
        return False
    shipped = settings_as_shipped()
    branch = shipped.branches[entry["analysis"]]
    words = all_figures()[name].filled(branch, shipped.pairs)
    return (words.title, words.caption) == (entry["title"], entry["caption"])


def finding(content: Path) -> str:
    """Return the finding that a figure was drawn with, from the table of its content."""
    return next((row["text"] for row in text_rows(content) if row["artist"] == "finding"), "")


def _evidence(paths: Iterable[Path]) -> tuple[str, ...]:
    """Return the evidence classes of figure data, in their order."""
    rows = (row for path in paths for row in text_rows(path))
    # A table that could not be computed has no evidence.
    return tuple(dict.fromkeys(row["evidence"] for row in rows if "evidence" in row))


def upstream(study: str) -> tuple[str, ...]:
    """Return the studies whose tables a study rests on, the nearest first."""
    chain = [study]
    for name in chain:
        chain += [maker for maker in sorted({*analyses.needs(name).values()}) if maker not in chain]
    return tuple(chain[1:])


def _rows(names: Mapping[str, Iterable[str]], declared: Sequence[Row]) -> tuple[Row, ...]:
    """Return the rows of the declared tables by their names."""
    named = {(TABLES[table], key) for table in names.keys() & TABLES for key in names[table]}
    return tuple(row for row in declared if (row["file"], owner(row)) in named)


def _branch(study: str, declared: Sequence[Row]) -> list[Row]:
    """Return the values of the branch of a study, their keys without its name."""
    return [
        row | {"key": row["key"].removeprefix(f"{study}.")}
        for row in declared
        if row["file"] == "config" and row["key"].startswith(f"{study}.")
    ]


def explored(study: str, declared: Sequence[Row]) -> str:
    """Return the state of the explorer for the impact of a study, empty without a single one."""
    values = {row["key"]: row["value"] for row in _branch(study, declared)}
    if not {"case", "speed_m_per_s"} <= set(values):
        return ""
    return urlencode({field: values[key] for key, field in EXPLORED.items() if key in values})


def departures(declared: Sequence[Row], names: Iterable[str]) -> tuple[Row, ...]:
    """Return the inputs that studies, or those they rest on, have in place of the laboratory's.

    The study of all claims counts by itself: each claim rests on the tables that it reads.
    """
    concerned = {
        each
        for study in names
        for each in (study, *(upstream(study) if study != CLAIM_STUDY else ()))
    }
    return tuple(
        row for row in declared if row["overrides"] and row["key"].partition(".")[0] in concerned
    )


def studies_behind(claim: Row, record: Record) -> set[str]:
    """Return the studies that a claim rests on: of its figures, and of the tables it reads."""
    drawn = {record.figures[n]["analysis"] for n in claim["figures"].split() if n in record.figures}
    makers = analyses.needs(CLAIM_STUDY)
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
