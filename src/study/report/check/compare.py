"""Comparison of two runs: inputs, numbers, verdicts, figures."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from study.report.check.differences import (
    FEW,
    Difference,
    as_text,
    compare_tables,
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

# Topic of a column of the ledger of claims; the others are numbers. A claim that only one run has
# judged, without a column, is a change of verdict; the last repeats inputs, claim by claim.
OF_CLAIMS = dict.fromkeys(("quote", "statement", "criterion", "article_value"), "inputs")
OF_CLAIMS |= {"verdict": "verdicts", "": "verdicts", "changed_inputs": "uses"}
# Numbers behind a verdict: the shares of the contacts that meet it, and its quantities.
BEHIND = {"tables/claim_shares.csv": "share", "tables/claim_results.csv": "value"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """Changes from one results folder to another.

    `runs` compares commit and versions. It makes no difference by itself, nor do the files that one
    of the runs has not built, `not_built`, by its folder. Each of `figures` has the parts that
    differ, none if the picture alone does.
    """

    runs: Sequence[Difference]
    inputs: Sequence[Difference]
    verdicts: Sequence[Difference]
    numbers: Sequence[Difference]
    figures: Mapping[str, Sequence[Difference]]
    not_built: Mapping[Path, Sequence[str]]

    @property
    def same(self) -> bool:
        """Whether both runs gave the same."""
        return not (self.inputs or self.verdicts or self.numbers or self.figures)

    def __str__(self) -> str:
        """Return the changes as Markdown; inputs and verdicts are shown all."""
        parts = [f"{len(n)} files were not built in {root}." for root, n in self.not_built.items()]
        if self.same:
            parts.append("Inputs, numbers, verdicts and figures are the same.")
        for title in ("runs", "inputs", "verdicts", "numbers"):
            if differences := getattr(self, title):
                few = FEW if title == "numbers" else len(differences)
                parts += [f"## {title.capitalize()}", as_text(differences, few)]
        if self.figures:
            lines = [
                f"- {name}: {_parts(differences)}" for name, differences in self.figures.items()
            ]
            parts += ["## Figures", "\n".join(lines)]
        return "\n\n".join(parts)


def compare(baseline: Path, changed: Path) -> Changes:
    """Compare two results folders.

    Raises ResultsError if either folder or a file in it is missing or malformed.
    """
    roots = baseline, changed
    for root in roots:
        require_results(root)
    stamps = [read_json(root / STAMP) for root in roots]
    before, after = (table_files(root) | _pictures(root) for root in roots)
    topics, figures = defaultdict[str, list[Difference]](list), dict[str, list[Difference]]()
    for name in before:
        if name not in after:
            continue
        if name.endswith(".svg"):
            if before[name].read_bytes() != after[name].read_bytes():
                figures.setdefault(Path(name).stem, [])
            continue
        differences = compare_tables(name, read_cells(before[name]), read_cells(after[name]))
        if name.startswith("figures/") and differences:
            figures[Path(name).stem] = differences
        else:
            for difference in differences:
                topics[_topic(difference)].append(difference)
    settings = [stamp.get("config", {}) for stamp in stamps]
    keys = [
        _line(change.key, change.shipped, change.used) for change in configured(*settings[::-1])
    ]
    pairs = (baseline, before, after), (changed, after, before)
    return Changes(
        runs=_lines(*map(_origin, stamps)),
        inputs=[*keys, *_lines(*(stamp.get("files", {}) for stamp in stamps)), *topics["inputs"]],
        verdicts=[_with_numbers(verdict, topics["numbers"]) for verdict in topics["verdicts"]],
        numbers=topics["numbers"],
        figures=figures,
        not_built={
            root: lacking
            for root, here, there in pairs
            if (lacking := [name for name in there if name not in here])
        },
    )


def _pictures(root: Path) -> dict[str, Path]:
    return {f"figures/{name}.svg": path for name, path in figure_files(root).items()}


def _topic(difference: Difference) -> str:
    if difference.file == INPUTS:
        # The stamp tells the values of the configuration, each once, however often it is used.
        return "uses" if difference.row.startswith("config, ") else "inputs"
    return OF_CLAIMS.get(difference.column, "numbers") if difference.file == CLAIMS else "numbers"


def _with_numbers(verdict: Difference, numbers: Sequence[Difference]) -> Difference:
    """Return a changed verdict with the shares and numbers that moved in brackets."""
    moved = [
        (", ".join(filter(None, number.row.split(", ")[1:])), number)
        for number in numbers
        if BEHIND.get(number.file) == number.column and number.row.startswith(f"{verdict.row}, ")
    ]
    if verdict.column != "verdict" or not moved:
        return verdict
    before = "; ".join(f"{name} = {number.reference}" for name, number in moved)
    after = "; ".join(f"{name} = {number.result}" for name, number in moved)
    return verdict._replace(
        reference=f"{verdict.reference} ({before})",
        result=f"{verdict.result} ({after})",
    )


def _origin(stamp: Mapping[str, Any]) -> dict[str, Any]:
    """Return commit, versions and platform of a run."""
    git = {f"git {key}": value for key, value in stamp.get("git", {}).items()}
    machine = {key: stamp.get(key) for key in ("python", "platform")}
    return {**git, **machine, **stamp.get("packages", {})}


def _lines(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Difference]:
    """Return a difference per entry that two mappings do not share."""
    pairs = {name: (before.get(name), after.get(name)) for name in (*before, *after)}
    return [_line(name, left, right) for name, (left, right) in pairs.items() if left != right]


def _line(row: str, *values: object) -> Difference:
    reference, result = (
        value if isinstance(value, str) else "" if value is None else json.dumps(value)
        for value in values
    )
    return Difference(STAMP, "text", row, "value", reference, result)


def _parts(figure: Sequence[Difference]) -> str:
    """Return the counts of the parts of a figure that differ, and the names of the first."""
    names = list(dict.fromkeys(part.row for part in figure))
    more = ", ..." if len(names) > FEW else ""
    listed = f"{summary(figure)} ({', '.join(names[:FEW])}{more})"
    return listed if names else "same parts, slightly moved"
