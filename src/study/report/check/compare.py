"""Comparison of two runs: inputs, numbers, verdicts, figures."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from study.report.check.differences import (
    FEW,
    Difference,
    by_file,
    compare_tables,
    markdown,
    summary,
)
from study.report.check.results import (
    CLAIMS,
    INPUTS,
    figure_files,
    read_cells,
    read_json,
    require_results,
    table_files,
)
from study.run.stamp import STAMP
from study.run.stamp import changes as configured

SIDES = ("baseline", "changed")
SAME = "Inputs, numbers, verdicts and figures are the same."
UNSEEN = "same parts, slightly moved"
# Columns of the ledger of claims that are declared, not computed.
DECLARED = ("quote", "statement", "criterion", "article_value")
# Column that repeats the changed inputs, claim by claim.
MARKED = "changed_inputs"
# Numbers behind a verdict: the shares of the contacts that meet it, and its quantities.
BEHIND = {"tables/claim_shares.csv": "share", "tables/claim_results.csv": "value"}
# Digits of a checksum that are shown.
SHORT = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """Changes from one results folder to another.

    `runs` compares commit and versions. It makes no difference by itself, nor do the files that one
    of the runs has not built, `not_built`, by its folder. Each of `figures` has the parts that
    differ, none if the picture alone does.
    """

    baseline: Path
    changed: Path
    runs: Sequence[Difference]
    inputs: Sequence[Difference]
    verdicts: Sequence[Difference]
    numbers: Sequence[Difference]
    figures: Mapping[str, Sequence[Difference]]
    unchanged_figures: Sequence[str]
    not_built: Mapping[Path, Sequence[str]]

    @property
    def same(self) -> bool:
        """Whether both runs gave the same."""
        return not (self.inputs or self.verdicts or self.numbers or self.figures)

    @property
    def sections(self) -> list[tuple[str, Sequence[Difference], int]]:
        """Title, differences and how many are shown; inputs and verdicts are shown all."""
        return [
            ("Runs", self.runs, len(self.runs)),
            ("Inputs", self.inputs, len(self.inputs)),
            ("Verdicts", self.verdicts, len(self.verdicts)),
            ("Numbers", self.numbers, FEW),
        ]


def compare(baseline: Path, changed: Path) -> Changes:
    """Compare two results folders.

    Raises ResultsError if either folder or a file in it is missing or malformed.
    """
    for root in (baseline, changed):
        require_results(root)
    stamps = [read_json(root / STAMP) for root in (baseline, changed)]
    before, after = _files(baseline), _files(changed)
    topics = defaultdict[str, list[Difference]](list)
    for name in table_files(baseline):
        if name in after:
            left, right = read_cells(before[name]), read_cells(after[name])
            for difference in compare_tables(name, left, right):
                topics[_topic(difference)].append(difference)
    parts = by_file(topics["figures"])
    pictures = [name for name in figure_files(baseline) if _svg(name) in after]
    figures = {
        name: parts.get(f"figures/{name}.csv", [])
        for name in pictures
        if f"figures/{name}.csv" in parts
        or before[_svg(name)].read_bytes() != after[_svg(name)].read_bytes()
    }
    return Changes(
        baseline=baseline,
        changed=changed,
        runs=_lines(*map(_origin, stamps)),
        inputs=[
            *_configured(*stamps),
            *topics["inputs"],
            *_lines(*map(_files_used, stamps)),
        ],
        verdicts=[_with_numbers(verdict, topics["numbers"]) for verdict in topics["verdicts"]],
        numbers=topics["numbers"],
        figures=figures,
        unchanged_figures=[name for name in pictures if name not in figures],
        not_built={
            root: lacking
            for root, here, there in ((baseline, before, after), (changed, after, before))
            if (lacking := [name for name in there if name not in here])
        },
    )


def _svg(figure: str) -> str:
    return f"figures/{figure}.svg"


def _files(root: Path) -> dict[str, Path]:
    return table_files(root) | {_svg(name): path for name, path in figure_files(root).items()}


def _topic(difference: Difference) -> str:
    if difference.file.startswith("figures/"):
        return "figures"
    if difference.file == INPUTS:
        # The stamp tells the values of the configuration, each once, however often it is used.
        return "uses" if difference.row.startswith("config, ") else "inputs"
    if difference.file == CLAIMS:
        # A claim that only one run has judged, without a column, is a change of verdict, too.
        if difference.column in {"verdict", ""}:
            return "verdicts"
        declared = dict.fromkeys(DECLARED, "inputs") | {MARKED: "uses"}
        return declared.get(difference.column, "numbers")
    return "numbers"


def _with_numbers(verdict: Difference, numbers: Sequence[Difference]) -> Difference:
    """Return a changed verdict with the shares and numbers that moved in brackets."""
    moved = [
        (", ".join(filter(None, number.row.split(", ")[1:])), number.reference, number.result)
        for number in numbers
        if BEHIND.get(number.file) == number.column and number.row.startswith(f"{verdict.row}, ")
    ]
    if verdict.column != "verdict" or not moved:
        return verdict
    before, after = (
        "; ".join(f"{number[0]} = {number[side]}" for number in moved) for side in (1, 2)
    )
    return replace(
        verdict,
        reference=f"{verdict.reference} ({before})",
        result=f"{verdict.result} ({after})",
    )


def _origin(stamp: Mapping[str, Any]) -> dict[str, Any]:
    """Return commit, versions and platform of a run."""
    git = {f"git {key}": value for key, value in stamp.get("git", {}).items()}
    machine = {key: stamp.get(key) for key in ("python", "platform")}
    return {**git, **machine, **stamp.get("packages", {})}


def _files_used(stamp: Mapping[str, Any]) -> dict[str, str]:
    """Return the checksums of the declared files."""
    return {name: text[:SHORT] for name, text in stamp.get("files", {}).items()}


def _configured(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Difference]:
    changes = configured(after.get("config", {}), before.get("config", {}))
    return [_line(change.key, change.shipped, change.used) for change in changes]


def _lines(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Difference]:
    """Return a difference per entry that two mappings do not share."""
    pairs = {name: (before.get(name), after.get(name)) for name in (*before, *after)}
    return [_line(name, left, right) for name, (left, right) in pairs.items() if left != right]


def _line(row: str, *values: object) -> Difference:
    before, after = (
        value if isinstance(value, str) else "" if value is None else json.dumps(value)
        for value in values
    )
    return Difference(
        file=STAMP, kind="text", row=row, column="value", reference=before, result=after
    )


def as_text(changes: Changes) -> str:
    """Return the changes as Markdown."""
    parts = [f"# {changes.baseline} (baseline) and {changes.changed} (changed)"]
    parts += [f"{len(n)} files were not built in {root}." for root, n in changes.not_built.items()]
    if changes.same:
        parts.append(SAME)
    for title, differences, shown in changes.sections:
        if differences:
            parts += [f"## {title}", markdown(differences, shown, names=SIDES)]
    if changes.figures:
        lines = [f"- {name}: {_words(figure)}" for name, figure in changes.figures.items()]
        parts += ["## Figures", "\n".join(lines)]
    return "\n\n".join(parts)


def _words(figure: Sequence[Difference]) -> str:
    """Return the counts of the parts of a figure that differ, and the names of the first."""
    names = list(dict.fromkeys(part.row for part in figure))
    more = ", ..." if len(names) > FEW else ""
    return f"{summary(figure)} ({', '.join(names[:FEW])}{more})" if names else UNSEEN
