"""Monte Carlo analysis of impacts on a rough surface (Section 4.2, Fig. 23)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Annotated, Literal

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.lab.surface import Rules
from microimpact.statistics.distributions import Distribution, mean
from microimpact.statistics.sampling import Correlation, require_varying
from study.declared.parameters import AngleDegrees, CaseName, Must, Name, Points
from study.studies.analyses.monte_carlo.ensembles import (
    Ensemble,
    Estimate,
    Impact,
    Inferred,
    Plan,
    Process,
    deterministic,
    estimate,
    long_run,
    progress,
)
from study.studies.analyses.monte_carlo.impacts import impact_of, require_meaning
from study.studies.analyses.monte_carlo.slope_inference import (
    SlopeInference,
    infer_slope,
    with_slope,
)
from study.studies.analyses.monte_carlo.tables import (
    Ablation,
    Comparison,
    ablation_table,
    figure_data,
    sampling_table,
)
from study.studies.contacts import calibrated_contact
from study.tables import Row, Tables

NEEDS = {"calibration": ("calibration",)}

# Fields of an estimate that are shares of all events.
SHARES = ("accepted", "facing_away", "captured", "not_leaving")
# First number of every stream's key; the second is the number of the variant.
ESTIMATES, SAMPLING, ABLATION, INFERENCE, LONG_RUN = range(5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """A surface and rules by which it is struck."""

    drawn: bool  # Whether it is in the figure; of all others the slope is inferred only
    rules: Rules  # Facets hit and events observed
    two_axes: bool = False  # Whether the surface slopes across the motion as it does along it
    slope: Distribution | None = None  # Distribution of the slope in place of the process's


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Distributions, model of an impact, and the estimates that are made."""

    seed: Annotated[int, Field(ge=0)]  # Root of every draw
    # ``"rigid_body"``: e of simulated normal impacts and Coulomb friction. ``"simulation"``: the
    # equations of motion for every impact.
    model: Literal["rigid_body", "simulation"]
    smooth: CaseName  # Case of the smooth surface of the ensembles
    process: Process
    variants: Annotated[dict[Name, Variant], Field(min_length=1)]  # By name in tables and figure
    plan: Plan
    # Nominal angles, and that from which relative restitution counts.
    angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
    reference_angle_deg: Annotated[AngleDegrees, Must("one of", "angles_deg")]
    points: Points  # Of the deterministic curves
    # Events behind one measured mean, for the band of such means.
    events_measured: Annotated[int, Field(ge=2)]
    comparison: Comparison
    ablation: Ablation
    slope_inference: SlopeInference
    correlation: Correlation = field(default_factory=Correlation)

    def __post_init__(self) -> None:
        """Refuse parameters that contradict each other."""
        if not self.drawn:
            raise ValueError("variants: at least one must be drawn")
        if self.model == "simulation" and self.slope_inference.restitution_half_width > 0.0:
            raise ValueError(
                "slope_inference.restitution_half_width: must be 0 with the model 'simulation', "
                f"whose restitution cannot be shifted, got "
                f"{self.slope_inference.restitution_half_width:g}"
            )
        known = self.process.distributions
        for source in self.ablation.sources:
            if source not in known:
                complaint = f"{source!r} must be one of {', '.join(known)}"
                raise ValueError(f"ablation.sources: {complaint}")
        require_meaning(self.model, self.process)
        require_varying(self.correlation, known)

    @property
    def drawn(self) -> list[str]:
        """Variants in the figure."""
        return [name for name, variant in self.variants.items() if variant.drawn]


def run(params: Params, inputs: Tables) -> Tables:
    """Draw impacts on rough surfaces over angles of incidence.

    ``fig23``: relative e and -mu against the angle in degrees, of the smooth surface and of every
    drawn variant, with bands of two standard errors and, of the first, of measured means.
    ``monte_carlo``: means, errors and rejected shares; empty where the smooth surface captures.
    ``monte_carlo_sampling``, ``monte_carlo_ablation``, ``slope_inference``: see `tables` and
    `slope_inference`.
    """
    estimates = inputs["parts"] if "parts" in inputs else part(params, inputs, 0, 1)
    ensembles = _ensembles(params, inputs)
    drawn = {name: ensembles[name] for name in params.drawn}
    base = deterministic(next(iter(drawn.values())))
    rows = estimates.sort_values("angle_deg").groupby("variant")
    means = pd.concat(
        [_means(params, rows.get_group(name), base) for name in drawn], ignore_index=True
    )
    first = _stream(next(iter(drawn.values())), SAMPLING)
    apart = {name: _stream(one, ABLATION) for name, one in drawn.items()}
    return {
        "fig23": figure_data(
            means, base, points=params.points, events_measured=params.events_measured
        ),
        "monte_carlo": means,
        "monte_carlo_sampling": sampling_table(first, params.comparison),
        "monte_carlo_ablation": ablation_table(apart, base, params.ablation),
        "slope_inference": _slopes(params, ensembles),
    }


def part(params: Params, inputs: Tables, index: int, count: int) -> pd.DataFrame:
    """Estimates of every ``count``-th pair of drawn variant and angle, from ``index`` on."""
    ensembles = _ensembles(params, inputs)
    angles = enumerate(sorted(params.angles_deg))
    pairs = list(product(params.drawn, angles))[index::count]
    return pd.DataFrame(
        [
            {"variant": name, "angle_deg": angle} | estimate(ensembles[name], angle, key)._asdict()
            for name, (key, angle) in pairs
        ]
    )


def stream(
    params: Params, inputs: Tables, *, variant: str, angle_deg: float, events: int, threads: int = 1
) -> Estimate:
    """Estimate the measured coefficients at one angle from any number of events.

    Memory does not grow with the number of events, and a bar on the terminal shows how far it is.

    Parameters
    ----------
    params, inputs
        As for `run`.
    variant
        Name of one of the variants.
    angle_deg
        Nominal angle of incidence from the surface.
    events
        Number of events, rounded up to whole replicates of `BLOCK`; a longer run begins with
        the events of a shorter one.
    threads
        Number of threads; results do not depend on it.

    Raises
    ------
    ValueError
        If there is no such variant, or no event is asked for.
    """
    if variant not in params.variants:
        raise ValueError(f"variant must be one of {', '.join(params.variants)}, got {variant!r}")
    if events < 1 or threads < 1:
        raise ValueError(f"events and threads must be 1 or more, got {events} and {threads}")
    impact = impact_of(params.model, calibrated_contact(inputs, params.smooth), params.process)
    ensemble = _stream(_ensemble(params, impact, variant), LONG_RUN)
    long = long_run(ensemble, events)
    with progress(f"{variant}, {angle_deg:g} deg", long.plan.replicates * long.plan.events) as done:
        return estimate(long, angle_deg, threads=threads, done=done)


def _ensembles(params: Params, inputs: Tables) -> dict[str, Ensemble]:
    contact = calibrated_contact(inputs, params.smooth)
    impact = impact_of(params.model, contact, params.process)
    return {name: _ensemble(params, impact, name) for name in params.variants}


def _ensemble(params: Params, impact: Impact, name: str) -> Ensemble:
    variant, number = params.variants[name], list(params.variants).index(name)
    slope = variant.slope or params.process.slope
    across = params.process.cross_slope
    if variant.two_axes and not isinstance(slope, Inferred):
        across = slope
    ensemble = Ensemble(
        process=replace(params.process, slope=slope, cross_slope=across),
        rules=variant.rules,
        impact=impact,
        plan=params.plan,
        seed=(params.seed, ESTIMATES, number),
        correlation=params.correlation,
    )
    if not (isinstance(slope, Inferred) and variant.drawn):
        return ensemble
    inference = _inferred(params, ensemble, variant)
    if not inference["reached"]:
        raise ValueError(
            f"variants.{name}: no slope gives a restitution of "
            f"{params.slope_inference.restitution:g} at {params.slope_inference.angle_deg:g} deg; "
            "declare process.slope"
        )
    return with_slope(ensemble, float(str(inference["slope_sd"])), two_axes=variant.two_axes)


def _inferred(params: Params, ensemble: Ensemble, variant: Variant) -> Row:
    inference = _stream(ensemble, INFERENCE)
    return infer_slope(inference, params.slope_inference, two_axes=variant.two_axes)


def _stream(ensemble: Ensemble, analysis: int) -> Ensemble:
    """Return the ensemble with the random numbers of another analysis."""
    seed = (ensemble.seed[0], analysis, *ensemble.seed[2:])
    return replace(ensemble, seed=seed)


def _means(params: Params, estimates: pd.DataFrame, base: Ensemble) -> pd.DataFrame:
    """Estimates of a variant at every angle, ascending, beside the smooth surface's."""
    rough, angles = estimates.reset_index(drop=True), sorted(params.angles_deg)
    smooth = pd.DataFrame([estimate(base, angle) for angle in angles])
    reference = angles.index(params.reference_angle_deg)
    e, error, bare = rough["restitution"], rough["restitution_error"], smooth["restitution"]
    relative_error = np.hypot(error, error[reference]).where(rough.index != reference, 0.0)
    return rough.rename(columns={name: f"{name}_share" for name in SHARES}).assign(
        relative_restitution=e - e[reference],
        relative_restitution_error=relative_error,
        smooth_restitution=bare,
        smooth_relative_restitution=bare - bare[reference],
        smooth_impulse_ratio=smooth["impulse_ratio"],
        reference_angle_deg=params.reference_angle_deg,
        mean_speed_m_per_s=mean(params.process.speed_m_per_s),
        events=params.plan.replicates * params.plan.events,
    )


def _slopes(params: Params, ensembles: Mapping[str, Ensemble]) -> pd.DataFrame:
    settings = params.slope_inference
    return pd.DataFrame(
        {
            "variant": name,
            "angle_deg": settings.angle_deg,
            "restitution": settings.restitution,
            **_inferred(params, ensembles[name], variant),
            "evidence": "calibrated",
        }
        for name, variant in params.variants.items()
    )
