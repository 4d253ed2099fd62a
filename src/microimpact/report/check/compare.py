"""Comparison of two runs, as text or as a page: inputs, numbers, verdicts, figures."""

from __future__ import annotations

import base64
import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from microimpact.core.files import recorded_inputs
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
from microimpact.report.check.wording import by_file, cells, markdown, summary, worst
from microimpact.report.site.pages import render
from microimpact.run.stamp import changes as configured

SIDES = ("baseline", "changed")
SAME = "Inputs, numbers, verdicts and figures are the same."
UNSEEN = "same parts, slightly moved"
# Characters of a cell in the page.
WIDTH = 120
_ITEM = re.compile(r"\[\d+\].*")


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureChange:
    """A figure that is not the same in both runs: its SVG in each, and what changed."""

    name: str
    baseline: Path
    changed: Path
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Changes:
    """What changed from one results folder to another.

    `runs` compares the stamps: commit, versions, seed. It makes no difference by itself, nor do
    files that one of the runs has not built, `not_built`, by the name of the side. Figures that
    rest on a changed input, `resting`, come first among the figures.
    """

    baseline: Path
    changed: Path
    runs: tuple[Difference, ...]
    inputs: tuple[Difference, ...]
    resting: tuple[str, ...]
    verdicts: tuple[Difference, ...]
    numbers: tuple[Difference, ...]
    figures: tuple[FigureChange, ...]
    unchanged_figures: tuple[str, ...]
    not_built: Mapping[str, tuple[str, ...]]

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
    tables = {name: path for name, path in before.items() if path.suffix != ".svg"}
    differences = [
        difference
        for name in tables
        if name in after
        for difference in _table(name, before[name], after[name])
    ]
    inputs = _inputs(baseline, changed, [d for d in differences if d.file == INPUTS])
    names = [name for name in figure_files(baseline) if f"figures/{name}.svg" in after]
    resting = [name for name in names if _rests_on_other_inputs(name, baseline, changed)]
    figures = [
        _figure(n, before[f"figures/{n}.svg"], after[f"figures/{n}.svg"])
        for n in sorted(names, key=lambda n: (n not in resting, n))
    ]
    return Changes(
        baseline=baseline,
        changed=changed,
        runs=tuple(_stamps(baseline, changed)),
        inputs=tuple(inputs),
        resting=tuple(resting),
        verdicts=tuple(d for d in differences if _topic(d) == "verdicts"),
        numbers=tuple(d for d in differences if _topic(d) == "numbers"),
        figures=tuple(figure for figure in figures if figure.what),
        unchanged_figures=tuple(figure.name for figure in figures if not figure.what),
        not_built={
            side: tuple(name for name in one if name not in other)
            for side, one, other in zip(SIDES, (after, before), (before, after), strict=True)
        },
    )


def _files(root: Path) -> dict[str, Path]:
    pictures = {f"figures/{name}.svg": path for name, path in figure_files(root).items()}
    return table_files(root) | pictures


def _topic(difference: Difference) -> str:
    if difference.file == INPUTS:
        return "inputs"
    # A claim that only one run has judged is a change of verdict, too.
    one_sided = difference.file == CLAIMS and not difference.column
    return "verdicts" if one_sided or difference.column == "verdict" else "numbers"


def _table(name: str, before: Path, after: Path) -> list[Difference]:
    cells = read_cells(before), read_cells(after)
    found = compare_tables(name, *cells, keys=key_columns(name), renamed=False)
    return _by_series(found) if name.startswith("data/") else found


def _by_series(differences: Sequence[Difference]) -> list[Difference]:
    """Tell points that one run alone has by their series: one difference each."""
    lone = [d for d in differences if d.kind in {"missing row", "extra row"}]
    points = Counter((d.kind, d.row.rpartition(" #")[0] or d.row) for d in lone)
    told = [
        Difference(
            file=lone[0].file,
            kind=kind,
            row=series,
            reference=f"{count} points" if kind == "missing row" else "",
            found=f"{count} points" if kind == "extra row" else "",
        )
        for (kind, series), count in points.items()
    ]
    return told + [d for d in differences if d.kind not in {"missing row", "extra row"}]


def _inputs(baseline: Path, changed: Path, numbers: Sequence[Difference]) -> list[Difference]:
    """Return changed inputs: of the configurations whole values, texts and lists among them."""
    left, right = (_stamp(root).get("config", {}) for root in (baseline, changed))
    found = [
        _text(INPUTS, f"config, {change.key}", _shown(change.shipped), _shown(change.used))
        for change in configured(right, left)
    ]
    told = {d.row for d in found}
    others = [d for d in numbers if _ITEM.sub("", d.row) not in told]
    return found + sorted(others, key=lambda d: d.column != "value")  # before its words


def _shown(value: object) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _rests_on_other_inputs(figure: str, baseline: Path, changed: Path) -> bool:
    """Tell whether a figure was made from other inputs in one run than in the other."""
    before, after = (recorded_inputs(root, f"figures/{figure}.svg") for root in (baseline, changed))
    return bool(before and after) and before != after


def _figure(name: str, baseline: Path, changed: Path) -> FigureChange:
    if baseline.read_bytes() == changed.read_bytes():
        what = ""
    else:
        shapes = read_shape(baseline), read_shape(changed)
        what = summary(compare_shapes(name, *shapes, PictureTolerance())) or UNSEEN
    return FigureChange(name=name, baseline=baseline, changed=changed, what=what)


def _stamps(baseline: Path, changed: Path) -> list[Difference]:
    left, right = (_told(_stamp(root)) for root in (baseline, changed))
    return [
        _text("run.json", key, left.get(key, ""), right.get(key, ""))
        for key in dict.fromkeys((*left, *right))
        if left.get(key) != right.get(key)
    ]


def _text(file: str, row: str, before: str, after: str) -> Difference:
    return Difference(
        file=file, kind="text", row=row, column="value", reference=before, found=after
    )


def _stamp(root: Path) -> dict[str, Any]:
    path = root / "run.json"
    return read_json(path) if path.exists() else {}


def _told(stamp: Mapping[str, Any]) -> dict[str, str]:
    """Return what a run stamp says of versions and commit; the inputs tell the configuration."""
    flat: dict[str, Any] = {}
    for key in sorted(stamp.keys() - {"config", "started", "ended"}):
        value = stamp[key]
        if isinstance(value, dict):
            flat |= {f"{key} {name}": part for name, part in value.items()}
        else:
            flat[key] = value
    return {key: _shown(value) for key, value in flat.items()}


def as_text(changes: Changes, few: int = 5) -> str:
    """Return the changes as Markdown."""
    parts = [f"# {changes.baseline} (baseline) and {changes.changed} (changed)"]
    parts += [f"{len(n)} files were not built in {root}." for root, n in lone_files(changes)]
    if changes.same:
        parts.append(SAME)
    for title, found, shown in sections(changes, few):
        if found:
            parts += [f"## {title}", markdown(found, shown, names=SIDES)]
        if title == "Inputs" and changes.resting:
            parts.append(f"Figures that rest on them: {', '.join(changes.resting)}.")
    if changes.figures:
        lines = [f"- {figure.name}: {figure.what}" for figure in changes.figures]
        parts += ["## Figures", "\n".join(lines)]
    return "\n\n".join(parts)


def lone_files(changes: Changes) -> list[tuple[Path, tuple[str, ...]]]:
    """Return for each folder that lacks files of the other which these are."""
    roots = (changes.baseline, changes.changed)
    found = [(root, changes.not_built[side]) for side, root in zip(SIDES, roots, strict=True)]
    return [(root, names) for root, names in found if names]


def sections(changes: Changes, few: int) -> list[tuple[str, tuple[Difference, ...], int]]:
    """Return title, differences and how many are shown; inputs and verdicts are shown all."""
    return [
        ("Runs", changes.runs, len(changes.runs)),
        ("Inputs", changes.inputs, len(changes.inputs)),
        ("Verdicts", changes.verdicts, len(changes.verdicts)),
        ("Numbers", changes.numbers, few),
    ]


def page(changes: Changes, few: int = 20) -> str:
    """Return the changes as one HTML page that needs nothing else, figures side by side.

    `changes`: what `compare` found; `few`: how many differences of each kind are shown per table of
    numbers.
    """
    return render(
        "compare.html",
        templates=Path(__file__).parent / "templates",
        changes=changes,
        sides=SIDES,
        same=SAME,
        lone_files=lone_files(changes),
        sections=[
            (title, [(file, *_in_page(each, shown)) for file, each in by_file(found).items()])
            for title, found, shown in sections(changes, few)
            if found
        ],
        inline=_inline,
    )


def _in_page(differences: Sequence[Difference], few: int) -> tuple[str, list[tuple[str, ...]], int]:
    """Return what is said of one file, its rows, and how many are not shown."""
    shown = [d for d in worst(differences, few) if not d.kind.endswith("file")]
    rows = [cells(difference, WIDTH) for difference in shown]
    return summary(differences), rows, len(differences) - len(shown)


def _inline(svg: Path) -> str:
    # As an image, and not as part of the page: no script in it runs, no name in it clashes.
    return "data:image/svg+xml;base64," + base64.b64encode(svg.read_bytes()).decode("ascii")
