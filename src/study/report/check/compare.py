"""Comparison of two runs, as text or as a page: inputs, numbers, verdicts, figures."""

from __future__ import annotations

import base64
import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from study.report.check.differences import Difference, Kind, compare_tables
from study.report.check.results import (
    CLAIMS,
    INPUTS,
    figure_files,
    read_cells,
    read_json,
    require_results,
    table_files,
)
from study.report.check.wording import FEW, by_file, cells, markdown, summary, worst
from study.report.site.pages import render
from study.run.stamp import STAMP
from study.run.stamp import changes as configured

SIDES = ("baseline", "changed")
SAME = "Inputs, numbers, verdicts and figures are the same."
UNSEEN = "same parts, slightly moved"
# Columns of the ledger of claims that are declared, not computed.
DECLARED = ("quote", "statement", "criterion", "article_value")
# Column that repeats the changed inputs, claim by claim.
MARKED = "changed_inputs"
# Columns behind a verdict: the shares of the contacts that meet it, else its numbers.
BEHIND = ("shares", "computed_value")
# Kinds of rows that one run alone has.
LONE: tuple[Kind, Kind] = ("missing row", "extra row")
# How references name what a file declares; by the name of the file where it is not here.
PREFIX = {"config": "", "printed_values": "printed."}
# Digits of a checksum that are shown.
SHORT = 12
# Characters of a cell in the page.
WIDTH = 120
_ITEM = re.compile(r"\[\d+\].*")


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureChange:
    """A figure of both runs: its SVG in each, and the parts that differ."""

    name: str
    baseline: Path
    changed: Path
    parts: tuple[Difference, ...]

    @property
    def same(self) -> bool:
        """Whether both runs have the same picture of the same parts."""
        return not self.parts and self.baseline.read_bytes() == self.changed.read_bytes()

    @property
    def words(self) -> str:
        """Counts of the parts that differ, and the names of the first."""
        names = list(dict.fromkeys(part.row for part in self.parts))
        more = ", ..." if len(names) > FEW else ""
        return f"{summary(self.parts)} ({', '.join(names[:FEW])}{more})" if names else UNSEEN


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """Changes from one results folder to another.

    `runs` compares the stamps: commit, versions, seed. It makes no difference by itself, nor do
    files that one of the runs has not built, `not_built`, by its folder.
    """

    baseline: Path
    changed: Path
    runs: tuple[Difference, ...]
    inputs: tuple[Difference, ...]
    verdicts: tuple[Difference, ...]
    numbers: tuple[Difference, ...]
    figures: tuple[FigureChange, ...]
    unchanged_figures: tuple[str, ...]
    not_built: tuple[tuple[Path, tuple[str, ...]], ...]

    @property
    def same(self) -> bool:
        """Whether both runs gave the same."""
        return not (self.inputs or self.verdicts or self.numbers or self.figures)


def compare(baseline: Path, changed: Path) -> Changes:
    """Compare two results folders.

    Raises ResultsError if either folder or a file in it is missing or malformed.
    """
    for root in (baseline, changed):
        require_results(root)
    before, after = _files(baseline), _files(changed)
    topics: dict[str, list[Difference]] = defaultdict(list)
    for name in table_files(baseline):
        if name in after:
            differences = compare_tables(name, read_cells(before[name]), read_cells(after[name]))
            for difference in differences:
                if difference.column != MARKED:
                    topics[_topic(difference)].append(difference)
    names = [name for name in figure_files(baseline) if f"figures/{name}.svg" in after]
    parts = by_file(topics["figures"])
    figures = [
        FigureChange(
            name=name,
            baseline=before[f"figures/{name}.svg"],
            changed=after[f"figures/{name}.svg"],
            parts=tuple(parts.get(f"figures/{name}.csv", ())),
        )
        for name in names
    ]
    return Changes(
        baseline=baseline,
        changed=changed,
        runs=tuple(_stamps(baseline, changed)),
        inputs=tuple(_inputs(baseline, changed, topics["inputs"])),
        verdicts=tuple(_with_numbers(topics["verdicts"], baseline, changed)),
        numbers=tuple(topics["numbers"]),
        figures=tuple(figure for figure in figures if not figure.same),
        unchanged_figures=tuple(figure.name for figure in figures if figure.same),
        not_built=tuple(
            (root, lacking)
            for root, here, there in ((baseline, before, after), (changed, after, before))
            if (lacking := tuple(name for name in there if name not in here))
        ),
    )


def _files(root: Path) -> dict[str, Path]:
    pictures = {f"figures/{name}.svg": path for name, path in figure_files(root).items()}
    return table_files(root) | pictures


def _topic(difference: Difference) -> str:
    if difference.file.startswith("figures/"):
        return "figures"
    is_claim = difference.file == CLAIMS
    if difference.file == INPUTS or (is_claim and difference.column in DECLARED):
        return "inputs"
    # A claim that only one run has judged is a change of verdict, too.
    is_lone_claim = is_claim and difference.kind in LONE
    return "verdicts" if is_lone_claim or difference.column == "verdict" else "numbers"


def _with_numbers(
    verdicts: Sequence[Difference], baseline: Path, changed: Path
) -> Iterator[Difference]:
    """Yield the changed verdicts, each with the share or the numbers that moved in brackets."""
    sides = (
        [read_cells(table_files(root)[CLAIMS]) for root in (baseline, changed)] if verdicts else []
    )
    rows = [{row["id"]: row for row in side.to_dict("records")} for side in sides]
    for verdict in verdicts:
        claims = [side.get(verdict.row, {}) for side in rows]
        moved = next((c for c in BEHIND if claims[0].get(c) != claims[1].get(c)), None)
        if verdict.column != "verdict" or moved is None:
            yield verdict
            continue
        numbers = [str(claim.get(moved, "")).split("; ") for claim in claims]
        words = [
            "; ".join(number for number in side if number not in other)
            for side, other in (numbers, numbers[::-1])
        ]
        before, after = (f"shares {each}" if moved == "shares" else each for each in words)
        yield replace(
            verdict,
            reference=f"{verdict.reference} ({before})",
            result=f"{verdict.result} ({after})",
        )


def _inputs(baseline: Path, changed: Path, differences: Sequence[Difference]) -> list[Difference]:
    """Return one difference per changed input, with the number of its uses that changed, too.

    `differences`: of the tables of inputs, which have a row per use, and of declared words.
    """
    left, right = (_stamp(root).get("config", {}) for root in (baseline, changed))
    inputs = {
        change.key: _text(INPUTS, change.key, change.shipped, change.used)
        for change in configured(right, left)
    }
    places = _places(baseline) | _places(changed)
    uses: Counter[str] = Counter()
    # The value of an input comes before its evidence and source.
    for difference in sorted(differences, key=lambda d: d.column != "value"):
        file, _, key = difference.row.partition(", ")
        declared = f"{PREFIX.get(file, f'{file}.')}{key}" if key else difference.row
        name = _ITEM.sub("", places.get(key, declared))
        uses[name] += key in places and difference.column == "value"
        inputs.setdefault(name, replace(difference, row=name))
    return [
        *(
            replace(d, column=f"{d.column} (uses: {uses[name]})") if uses[name] else d
            for name, d in inputs.items()
        ),
        *_changed_files(baseline, changed),
    ]


def _changed_files(baseline: Path, changed: Path) -> Iterator[Difference]:
    """Yield the declared files with other contents, and those that one run alone has."""
    before, after = (_stamp(root).get("files", {}) for root in (baseline, changed))
    for name in dict.fromkeys((*before, *after)) if before and after else ():
        if before.get(name) != after.get(name):
            sums = (files.get(name, "")[:SHORT] for files in (before, after))
            yield replace(_text(STAMP, name, *sums), column="SHA-256")


def _places(root: Path) -> dict[str, str]:
    """Return where each used input is declared, by its key."""
    path = table_files(root).get(INPUTS)
    if path is None or "origin" not in (table := read_cells(path)):
        return {}
    return {key: name for key, name in zip(table["key"], table["origin"], strict=True) if name}


def _stamps(baseline: Path, changed: Path) -> list[Difference]:
    left, right = (_versions(_stamp(root)) for root in (baseline, changed))
    return [
        _text("run.json", key, left.get(key), right.get(key))
        for key in dict.fromkeys((*left, *right))
        if left.get(key) != right.get(key)
    ]


def _text(file: str, row: str, *cells: object) -> Difference:
    before, after = (
        cell if isinstance(cell, str) else "" if cell is None else json.dumps(cell)
        for cell in cells
    )
    return Difference(
        file=file, kind="text", row=row, column="value", reference=before, result=after
    )


def _stamp(root: Path) -> dict[str, Any]:
    return read_json(root / STAMP) if (root / STAMP).exists() else {}


def _versions(stamp: Mapping[str, Any]) -> dict[str, Any]:
    """Return commit, versions and platform of a run stamp; the inputs tell the configuration."""
    flat: dict[str, Any] = {}
    for key in sorted(stamp.keys() - {"config", "files", "started", "ended"}):
        value = stamp[key] if isinstance(stamp[key], dict) else {"": stamp[key]}
        flat |= {f"{key} {name}".strip(): part for name, part in value.items()}
    return flat


def as_text(changes: Changes) -> str:
    """Return the changes as Markdown."""
    parts = [f"# {changes.baseline} (baseline) and {changes.changed} (changed)"]
    parts += [f"{len(n)} files were not built in {root}." for root, n in changes.not_built]
    if changes.same:
        parts.append(SAME)
    for title, differences, shown in sections(changes):
        if differences:
            parts += [f"## {title}", markdown(differences, shown, names=SIDES)]
    if changes.figures:
        lines = [f"- {figure.name}: {figure.words}" for figure in changes.figures]
        parts += ["## Figures", "\n".join(lines)]
    return "\n\n".join(parts)


def sections(changes: Changes) -> list[tuple[str, tuple[Difference, ...], int]]:
    """Return title, differences and how many are shown; inputs and verdicts are shown all."""
    return [
        ("Runs", changes.runs, len(changes.runs)),
        ("Inputs", changes.inputs, len(changes.inputs)),
        ("Verdicts", changes.verdicts, len(changes.verdicts)),
        ("Numbers", changes.numbers, FEW),
    ]


def page(changes: Changes) -> str:
    """Return the changes as one HTML page that needs nothing else, figures side by side."""
    return render(
        "compare.html",
        templates=Path(__file__).parent / "templates",
        changes=changes,
        sides=SIDES,
        same=SAME,
        sections=[
            (title, [(file, *_in_page(part, shown)) for file, part in by_file(members).items()])
            for title, members, shown in sections(changes)
            if members
        ],
        inline=_inline,
    )


def _in_page(differences: Sequence[Difference], few: int) -> tuple[str, list[tuple[str, ...]], int]:
    """Return the summary of one file, its rows, and the number that is not shown."""
    rows = [cells(difference, WIDTH) for difference in worst(differences, few)]
    return summary(differences), rows, len(differences) - len(rows)


def _inline(svg: Path) -> str:
    # As an image, and not as part of the page: no script in it runs, no name in it clashes.
    return "data:image/svg+xml;base64," + base64.b64encode(svg.read_bytes()).decode("ascii")
