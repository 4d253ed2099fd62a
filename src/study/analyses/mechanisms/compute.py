"""Mechanisms that the article supposes behind its measured means, each alone (2.4, 3.1.4)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.lab.dispenser import Dispenser
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.statistics.intervals import student_half_width
from study.analyses.mechanisms.loss import Loss, loss_tables
from study.analyses.mechanisms.shallow import (
    Curve,
    Shallow,
    adhesion_or_roughness,
    shallow_curves,
    shallow_series,
)
from study.analyses.mechanisms.slope import Slope, slope_tables
from study.analyses.mechanisms.spin import Spin, spin_tables
from study.analyses.mechanisms.spore import CAMERA, Spore, spore_tables
from study.contacts import pair_of, printed_values_for
from study.declared.parameters import CaseName, Count
from study.samples import Sampling
from study.tables import Tables, series_frame

NEEDS = {"calibration": ("calibration",)}
PRINTED_VALUES = ("restitution_lycopodium_silicon_48deg", "restitution_lycopodium_silicon_38deg")

# What is drawn of what is tried: angles, and causes of the restitution of spores.
DRAWN_DEG = (85.0, 45.0, 20.0, 15.0)
DRAWN_MECHANISMS = ("none", "slopes", "slopes of 0.06", "off centre, 0.2", CAMERA)

_frame = partial(series_frame, x_unit="deg", y_unit="1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """All mechanisms, on common random numbers."""

    seed: Annotated[int, Field(ge=0)]
    impacts: Count
    events: Annotated[int, Field(ge=2)]
    dispenser: Dispenser
    instrument: ImagingSystem
    spin: Spin
    slope: Slope
    spore: Spore
    shallow: Shallow
    loss: Loss
    drawn_case: CaseName

    @property
    def sampling(self) -> Sampling:
        """Samples of all mechanisms."""
        return Sampling(
            seed=self.seed,
            impacts=self.impacts,
            events=self.events,
            angle_error_deg=self.instrument.angle_error_deg,
            dispenser=self.dispenser,
        )


def run(params: Params, inputs: Tables) -> Tables:
    """Quantify every mechanism.

    Spin: ``spin_mechanism``, ``spin_needed``, ``spin_or_tilt``. Slopes: ``slope_mechanism``,
    ``surface_pairs``, ``formica_mechanism``. Spores: ``spore_mechanism``, ``spore_trends``,
    ``spore_comparison``, ``smooth_spore``. Shallow angles: ``adhesion_or_roughness``. Energy loss:
    ``loss_slopes``, ``loss_resolution``. ``causes``, ``causes_slope``, ``causes_shallow``: data of
    the figure.
    """
    sampling = params.sampling
    curves = shallow_curves(params.shallow, sampling, inputs)
    tables = {
        **spin_tables(params.spin, sampling, inputs),
        **slope_tables(params.slope, sampling, inputs),
        **spore_tables(params.spore, sampling, params.instrument, inputs),
        "adhesion_or_roughness": pd.DataFrame(adhesion_or_roughness(params.shallow, curves)),
        **loss_tables(params.loss, sampling, inputs),
    }
    printed = printed_values_for(inputs, *pair_of(inputs, params.spore.spore.case))
    return {**tables, **figure_data(params, tables, curves, printed)}


def figure_data(
    params: Params,
    tables: Tables,
    curves: Mapping[tuple[str, str], tuple[Curve, Curve]],
    printed: pd.DataFrame,
) -> dict[str, pd.DataFrame]:
    """Return the data of the figure, a table per unit of its abscissa."""
    case = params.drawn_case
    spin = tables["spin_mechanism"].query("case == @case")
    slope = tables["slope_mechanism"].query("case == @case")
    slope = slope[slope["angle_deg"].isin(DRAWN_DEG)]
    spore = tables["spore_mechanism"]
    spore = spore[spore["mechanism"].isin(DRAWN_MECHANISMS)]
    frames = {
        "causes": [*_spin_frames(spin), *_spore_frames(params, spore, printed)],
        "causes_slope": _slope_frames(slope),
        "causes_shallow": (
            _frame("shallow", f"{cause}, {which}", x, y, x_unit="m_per_s")
            for cause, which, x, y in shallow_series(curves, case)
        ),
    }
    return {name: pd.concat(list(parts), ignore_index=True) for name, parts in frames.items()}


def _spin_frames(table: pd.DataFrame) -> Iterator[pd.DataFrame]:
    for (mean, sd), rows in table.groupby(["spin_mean", "spin_sd"], sort=False):
        yield _frame("spin", f"mean {mean:g}, sd {sd:g}", rows["angle_deg"], rows["impulse_ratio"])


def _slope_frames(table: pd.DataFrame) -> Iterator[pd.DataFrame]:
    for angle, rows in table.groupby("angle_deg", sort=False):
        yield _frame("slope", f"{angle:g} deg", rows["slope_sd"], rows["restitution"], x_unit="1")


def _spore_frames(
    params: Params, table: pd.DataFrame, printed: pd.DataFrame
) -> Iterator[pd.DataFrame]:
    for name, rows in table.groupby("mechanism", sort=False):
        known = rows[np.isfinite(rows["restitution"])]
        seen = name == CAMERA
        e = known["restitution"].to_numpy()
        half = student_half_width(known["restitution_sd"].to_numpy(), params.events)
        yield _frame(
            "spore",
            str(name),
            known["angle_deg"],
            e,
            evidence="virtual experiment" if seen else "computed",
            y_low=e - half if seen else np.nan,
            y_high=e + half if seen else np.nan,
        )
    if len(printed):
        angle = printed["angle_deg"].astype(float)
        yield _frame("spore", "printed", angle, printed["value"], evidence="printed")
