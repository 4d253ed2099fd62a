"""How often the intervals of the capture velocity hold it, on made-up rebounds.

    python -m benchmarks.coverage [--averaged [NAME ...]] [--sets N] [--predicted] [--alone]

`--averaged` computes designs of benchmarks/coverage/averaged.csv, by name or, without one, those
that have no result yet: intervals of `compare_models`. `--predicted` does so for contacts that
`calibrate_laws` draws at one size, asked for the capture velocity of others, and `--alone` for
Eq. (34) alone. Results go into that folder, and the pictures in docs/images are drawn anew.

Data sets have the restitution of a true curve with noise, over speeds from a lowest one upwards.
Every design has random numbers of its own, by what it is, so that designs are independent and none
changes with the others.
"""

from __future__ import annotations

import argparse
import csv
import zlib
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from microimpact.core.arrays import FloatArray
from microimpact.core.declared import materials
from microimpact.model.calibration import two_stage
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.comparison import Comparison, compare_sets
from microimpact.model.empirical.data import data_sets
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.intervals import interval_batch
from microimpact.model.empirical.search import fit_batch
from microimpact.model.posterior import NoConvergenceError, calibrate_laws
from microimpact.statistics.distributions import generator
from microimpact.statistics.intervals import wilson_interval

PROJECT = Path(__file__).parents[1]
FOLDER, IMAGES = Path(__file__).with_suffix(""), PROJECT / "docs" / "images"
SEED, ANALYSIS, SETS, POINTS, HIGHEST, CONFIDENCE = 3349723591, 34, 300, 20, 15.0, 0.95
# Sizes, over that measured, at which contacts are to predict the capture velocity, and how surely.
SIZES, LEVEL = (1.0 / 3.0, 0.5, 1.0, 2.0), 0.9
EQ_34, FOREIGN, BETWEEN = "Eq. 34", "foreign curve", "ring force, n = 0.7"
RATES = {"steel-silicon, n = 0": 0.0, "steel-silicon, n = 1": 1.0, BETWEEN: 0.7}
WORK = {0.0: 3.5, 1.0: 0.7}  # J/m2, as the study calibrates steel on silicon
# True laws by w_A in J/m2, near the least squares to the printed restitutions and v_c of steel.
LAWS = {
    "viscous JKR": (JKR(viscous_time=10.47622e-9), 4.77547),
    "Thornton-Ning": (ThorntonNing(yield_pressure=1.643005e9), 8.88597),
}
# Eq. (34) alone: true curves, noise and lowest speeds.
ALONE = product((EQ_34, "simulation"), (0.01, 0.03), (1.05, 1.2, 1.5, 3.0))
# e = 0.85 sqrt(1 - (v_c/v)^2) (v_c/v)^(1/4), which no model has.
LARGEST_E, FALL = 0.85, 0.25
# v_c ~ 1/d^n of the curves without a contact: Dahneke (1971), and the work of a JKR contact.
EXPONENTS = {EQ_34: 1.0, FOREIGN: 5.0 / 6.0}
# k, p, kappa, q, v_c of Eq. (34) with q = 1/2 as the study fits it to the ring force with n = 0.
FITTED = (14.037122, 0.82066226, 0.065333442, 0.5, 0.1891244)
Row = dict[str, Any]


class Design(NamedTuple):
    """A true curve, the standard deviation of e, and the lowest speed in v_c."""

    truth: str
    noise_of_e: float
    lowest_speed_in_v_c: float


class Spheres(NamedTuple):
    """Relative standard deviations of diameters and speeds, and whether captured ones are kept."""

    size_scatter: float = 0.0
    speed_error: float = 0.0
    captured: str = "dropped"  # or "kept"


class Analysis(NamedTuple):
    """Knowledge that a fit has of the errors."""

    sigma: str  # "given", or "estimated"
    scatter: str  # "exact": nothing of sizes and speeds; "given"; "free": the sizes are to be found
    models: str  # "all", or the name of one


class Trial(NamedTuple):
    """Data sets of one kind and their analysis."""

    design: Design
    spheres: Spheres
    analysis: Analysis


ALIKE = Spheres()


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.coverage")
    parser.add_argument("--averaged", nargs="*", metavar="NAME")
    parser.add_argument("--predicted", action="store_true")
    parser.add_argument("--alone", action="store_true")
    parser.add_argument("--sets", type=int, default=SETS, help="of each design")
    options = parser.parse_args(arguments)
    if options.averaged is not None:
        table = read("averaged")
        for row in table:
            if row["design"] in options.averaged or not (options.averaged or row["sets"]):
                row.update(averaged(trial_of(row), options.sets))
                write("averaged", table)
                print(row["design"], row["held"], "of", row["sets"], flush=True)
    if options.predicted:
        write("predicted", predicted(options.sets))
    if options.alone:
        write("alone", alone(options.sets))
    draw()


def read(name: str) -> list[Row]:
    with (FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write(name: str, rows: Iterable[Row]) -> None:
    rows = list(rows)
    with (FOLDER / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def trial_of(row: Row) -> Trial:
    """What a row of the table of designs says."""
    numbers = {"noise_of_e", "lowest_speed_in_v_c", "size_scatter", "speed_error"}
    cells = {name: float(cell) if name in numbers else cell for name, cell in row.items()}
    kinds = (Design, Spheres, Analysis)
    return Trial(*(kind(**{name: cells[name] for name in kind._fields}) for kind in kinds))


@cache
def true_contact(truth: str) -> Contact:
    """Contact of v_c = 0.18 m/s, steel on silicon, whose simulated restitution is a true curve."""
    if truth in LAWS:
        return true_contact("steel-silicon, n = 0").by_law(*LAWS[truth])
    rate = RATES.get(truth, 0.0)
    bodies = {"particle": materials["stainless-steel-316"], "surface": materials["silicon"]}
    start = Contact(
        **bodies,
        diameter=62e-6,
        work_of_adhesion=WORK.get(rate, WORK[0.0]),
        adhesion_rate_exponent=round(rate),
        reference_velocity=1.66,
    )
    contact = two_stage(start, 1.66, 0.7, 0.18).contact
    if truth != BETWEEN:
        return contact
    contact = true_contact("steel-silicon, n = 0")
    limit = float(capture_velocity(contact))
    return contact.replace(adhesion_rate_exponent=rate, reference_velocity=limit)


def true_curve(truth: str, ratio: FloatArray, size: FloatArray | float = 1.0) -> FloatArray:
    """True restitution at speeds over the v_c of the median sphere, and diameters over its own."""
    if truth not in EXPONENTS:
        contact = true_contact(truth)
        sized = contact.replace(diameter=size * contact.diameter)
        return simulate(sized, ratio * capture_velocity(contact)).coefficient_of_restitution
    limit = size ** -EXPONENTS[truth]
    if truth == FOREIGN:
        share = np.minimum(limit / ratio, 1.0)
        return np.asarray(LARGEST_E * np.sqrt(1.0 - share**2) * share**FALL)
    # All speeds of a smaller sphere are higher by as much as its v_c.
    return restitution(ratio / limit * FITTED[-1], *FITTED)


def measured(design: Design, spheres: Spheres, sets: int) -> tuple[FloatArray, FloatArray]:
    """Speeds in true v_c and measured restitutions, 0 where none is seen, both (sets, n)."""
    ratio = np.geomspace(design.lowest_speed_in_v_c, HIGHEST, POINTS)
    kind = (design,) if spheres == ALIKE else (design, spheres)
    rng = generator(SEED, ANALYSIS, *(zlib.crc32(repr(part).encode()) for part in kind))
    noise, sizes, errors = rng.standard_normal((3, sets, POINTS))
    size = np.exp(spheres.size_scatter * sizes) if spheres.size_scatter else 1.0
    curve = true_curve(design.truth, ratio, size)
    e = np.clip(curve + design.noise_of_e * noise, 0.0, 1.0)
    return ratio * np.exp(spheres.speed_error * errors), np.where(curve > 0.0, e, 0.0)


def coverage(ends: FloatArray) -> Row:
    """Share of intervals (sets, 2) that hold the true v_c, which is 1, and their median width."""
    held = int(np.sum((ends[:, 0] <= 1.0) & (ends[:, 1] >= 1.0)))
    low, high = wilson_interval(held, len(ends))
    return {
        "sets": len(ends),
        "held": held,
        "coverage": held / len(ends),
        "coverage_low": low,
        "coverage_high": high,
        "median_width": float(np.median(np.diff(ends))),
    }


def averaged(trial: Trial, sets: int) -> Row:
    """Coverage, width and warnings of the average of models in one design."""
    data = [arguments(trial, v, e) for v, e in zip(*measured(*trial[:2], sets), strict=True)]
    models = None if trial.analysis.models == "all" else [trial.analysis.models]
    found: list[Comparison] = compare_sets(data, confidence=CONFIDENCE, models=models)
    ends = np.array([comparison.v_c_interval for comparison in found])
    warned = np.array([bool(comparison.warnings) for comparison in found])
    missed = (ends[:, 0] > 1.0) | (ends[:, 1] < 1.0)
    return coverage(ends) | {
        "warned": float(warned.mean()),
        "missed_without_warning": int(np.sum(missed & ~warned)),
    }


def arguments(trial: Trial, v: FloatArray, e: FloatArray) -> tuple[Any, ...]:
    """Arguments of `compare_models` for one data set (n,)."""
    design, spheres, analysis = trial
    kept = (e > 0.0) | (spheres.captured == "kept")
    sigma = design.noise_of_e if analysis.sigma == "given" else None
    if analysis.scatter == "exact":
        return v[kept], e[kept], sigma
    size = "free" if analysis.scatter == "free" else spheres.size_scatter
    return v[kept], e[kept], sigma, spheres.speed_error * v[kept], None, size


def predicted(sets: int) -> Iterator[Row]:
    """Rows of capture velocities at other sizes, from contacts that rebounds of one size admit."""
    for truth in (BETWEEN, "viscous JKR"):
        contact = true_contact(truth)
        v_c = float(capture_velocity(contact))
        design = Design(truth, 0.01, 1.05)
        intervals = []
        for ratio, e in zip(*measured(design, ALIKE, sets), strict=True):
            kept = e > 0.0
            try:
                drawn = calibrate_laws(contact, ratio[kept] * v_c, e[kept], design.noise_of_e)
            except NoConvergenceError:
                continue
            limits = drawn.of_all(_at_other_sizes)
            intervals.append(np.quantile(limits, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=1))
        shares = np.transpose(intervals) / _at_other_sizes(contact)[:, None, None]
        for size, ends in zip(SIZES, np.swapaxes(shares, 1, 2), strict=True):
            left = {"without_convergence": sets - len(ends)}
            yield {**design._asdict(), "size": size, **coverage(ends), **left}


def _at_other_sizes(contact: Contact) -> FloatArray:
    """Capture velocities of `SIZES`, over that measured, (sizes, ...)."""
    sizes = np.reshape(SIZES, (-1,) + (1,) * len(contact.shape))
    return capture_velocity(contact.replace(diameter=sizes * contact.diameter))


def alone(sets: int) -> Iterator[Row]:
    """Rows of Eq. (34) alone, by its profile likelihood, with q free and fixed."""
    for (truth, noise, lowest), q in product(tuple(ALONE), (None, 0.5)):
        design = Design(truth, noise, lowest)
        ratio, e = measured(design, ALIKE, sets)
        data = data_sets(ratio, e, (e > 0.0) / noise, q)
        fit = fit_batch(data)
        limit = float(scipy.special.chdtri(1.0, 1.0 - CONFIDENCE))
        error = fit.v_c - 1.0
        yield {
            **design._asdict(),
            "exponent": "free" if q is None else "fixed",
            **coverage(interval_batch(data, fit, limit).ends),
            "bias": float(np.mean(error)),
            "rms_error": float(np.sqrt(np.mean(error**2))),
            "v_c_on_bound": float(np.mean(fit.capture_on_bound)),
        }


MARKS = {
    EQ_34: ("#000000", "o"),
    "steel-silicon, n = 0": ("#d55e00", "s"),
    BETWEEN: ("#0072b2", "^"),
    "steel-silicon, n = 1": ("#0072b2", "^"),
    "viscous JKR": ("#009e73", "D"),
    "Thornton-Ning": ("#cc79a7", "v"),
    FOREIGN: ("#888888", "x"),
}


def draw() -> None:
    """Draw both pictures of the documentation."""
    style = {"svg.hashsalt": "microimpact", "svg.fonttype": "none", "font.size": 9.0}
    with mpl.rc_context(style | {"legend.fontsize": 7.5}):
        _draw_averaged(read("averaged"), read("predicted"))
        _draw_alone(read("alone"))


def _draw_averaged(table: list[Row], predictions: list[Row]) -> None:
    """Coverage over the scatter of v_c taken as exact, and allowed for; that at other sizes."""
    figure, (exact, allowed, sizes) = _figure(3, 3.4)
    for axes, title, told in ((exact, "taken as exact", False), (allowed, "given or found", True)):
        rows = [row for row in table if (row["scatter"] != "exact") == told and row["sets"]]
        x = [
            100.0 * np.hypot(float(row["size_scatter"]), float(row["speed_error"])) for row in rows
        ]
        # Marks of the same scatter stand side by side.
        apart = [0.12 * (x[:i].count(at) - 0.5 * (x.count(at) - 1)) for i, at in enumerate(x)]
        _bars(axes, rows, [at + off for at, off in zip(x, apart, strict=True)])
        axes.set(title=title, xlabel="scatter of sizes and speeds (%)", ylim=(0.3, 1.02))
        axes.axhline(CONFIDENCE, color="#555555", linestyle=":")
    _bars(sizes, predictions, [float(row["size"]) for row in predictions])
    sizes.set(title="predicted at other sizes", xlabel="diameter over that measured", xscale="log")
    sizes.set_xticks(SIZES, ["1/3", "1/2", "1", "2"], minor=False)
    sizes.minorticks_off()
    sizes.set_ylim(0.7, 1.02)
    sizes.axhline(LEVEL, color="#555555", linestyle=":")
    exact.set_ylabel("share of intervals with $v_c$")
    _save(figure, (exact, sizes), "averaged_coverage")


def _draw_alone(table: list[Row]) -> None:
    """Coverage, and errors of v_c, of Eq. (34) alone over the lowest speed."""
    figure, panels = _figure(3, 3.6)
    columns = {
        "coverage": "coverage",
        "rms_error": "rms error of $v_c$",
        "bias": "mean error of $v_c$",
    }
    for axes, (column, words) in zip(panels, columns.items(), strict=True):
        for truth, noise, exponent in product(
            (EQ_34, "simulation"), ("0.01", "0.03"), ("free", "fixed")
        ):
            kind = truth, noise, exponent
            rows = [r for r in table if (r["truth"], r["noise_of_e"], r["exponent"]) == kind]
            axes.plot(
                [float(row["lowest_speed_in_v_c"]) for row in rows],
                [float(row[column]) for row in rows],
                marker="s" if noise == "0.01" else "^",
                color="#0072b2" if truth == EQ_34 else "#d55e00",
                fillstyle="none" if exponent == "free" else "full",
                linestyle="--" if exponent == "free" else "-",
                linewidth=0.8,
                label=f"{truth}, $\\sigma_e$ = {noise}, $q$ {exponent}",
            )
        axes.set(title=words, xlabel="lowest speed over $v_c$", xscale="log")
        axes.set_xticks([1.05, 1.5, 2.0, 3.0], ["1.05", "1.5", "2", "3"])
        axes.minorticks_off()
    panels[0].axhline(CONFIDENCE, color="#555555", linestyle=":")
    panels[1].set_yscale("log")
    _save(figure, panels[:1], "capture_recovery")


def _bars(axes: Axes, rows: list[Row], x: list[float]) -> None:
    """Marks of a coverage with its 95 % interval, by true curve."""
    for truth, (colour, mark) in MARKS.items():
        points = [
            (at, *(float(row[name]) for name in ("coverage", "coverage_low", "coverage_high")))
            for at, row in zip(x, rows, strict=True)
            if row["truth"] == truth
        ]
        if points:
            at, middle, low, high = np.array(points).T
            label = truth.replace("steel-silicon", "ring force")
            ends = [middle - low, high - middle]
            axes.errorbar(
                at, middle, ends, fmt=mark, color=colour, markersize=4, lw=0.8, label=label
            )


def _figure(columns: int, height: float) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(9.6, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, columns)


def _save(figure: Figure, keyed: Iterable[Axes], name: str) -> None:
    handles: dict[str, Any] = {}
    for axes in keyed:
        handles |= {h.get_label(): h for h in axes.get_legend_handles_labels()[0]}
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False
    )
    figure.savefig(IMAGES / f"{name}.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
