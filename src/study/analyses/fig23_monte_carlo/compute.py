"""Monte Carlo analysis of impacts on a rough surface (Section 4.2, Fig. 23)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Annotated, Literal

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.computable import NotComputable
from microimpact.lab.surface import Rules
from microimpact.statistics.distributions import Constant, Normal
from microimpact.statistics.intervals import student_half_width
from study.analyses.fig23_monte_carlo.ensembles import (
    Ensemble,
    Plan,
    Process,
    RigidBody,
    estimate,
    smooth_at_means,
)
from study.analyses.fig23_monte_carlo.slope_inference import SlopeInference, infer_slope
from study.contacts import calibrated_contact
from study.declared.parameters import AngleDegrees, CaseName, Must, Name, Points
from study.tables import Row, Tables, result_evidence, series_frame

NEEDS = {"calibration": ("calibration",)}

# Fields of an estimate that are shares of all events.
SHARES = ("accepted", "facing_away", "captured", "not_leaving")
# Second number of every stream's key; the third is the number of the variant.
ESTIMATES, INFERENCE = 0, 3
# Half-width of the drawn band, in standard errors.
BAND = 2.0
# What slopes inferred from a restitution are fitted to.
FITTED = ("relative_restitution",)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """Differences of a rough surface from the rules of the study."""

    drawn: bool = False  # Whether it is in the figure; of all others the slope is inferred only
    two_axes: bool = False  # Whether the surface slopes across the motion as it does along it
    facets: Literal["seen", "facing", "every"] | None = None
    must_leave: bool | None = None
    most_contacts: Annotated[int, Field(ge=1, le=20)] | None = None

    def rules(self, shared: Rules) -> Rules:
        """Return the rules of the study with this variant's differences."""
        names = "facets", "must_leave", "most_contacts"
        differing = {name: getattr(self, name) for name in names if getattr(self, name) is not None}
        return replace(shared, **differing)


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Distributions, rules by which surfaces are struck, and the estimates that are made."""

    seed: Annotated[int, Field(ge=0)]  # Root of every draw
    smooth: CaseName  # Case of the smooth surface of the ensembles
    process: Process
    rules: Rules  # Facets hit and events observed, unless a variant says otherwise
    variants: Annotated[dict[Name, Variant], Field(min_length=1)]  # By name in tables and figure
    plan: Plan
    # Nominal angles, and that from which relative restitution counts.
    angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
    reference_angle_deg: Annotated[AngleDegrees, Must("one of", "angles_deg")]
    points: Points  # Of the deterministic curves
    # Events behind one measured mean, for the band of such means and the slopes inferred from one.
    events_measured: Annotated[int, Field(ge=2)]
    slope_inference: SlopeInference

    def __post_init__(self) -> None:
        """Refuse a figure without a rough surface."""
        if not self.drawn:
            raise ValueError("variants: at least one must be drawn")

    @property
    def drawn(self) -> list[str]:
        """Variants in the figure."""
        return [name for name, variant in self.variants.items() if variant.drawn]


def run(params: Params, inputs: Tables) -> Tables:
    """Draw impacts on rough surfaces over angles of incidence.

    ``slope_inference``: the slopes that each variant needs for the printed restitution, see
    `infer_slope`. ``monte_carlo``: means, errors and rejected shares of the drawn variants, with
    these slopes or the declared ones; empty where the smooth surface captures. ``fig23``: relative
    e and -mu against the angle in degrees, of the smooth surface and of every drawn variant, with
    bands of two standard errors and, of the first, of measured means.
    """
    surfaces = smooth_surfaces(params, inputs)
    inferences = {name: _inferred(params, surfaces[name]) for name in surfaces}
    rough = {name: _rough(params, name, surfaces[name], inferences[name]) for name in params.drawn}
    estimates = inputs["parts"] if "parts" in inputs else _estimates(params, rough, 0, 1)
    base = smooth_at_means(rough[params.drawn[0]])
    means = _means(params, estimates, base)
    return {
        "fig23": figure_data(params, means, base),
        "monte_carlo": means,
        "slope_inference": _slopes(params, inferences),
    }


def part(params: Params, inputs: Tables, index: int, count: int) -> pd.DataFrame:
    """Estimates of every ``count``-th pair of drawn variant and angle, from ``index`` on."""
    surfaces = smooth_surfaces(params, inputs)
    rough = {
        name: _rough(params, name, surfaces[name], _inferred(params, surfaces[name]))
        for name in params.drawn
    }
    return _estimates(params, rough, index, count)


def smooth_surfaces(params: Params, inputs: Tables) -> dict[str, Ensemble]:
    """Return the ensemble of every variant, before it has slopes."""
    contact = calibrated_contact(inputs, params.smooth)
    body = RigidBody.of(contact, params.process)
    return {
        name: Ensemble(
            process=params.process,
            slope=Constant(at=0.0),
            two_axes=variant.two_axes,
            rules=variant.rules(params.rules),
            body=body,
            plan=params.plan,
            seed=(params.seed, ESTIMATES, number),
        )
        for number, (name, variant) in enumerate(params.variants.items())
    }


def _inferred(params: Params, surface: Ensemble) -> Row:
    """Infer the slopes of a variant, with random numbers of their own."""
    seed = (params.seed, INFERENCE, *surface.seed[2:])
    return infer_slope(replace(surface, seed=seed), params.slope_inference, params.events_measured)


def _rough(params: Params, name: str, surface: Ensemble, inference: Row) -> Ensemble:
    """Return the ensemble of a variant with the declared slopes, else the inferred ones."""
    if params.process.slope is not None:
        return replace(surface, slope=params.process.slope)
    if not inference["reached"]:
        raise NotComputable(
            f"variants.{name}: no slope gives a restitution of "
            f"{params.slope_inference.restitution:g} at {params.slope_inference.angle_deg:g} deg; "
            "declare process.slope"
        )
    return replace(surface, slope=Normal(sd=float(str(inference["slope_sd"]))))


def _estimates(
    params: Params, rough: Mapping[str, Ensemble], index: int, count: int
) -> pd.DataFrame:
    angles = enumerate(sorted(params.angles_deg))
    pairs = list(product(rough, angles))[index::count]
    return pd.DataFrame(
        [
            {"variant": name, "angle_deg": angle} | estimate(rough[name], angle, key)._asdict()
            for name, (key, angle) in pairs
        ]
    )


def _means(params: Params, estimates: pd.DataFrame, base: Ensemble) -> pd.DataFrame:
    """Return estimates of the drawn variants at every angle, beside the smooth surface's."""
    angles = sorted(params.angles_deg)
    reference = angles.index(params.reference_angle_deg)
    smooth = pd.DataFrame([estimate(base, angle) for angle in angles])
    bare = smooth["restitution"]
    by_variant = estimates.sort_values("angle_deg").groupby("variant")
    tables = []
    for name in params.drawn:
        rough = by_variant.get_group(name).reset_index(drop=True)
        e, error = rough["restitution"], rough["restitution_error"]
        relative_error = np.hypot(error, error[reference]).where(rough.index != reference, 0.0)
        table = rough.assign(
            relative_restitution=e - e[reference],
            relative_restitution_error=relative_error,
            smooth_restitution=bare,
            smooth_relative_restitution=bare - bare[reference],
            smooth_impulse_ratio=smooth["impulse_ratio"],
        )
        tables.append(table.rename(columns={name: f"{name}_share" for name in SHARES}))
    return pd.concat(tables, ignore_index=True)


def _slopes(params: Params, inferences: Mapping[str, Row]) -> pd.DataFrame:
    settings = params.slope_inference
    target = {"angle_deg": settings.angle_deg, "restitution": settings.restitution}
    rows = [{"variant": name} | target | inference for name, inference in inferences.items()]
    return pd.DataFrame(rows).assign(evidence="calibrated")


def figure_data(params: Params, means: pd.DataFrame, base: Ensemble) -> pd.DataFrame:
    """Return the data of both panels of Fig. 23.

    Parameters
    ----------
    params
        Number of points of the smooth surface's curve, and of events behind a measured mean.
    means
        Table ``monte_carlo``.
    base
        The smooth surface.
    """
    fitted = FITTED if params.process.slope is None else ()
    angles = np.linspace(90.0 / params.points, 90.0, params.points)
    smooth = pd.DataFrame([estimate(base, float(angle)) for angle in angles])
    bare = estimate(base, params.reference_angle_deg).restitution
    free = smooth["accepted"].to_numpy() > 0.0
    heights = {
        "restitution": smooth["restitution"].to_numpy() - bare,
        "impulse_ratio": smooth["impulse_ratio"].to_numpy(),
    }
    columns = {"restitution": "relative_restitution", "impulse_ratio": "impulse_ratio"}
    # A measured mean scatters about the true one by Student's t.
    spread = student_half_width(1.0, params.events_measured)
    frame = partial(series_frame, x_unit="deg", y_unit="1")
    frames = [frame(panel, "smooth", angles[free], y[free]) for panel, y in heights.items()]
    for variant, rows in means.groupby("variant", sort=False):
        for panel, column in columns.items():
            y = rows[column].to_numpy()
            bands = {str(variant): BAND * rows[f"{column}_error"].to_numpy()}
            if variant == params.drawn[0]:
                bands["measured means"] = spread * rows[f"{panel}_sd"].to_numpy()
            curve = rows["angle_deg"], y, result_evidence(column, fitted)
            frames += [frame(panel, k, *curve, y - half, y + half) for k, half in bands.items()]
    return pd.concat(frames, ignore_index=True)
