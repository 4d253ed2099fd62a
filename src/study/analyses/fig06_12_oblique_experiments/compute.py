"""Oblique impacts as the article's laboratory measures them, by trajectory imaging (Figs. 6-12)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.experiment import Drop, Outcome, StopRule
from microimpact.lab.ptis.experiment import collect
from microimpact.lab.ptis.exposure import MEASURED
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.lab.reduction import QUANTITIES, interval_columns, quantities
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.statistics.distributions import child, generator, mean
from microimpact.statistics.intervals import mean_and_error
from study.contacts import intervals, printed_values_for
from study.declared.parameters import (
    AngleDegrees,
    Count,
    ExperimentSeed,
    Must,
    Name,
    ObliqueDegrees,
    Points,
    PrintedName,
)
from study.samples import Dropped, contact_of, in_class
from study.tables import Tables, series_frame

NEEDS = {"calibration": ("calibration",)}

# Child of an experiment's generator; the others serve the experiment.
UNSELECTED = 3

_frame = partial(series_frame, x_unit="deg", y_unit="1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A printed number drawn beside the points of a series: a value or both ends of a range.

    It is drawn at the angles that it is printed for, if it is printed of the impacts of the series.
    """

    figures: tuple[Name, ...]
    panel: Name
    printed: PrintedName
    angles_deg: tuple[AngleDegrees, ...] = ()  # Where none is printed


@dataclass(frozen=True, slots=True, kw_only=True)
class Series(Dropped):
    """One series of a figure: particles dropped, the figures that show it, and its marks."""

    figures: tuple[Name, ...]
    marks: dict[Name, Mark] = field(default_factory=dict)


def smooth_curves(
    series: Series, contact: Contact, angle: FloatArray
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return angle and quantity of impacts of the mean size, smooth and without spin.

    Captured impacts are left out.
    """
    impact = simulate(contact, series.speed_m_per_s, angle)
    rebound = ~impact.captured
    return {name: (angle[rebound], of[rebound]) for name, of in quantities(impact).items()}


def coulomb_curve(series: Series, contact: Contact, angle: FloatArray) -> FloatArray:
    """Return the impulse ratio of the rigid body model with Coulomb friction and no spin.

    Its restitution is that of a smooth sphere of the mean size at normal incidence.
    """
    e = simulate(contact, series.speed_m_per_s).coefficient_of_restitution
    v_n, v_t = velocity_components(series.speed_m_per_s, angle)
    rigid = rigid_body_rebound(v_n, v_t, 0.0, contact.radius, e, series.friction)
    return np.asarray(0.0 - rigid.mu)


ALL = {name: name for name in QUANTITIES}
FIGURES = {
    "fig06": ALL,
    "fig07": ALL,
    "fig08": {"restitution": "restitution"},
    "fig09": {"impulse_ratio": "impulse_ratio"},
    "fig10": {"energy_loss": "energy_loss"},
    "fig11": ALL,
    "fig12": ALL,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """All series over all angles."""

    seed: ExperimentSeed
    angles_deg: tuple[ObliqueDegrees, ...]
    stop: StopRule
    series: dict[Name, Series]
    dispenser: Dispenser
    instrument: ImagingSystem
    points: Points
    unselected: Count
    compared_with_all: tuple[Name, ...]
    compared_series: Name
    reference_angle_deg: Annotated[AngleDegrees, Must("one of", "angles_deg")]

    def __post_init__(self) -> None:
        """Refuse figures that this study does not make."""
        shown = [series.figures for series in self.series.values()]
        shown += [mark.figures for s in self.series.values() for mark in s.marks.values()]
        for figure in (figure for figures in shown for figure in figures):
            if figure not in FIGURES:
                raise ValueError(f"figures: {figure!r} must be one of {', '.join(FIGURES)}")
        compared = [("compared_with_all", name) for name in self.compared_with_all]
        for key, name in (("compared_series", self.compared_series), *compared):
            if name not in self.series:
                raise ValueError(f"{key}: {name!r} must be one of {', '.join(self.series)}")


def run(params: Params, inputs: Tables) -> Tables:
    """Run every series at every angle, observe, reduce.

    ``fig06`` to ``fig12``: restitution, impulse ratio and translational energy loss against the
    angle of incidence in degrees. ``fig23_points``: one series relative to its restitution at a
    reference angle. ``oblique_experiments``: one row per experiment.
    """
    contacts = {name: contact_of(series, inputs) for name, series in params.series.items()}
    rows = []
    for name, series in params.series.items():
        for angle in params.angles_deg:
            drop = series.drop(contacts[name], angle, params.dispenser).tabulated()
            rng = generator(params.seed, *drop.key)
            outcome = collect(drop, params.instrument, params.stop, rng)
            truth = restitution_of_rebounds(params, series, drop, child(rng, UNSELECTED))
            names = {"series": name, **impact_columns(series)}
            rows.append(names | experiment_row(angle, outcome, truth))
    table = pd.DataFrame(rows)
    return {
        **{of: figure_data(params, of, table, contacts, inputs) for of in FIGURES},
        "fig23_points": relative_points(params, table),
        "oblique_experiments": table,
    }


def restitution_of_rebounds(
    params: Params, series: Series, drop: Drop, rng: np.random.Generator
) -> float:
    """Return the true mean restitution of all rebounds of the class, seen or not; nan of too few.

    It is of more impacts than an experiment has, so that it shows what the imaging leaves out.
    """
    impacts = drop.impacts(params.unselected, rng)
    rebounds = impacts.select(in_class(series, impacts) & ~impacts.captured).in_plane
    if len(rebounds) < params.stop.fewest_events:
        return np.nan
    return float(np.mean(rebounds.coefficient_of_restitution))


def experiment_row(angle: float, outcome: Outcome, of_rebounds: float) -> dict[str, Any]:
    """Return one experiment as a row of the table: losses, measured means, and truth."""
    captured = outcome.impacts.captured
    true = outcome.true.coefficient_of_restitution
    return {
        "angle_deg": angle,
        "dropped": outcome.dropped,
        "events": len(outcome.measured),
        "captured_share": mean_and_error(captured)[0],
        "unobserved_share": 1.0 - outcome.fates.get(MEASURED, 0) / max(1, int(np.sum(~captured))),
        **interval_columns(outcome.means, *QUANTITIES, ends=("low", "high", "sd")),
        "true_restitution": mean_and_error(true)[0],
        "true_restitution_of_rebounds": of_rebounds,
        "evidence": "virtual experiment",
    }


def impact_columns(series: Series) -> dict[str, Any]:
    """Return the impacts of a series as columns: contact, mean size, nominal speed and the rest."""
    return {
        "case": series.case,
        "diameter_um": mean(series.diameter_um),
        "speed_m_per_s": series.speed_m_per_s,
        "friction": series.friction,
        "slope_sd": series.slope_sd,
        "spin_mean": series.spin.mean,
        "spin_sd": series.spin.sd,
    }


def figure_data(
    params: Params,
    figure: str,
    table: pd.DataFrame,
    contacts: Mapping[str, Contact],
    inputs: Tables,
) -> pd.DataFrame:
    """Return the data of one figure: points, curves, Coulomb friction, printed marks."""
    frames = [
        *_points(params, figure, FIGURES[figure], table),
        *_rebounds(params, figure, table),
        *_curves(params, figure, contacts),
    ]
    for series_name, series in _drawn(params, figure).items():
        printed = printed_of(series, contacts[series_name], inputs)
        for name, mark in series.marks.items():
            if figure in mark.figures and mark.printed in printed.index:
                row = printed.loc[mark.printed]
                heights = row[["value", "low", "high"]].dropna().to_numpy(float)
                angles = [end for ends in intervals(row["angle_deg"]) for end in ends]
                x, y = np.broadcast_arrays(np.array(angles or mark.angles_deg)[:, None], heights)
                frames.append(_frame(mark.panel, name, x.ravel(), y.ravel(), "printed"))
    return pd.concat(frames, ignore_index=True)


def _drawn(params: Params, figure: str) -> dict[str, Series]:
    """Return the series of a figure, by name."""
    return {name: series for name, series in params.series.items() if figure in series.figures}


def printed_of(series: Series, contact: Contact, inputs: Tables) -> pd.DataFrame:
    """Return the printed values of the impacts of a series."""
    pair = contact.particle.name, contact.surface.name
    size, speed = mean(series.diameter_um), series.speed_m_per_s
    return printed_values_for(inputs, *pair, diameter_um=size, speed_m_per_s=speed)


def relative_points(params: Params, table: pd.DataFrame) -> pd.DataFrame:
    """Return restitution less its value at the reference angle, and the impulse ratio.

    Without enough events at the reference angle there is nothing to compare with.
    """
    rows = table[table["series"] == params.compared_series]
    zero = rows.loc[rows["angle_deg"] == params.reference_angle_deg, "restitution"].iloc[0]
    quantities = (("restitution", zero), ("impulse_ratio", 0.0))
    return pd.concat([_means(rows, name, less) for name, less in quantities], ignore_index=True)


def _means(rows: pd.DataFrame, quantity: str, less: float = 0.0) -> pd.DataFrame:
    """Return the means of the experiments of a series that have one, as figure data."""
    shown = rows[(rows[quantity] - less).notna()]
    y, low, high = (shown[f"{quantity}{end}"] - less for end in ("", "_low", "_high"))
    name = str(rows["series"].iloc[0])
    return _frame(quantity, name, shown["angle_deg"], y, "virtual experiment", low, high)


def _points(
    params: Params, figure: str, panels: Mapping[str, str], table: pd.DataFrame
) -> Iterator[pd.DataFrame]:
    for name in _drawn(params, figure):
        for panel, quantity in panels.items():
            yield _means(table[table["series"] == name], quantity).assign(panel=panel)


def _rebounds(params: Params, figure: str, table: pd.DataFrame) -> Iterator[pd.DataFrame]:
    for name in params.compared_with_all if "restitution" in FIGURES[figure] else ():
        if figure in params.series[name].figures:
            rows = table[table["series"] == name].dropna(subset="true_restitution_of_rebounds")
            angle, mean = rows["angle_deg"], rows["true_restitution_of_rebounds"]
            yield _frame("restitution", f"{name}, all rebounds", angle, mean)


def _curves(params: Params, figure: str, contacts: Mapping[str, Contact]) -> Iterator[pd.DataFrame]:
    angle = np.linspace(0.0, 90.0, params.points + 1)[1:]
    shown = _drawn(params, figure)
    for name, series in shown.items():
        curves = smooth_curves(series, contacts[name], angle)
        for panel in FIGURES[figure]:
            yield _frame(panel, f"{name}, smooth", *curves[panel])
    if "impulse_ratio" in FIGURES[figure]:
        name, series = next(iter(shown.items()))
        curve = coulomb_curve(series, contacts[name], angle)
        yield _frame("impulse_ratio", "Coulomb friction", angle, curve)
