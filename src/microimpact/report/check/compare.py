"""Comparison of two runs: which inputs, numbers, verdicts and figures changed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microimpact.report.check.differences import Difference, compare_tables
from microimpact.report.check.results import (
    CLAIMS,
    INPUTS,
    figure_files,
    key_columns,
    read_cells,
    read_json,
    require_results,
    table_files,
)
from microimpact.report.check.shapes import PictureTolerance, compare_shapes, read_shape
from microimpact.report.check.wording import markdown, summary

SIDES = ("baseline", "changed")
UNSEEN = "same parts, slightly moved"


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureChange:
    """A figure that is not the same in both runs: its SVG in each, if there, and what changed."""

    name: str
    baseline: Path | None
    changed: Path | None
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """What changed from one results folder to another.

    `runs` compares the stamps: commit, versions, seed. It makes no difference by itself.
    """

    baseline: Path
    changed: Path
    runs: tuple[Difference, ...]
    inputs: tuple[Difference, ...]
    verdicts: tuple[Difference, ...]
    numbers: tuple[Difference, ...]
    figures: tuple[FigureChange, ...]
    unchanged_figures: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether both runs gave the same."""
        return not (self.inputs or self.verdicts or self.numbers or self.figures)


def compare(baseline: Path, changed: Path) -> Changes:
    """Compare two results folders.

    Raises
    ------
    ResultsError
        If either folder or a file in it is missing or malformed.
    """
    for root in (baseline, changed):
        require_results(root)
    differences = _tables(table_files(baseline), table_files(changed))
    left, right = figure_files(baseline), figure_files(changed)
    figures = [_figure(n, left.get(n), right.get(n)) for n in sorted({*left, *right})]
    return Changes(
        baseline=baseline,
        changed=changed,
        runs=tuple(_stamps(baseline, changed)),
        inputs=tuple(d for d in differences if _topic(d) == "inputs"),
        verdicts=tuple(d for d in differences if _topic(d) == "verdicts"),
        numbers=tuple(d for d in differences if _topic(d) == "numbers"),
        figures=tuple(figure for figure in figures if figure.what),
        unchanged_figures=tuple(figure.name for figure in figures if not figure.what),
    )


def _topic(difference: Difference) -> str:
    if difference.file == INPUTS:
        return "inputs"
    # A claim that only one run has judged is a change of verdict, too.
    one_sided = difference.file == CLAIMS and not difference.column
    return "verdicts" if one_sided or difference.column == "verdict" else "numbers"


def _tables(left: Mapping[str, Path], right: Mapping[str, Path]) -> list[Difference]:
    found = []
    for name in dict.fromkeys((*left, *right)):
        if name not in right:
            found.append(Difference(file=name, kind="missing file"))
        elif name not in left:
            found.append(Difference(file=name, kind="extra file"))
        else:
            tables = read_cells(left[name]), read_cells(right[name])
            found += compare_tables(name, *tables, keys=key_columns(name))
    return found


def _figure(name: str, baseline: Path | None, changed: Path | None) -> FigureChange:
    if baseline is None or changed is None:
        what = f"only in the {SIDES[changed is not None]} run"
    elif baseline.read_bytes() == changed.read_bytes():
        what = ""
    else:
        shapes = read_shape(baseline), read_shape(changed)
        what = summary(compare_shapes(name, *shapes, PictureTolerance())) or UNSEEN
    return FigureChange(name=name, baseline=baseline, changed=changed, what=what)


def _stamps(baseline: Path, changed: Path) -> list[Difference]:
    left, right = (_stamp(root / "run.json") for root in (baseline, changed))
    return [
        Difference(
            file="run.json",
            kind="text",
            row=key,
            column="value",
            reference=left.get(key, ""),
            found=right.get(key, ""),
        )
        for key in dict.fromkeys((*left, *right))
        if left.get(key) != right.get(key)
    ]


def _stamp(path: Path) -> dict[str, str]:
    """Return versions and commit of a run stamp; the configuration is compared by inputs.csv."""
    if not path.exists():
        return {}
    flat: dict[str, Any] = {}
    stamp = read_json(path)
    for key in sorted(stamp.keys() - {"config", "started", "ended"}):
        value = stamp[key]
        if isinstance(value, dict):
            flat |= {f"{key} {name}": part for name, part in value.items()}
        else:
            flat[key] = value
    return {key: v if isinstance(v, str) else json.dumps(v) for key, v in flat.items()}


def as_text(changes: Changes, few: int = 5) -> str:
    """Return the changes as Markdown."""
    parts = [f"# {changes.baseline} (baseline) and {changes.changed} (changed)"]
    if changes.same:
        parts.append("Inputs, numbers, verdicts and figures are the same.")
    for title, found, shown in sections(changes, few):
        if found:
            parts += [f"## {title}", markdown(found, shown, names=SIDES)]
    if changes.figures:
        lines = [f"- {figure.name}: {figure.what}" for figure in changes.figures]
        parts += ["## Figures", "\n".join(lines)]
    return "\n\n".join(parts)


def sections(changes: Changes, few: int) -> list[tuple[str, tuple[Difference, ...], int]]:
    """Return title, differences and how many are shown; inputs and verdicts are shown all."""
    return [
        ("Runs", changes.runs, len(changes.runs)),
        ("Inputs", changes.inputs, len(changes.inputs)),
        ("Verdicts", changes.verdicts, len(changes.verdicts)),
        ("Numbers", changes.numbers, few),
    ]
