"""Oblique impacts as the article's laboratory measures them, by trajectory imaging (Figs. 6-12)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.declared.parameters import (
    AngleDegrees,
    CaseName,
    Count,
    Fraction,
    Keyed,
    Name,
    NonNegative,
    Positive,
    PrintedName,
)
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.experiment import Target, combined_slope
from microimpact.lab.ptis.experiment import Collected, Recipe, collect, quantities, reduced
from microimpact.lab.ptis.system import Instrument
from microimpact.lab.reduction import Mean
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.statistics.distributions import Distribution, generator, mean

NEEDS = {"calibration": ("calibration",)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """One series of a figure: particles, surface, speed class and spin."""

    name: Name
    figures: tuple[Name, ...]
    case: CaseName
    friction: Fraction
    diameter_um: Distribution
    surface_slope: NonNegative
    particle_slope: NonNegative
    speed_m_per_s: Positive
    speed_range_m_per_s: tuple[Positive, Positive]
    spin: InitialSpin

    def __post_init__(self) -> None:
        """Refuse a class that does not ascend."""
        low, high = self.speed_range_m_per_s
        if low >= high:
            raise ValueError(f"speed_range_m_per_s: [{low:g}, {high:g}] must ascend")


def series_contact(series: Series, inputs: Mapping[str, pd.DataFrame]) -> Contact:
    """Return the contact of a series, at the mean diameter."""
    contact = calibrated_contact(inputs, series.case).replace(friction=series.friction)
    return resized(contact, mean(series.diameter_um) * 1e-6)


def recipe(
    series: Series, contact: Contact, dispenser: Dispenser, instrument: Instrument
) -> Recipe:
    """Return what the laboratory needs to know of a series."""
    return Recipe(
        target=Target(
            contact=contact, slope_sd=combined_slope(series.surface_slope, series.particle_slope)
        ),
        diameter_um=series.diameter_um,
        speed=series.speed_m_per_s,
        speed_range=series.speed_range_m_per_s,
        dispenser=dispenser,
        spin=series.spin,
        instrument=instrument,
    )


def smooth_curves(
    series: Series, contact: Contact, angle: FloatArray
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return angle and quantity of impacts of the mean size, smooth and without spin.

    Captured impacts are left out.
    """
    impact = simulate(contact, series.speed_m_per_s, angle)
    rebound = ~impact.captured
    return {
        "restitution": (angle[rebound], impact.coefficient_of_restitution[rebound]),
        "impulse_ratio": (angle[rebound], impact.impulse_ratio[rebound]),
        "energy_loss": (angle[rebound], impact.translational_energy_loss[rebound]),
    }


def coulomb_curve(
    series: Series, contact: Contact, angle: FloatArray, restitution: float
) -> FloatArray:
    """Return the impulse ratio of the rigid body model with Coulomb friction and no spin."""
    v_n, v_t = velocity_components(series.speed_m_per_s, angle)
    rigid = rigid_body_rebound(v_n, v_t, 0.0, contact.radius, restitution, series.friction)
    return np.asarray(0.0 - rigid.mu)


FIGURES = {
    "fig06": ("restitution", "impulse_ratio", "energy_loss"),
    "fig07": ("restitution", "impulse_ratio", "energy_loss"),
    "fig08": ("restitution",),
    "fig09": ("impulse_ratio",),
    "fig10": ("energy_loss",),
    "fig11": ("restitution", "impulse_ratio", "energy_loss"),
    "fig12": ("restitution", "impulse_ratio", "energy_loss"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A printed number drawn beside the points: a value or both ends of a range, at angles."""

    figures: tuple[Name, ...]
    panel: Name
    name: Name
    anchors: tuple[PrintedName, ...]
    angles_deg: tuple[AngleDegrees, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """All series over all angles."""

    seed: Annotated[int, Field(ge=0)]
    angles_deg: tuple[Annotated[float, Field(gt=0, lt=90)], ...]
    events: Annotated[int, Field(ge=2)]
    fewest_events: Annotated[int, Field(ge=2)]
    most_dropped: Count
    series: Annotated[tuple[Series, ...], Keyed("name")]
    dispenser: Dispenser
    instrument: Instrument
    coulomb_restitution: Fraction
    points: Annotated[int, Field(ge=10)]
    compared_series: Name
    reference_angle_deg: AngleDegrees
    marks: Annotated[tuple[Mark, ...], Keyed("name")]

    def __post_init__(self) -> None:
        """Refuse figures that this study does not make."""
        named = [*(s.figures for s in self.series), *(m.figures for m in self.marks)]
        for figure in (name for names in named for name in names):
            if figure not in FIGURES:
                raise ValueError(f"figures: {figure!r} must be one of {', '.join(FIGURES)}")
        names = [series.name for series in self.series]
        if self.compared_series not in names:
            raise ValueError(
                f"compared_series: {self.compared_series!r} must be one of {', '.join(names)}"
            )
        if self.reference_angle_deg not in self.angles_deg:
            raise ValueError(
                f"reference_angle_deg: {self.reference_angle_deg:g} must be one of angles_deg"
            )


class Point(NamedTuple):
    """One plotted point: series, quantity, nominal angle (degrees) and mean."""

    series: str
    quantity: str
    angle: float
    mean: Mean


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Run every series at every angle, observe, reduce.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``calibration``: calibrated contacts; ``materials``: declared rows; ``anchors``: printed
        values.

    Returns
    -------
    mapping
        ``fig06`` to ``fig12``: restitution, impulse ratio and translational energy loss against
        the angle of incidence in degrees. ``fig23_points``: one series relative to its restitution
        at a reference angle. ``oblique_experiments``: one row per experiment.
    """
    contacts = {series.name: series_contact(series, inputs) for series in params.series}
    rows, points = list[dict[str, Any]](), list[Point]()
    for i, series in enumerate(params.series):
        dropped = recipe(series, contacts[series.name], params.dispenser, params.instrument)
        for k, angle in enumerate(params.angles_deg):
            rng = generator(params.seed, i, k)
            outcome = collect(dropped, angle, params.events, params.most_dropped, rng)
            enough = len(outcome.measured) >= params.fewest_events
            error = params.instrument.angle_error_deg
            means = reduced(outcome.measured, error) if enough else {}
            rows.append(experiment_row(series, angle, outcome, means))
            points += [Point(series.name, name, angle, of) for name, of in means.items()]
    printed = inputs["anchors"].set_index("key")
    figures = {figure: figure_data(params, figure, points, contacts, printed) for figure in FIGURES}
    return {
        **figures,
        "fig23_points": relative_points(params, points),
        "oblique_experiments": pd.DataFrame(rows),
    }


def experiment_row(
    series: Series, angle: float, outcome: Collected, found: Mapping[str, Mean]
) -> dict[str, Any]:
    """Return one experiment as a row of the table: what was seen, measured, and true."""
    arrived = outcome.captured + outcome.rebounded
    row: dict[str, Any] = {
        "series": series.name,
        "angle_deg": angle,
        "dropped": outcome.dropped,
        "events": len(outcome.measured),
        "captured_share": outcome.captured / arrived if arrived else np.nan,
        "unobserved_share": 1.0 - outcome.fates.get("measured", 0) / max(1, outcome.rebounded),
    }
    for name in quantities(outcome.measured):
        of = found.get(name)
        row[name] = of.value if of else np.nan
        row[f"{name}_low"] = of.low if of else np.nan
        row[f"{name}_high"] = of.high if of else np.nan
        row[f"{name}_sd"] = of.sd if of else np.nan
    true = outcome.true_restitution
    row["true_restitution"] = float(np.mean(true)) if true.size else np.nan
    row["evidence"] = "virtual experiment"
    return row


def figure_data(
    params: Params,
    figure: str,
    points: list[Point],
    contacts: Mapping[str, Contact],
    printed: pd.DataFrame,
) -> pd.DataFrame:
    """Return the data of one figure: points, smooth curves, Coulomb friction, printed marks."""
    frames = [*_points(params, figure, points), *_curves(params, figure, contacts)]
    for mark in params.marks:
        if figure in mark.figures:
            values = printed.loc[list(mark.anchors), ["value", "low", "high"]].astype(float)
            heights = values.to_numpy().ravel()
            heights = heights[np.isfinite(heights)]
            x, y = np.broadcast_arrays(np.array(mark.angles_deg)[:, None], heights)
            frames.append(_frame(mark.panel, mark.name, x.ravel(), y.ravel(), "printed"))
    return pd.concat(frames, ignore_index=True)


def relative_points(params: Params, points: list[Point]) -> pd.DataFrame:
    """Return restitution less its value at the reference angle, and the impulse ratio."""
    own = [p for p in points if p.series == params.compared_series]
    at = [
        p.mean.value
        for p in own
        if p.quantity == "restitution" and p.angle == params.reference_angle_deg
    ]
    frames = []
    # Without enough events at the reference angle there is nothing to compare with.
    for quantity, zero in (("restitution", at[0] if at else np.nan), ("impulse_ratio", 0.0)):
        shown = [p for p in own if p.quantity == quantity and np.isfinite(zero)]
        frames.append(
            _frame(
                quantity,
                params.compared_series,
                [p.angle for p in shown],
                [p.mean.value - zero for p in shown],
                "virtual experiment",
                [p.mean.low - zero for p in shown],
                [p.mean.high - zero for p in shown],
            )
        )
    return pd.concat(frames, ignore_index=True)


def _points(params: Params, figure: str, points: list[Point]) -> Iterator[pd.DataFrame]:
    for series in params.series:
        for panel in FIGURES[figure] if figure in series.figures else ():
            own = [p for p in points if p.series == series.name and p.quantity == panel]
            yield _frame(
                panel,
                series.name,
                [p.angle for p in own],
                [p.mean.value for p in own],
                "virtual experiment",
                [p.mean.low for p in own],
                [p.mean.high for p in own],
            )


def _curves(params: Params, figure: str, contacts: Mapping[str, Contact]) -> Iterator[pd.DataFrame]:
    angle = np.linspace(0.0, 90.0, params.points + 1)[1:]
    own = [series for series in params.series if figure in series.figures]
    for series in own:
        curves = smooth_curves(series, contacts[series.name], angle)
        for panel in FIGURES[figure]:
            yield _frame(panel, f"{series.name}, smooth", *curves[panel])
    if "impulse_ratio" in FIGURES[figure]:
        curve = coulomb_curve(own[0], contacts[own[0].name], angle, params.coulomb_restitution)
        yield _frame("impulse_ratio", "Coulomb friction", angle, curve)


def _frame(
    panel: str,
    series: str,
    x: ArrayLike,
    y: ArrayLike,
    evidence: str = "computed",
    y_low: ArrayLike = np.nan,
    y_high: ArrayLike = np.nan,
) -> pd.DataFrame:
    return series_frame(
        panel=panel,
        series=series,
        evidence=evidence,
        x=x,
        y=y,
        x_unit="deg",
        y_unit="1",
        y_low=y_low,
        y_high=y_high,
    )
