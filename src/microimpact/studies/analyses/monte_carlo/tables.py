"""Tables of the Monte Carlo study: methods of sampling, sources of scatter, printed statements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pandas as pd
import scipy
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import AngleDegrees, Name, NonNegative, Positive
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import FRICTION_BASES, simulate
from microimpact.statistics.distributions import Distribution
from microimpact.statistics.sampling import Correlation, Generator, Method
from microimpact.studies.analyses.monte_carlo.ensembles import Ensemble, Plan
from microimpact.studies.analyses.monte_carlo.events import Estimate, estimate

METHODS: tuple[tuple[Method, Generator], ...] = (
    ("plain", "exact"),
    ("antithetic", "exact"),
    ("quasi_random", "exact"),
    ("plain", "central_limit"),
    ("quasi_random", "central_limit"),
)
CONFIDENCE = 0.95
# Change of mu per degree below which it counts as constant: 0.003 over the plateau.
LEVEL = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Angle at which methods of sampling are compared, and events drawn by each."""

    angle_deg: AngleDegrees
    replicates: Annotated[int, Field(ge=2)]
    events: Annotated[int, Field(ge=2)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """One parameter that varies alone; by the process's distribution, or one of its own."""

    parameter: Name
    distribution: Distribution | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """Angles at which sources of scatter are compared, and the sources."""

    angles_deg: tuple[AngleDegrees, ...]
    sources: Annotated[tuple[Source, ...], Field(min_length=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Statements:
    """Where the article's statements are tested, and by which criteria.

    Attributes
    ----------
    alike_from_deg, differ_at_deg, within
        Rough and smooth restitution, relative to the value at the reference angle, are alike from
        an angle on and differ at another, by this much.
    residual_within
        How far two smooth materials may differ after subtraction.
    impulse_angles_deg
        Between which the impulse ratio of the rough surface still rises.
    shallow_angles_deg, friction_within
        Angles at which mu must be f without adhesion, and how closely.
    """

    alike_from_deg: AngleDegrees
    differ_at_deg: AngleDegrees
    within: Positive
    residual_within: Positive
    impulse_angles_deg: tuple[AngleDegrees, AngleDegrees]
    shallow_angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=1)]
    friction_within: NonNegative


def sampling_table(ensemble: Ensemble, settings: Comparison) -> pd.DataFrame:
    """Return estimates by every method at equal cost, and their variance against plain draws.

    The interval of the variance ratio is that of a ratio of two sample variances.
    """
    found: dict[tuple[Method, Generator], Estimate] = {}
    for method, generator in METHODS:
        plan = Plan(
            replicates=settings.replicates,
            events=settings.events,
            method=method,
            generator=generator,
        )
        found[method, generator] = estimate(replace(ensemble, plan=plan), settings.angle_deg)
    plain = found["plain", "exact"]
    degrees = settings.replicates - 1
    # The inverse of F with equal degrees of freedom has the same distribution.
    factor = float(scipy.special.fdtri(degrees, degrees, 0.5 * (1.0 + CONFIDENCE)))
    rows = []
    for (method, generator), one in found.items():
        for quantity, error in (
            ("restitution", "restitution_error"),
            ("impulse_ratio", "impulse_ratio_error"),
        ):
            ratio = (getattr(one, error) / getattr(plain, error)) ** 2
            rows.append(
                {
                    "method": method,
                    "generator": generator,
                    "quantity": quantity,
                    "angle_deg": settings.angle_deg,
                    "events": settings.replicates * settings.events,
                    "estimate": getattr(one, quantity),
                    "standard_error": getattr(one, error),
                    "variance_ratio": ratio,
                    "variance_ratio_low": ratio / factor,
                    "variance_ratio_high": ratio * factor,
                }
            )
    return pd.DataFrame(rows)


def ablation_table(
    ensembles: Mapping[str, Ensemble], base: Ensemble, settings: Ablation
) -> pd.DataFrame:
    """Return what each source of scatter does alone, as a share of what all do together.

    Parameters
    ----------
    ensembles
        Of all sources, by variant.
    base
        All parameters at their means.
    settings
        Angles and sources.
    """
    rows = []
    for variant, ensemble in ensembles.items():
        for angle in settings.angles_deg:
            bare, full = (estimate(one, angle) for one in (base, ensemble))
            singles = {s.parameter: _alone(ensemble, s) for s in settings.sources}
            found = {name: estimate(one, angle) for name, one in singles.items()}
            for name, one in {"all": full, **found}.items():
                rows += [
                    {
                        "variant": variant,
                        "angle_deg": angle,
                        "source": name,
                        "quantity": quantity,
                        "smooth": getattr(bare, quantity),
                        "estimate": getattr(one, quantity),
                        "standard_error": getattr(one, f"{quantity}_error"),
                        "share": (getattr(one, quantity) - getattr(bare, quantity))
                        / (getattr(full, quantity) - getattr(bare, quantity)),
                    }
                    for quantity in ("restitution", "impulse_ratio")
                ]
    return pd.DataFrame(rows)


def _alone(ensemble: Ensemble, source: Source) -> Ensemble:
    process = ensemble.process.at_means(but=(source.parameter,))
    if source.distribution is not None:
        process = replace(process, **{source.parameter: source.distribution})
    return replace(ensemble, process=process, correlation=Correlation())


def statements_table(
    means: pd.DataFrame, compared: Mapping[str, tuple[Contact, Contact]], settings: Statements
) -> pd.DataFrame:
    """Return numbers that the article's statements are judged by.

    Parameters
    ----------
    means
        Columns ``variant``, ``angle_deg``, ``relative_restitution``, ``impulse_ratio``, their
        ``_error`` and ``smooth_`` counterparts.
    compared
        Pairs of smooth contacts of different materials, by name.
    settings
        Where, and by which criteria.
    """
    rows: list[dict[str, object]] = [
        {"variant": variant, **row}
        for variant, part in means.groupby("variant", sort=False)
        for row in _of_variant(part.set_index("angle_deg").sort_index(), settings)
    ]
    speed = float(means["mean_speed_m_per_s"].iloc[0])
    reference = float(means["reference_angle_deg"].iloc[0])
    angles = np.sort(means["angle_deg"].unique())
    for name, pair in compared.items():
        residual = _residual(pair, speed, angles, reference)
        rows += [
            {
                "variant": name,
                "claim": "C95",
                "quantity": "difference of relative e of two smooth materials, simulated",
                "angle_deg": angle,
                "value": value,
                "limit": settings.residual_within,
                "met": bool(abs(value) < settings.residual_within),
            }
            for angle, value in zip(angles, residual, strict=True)
            if np.isfinite(value)
        ]
    bare = next(iter(compared.values()))[0].replace(work_of_adhesion=0.0)
    for basis in FRICTION_BASES:
        found = simulate(bare, speed, np.array(settings.shallow_angles_deg), friction_basis=basis)
        value = float(np.max(np.abs(found.impulse_ratio - bare.friction)))
        rows.append(
            {
                "variant": f"simulation without adhesion, friction by {basis} force",
                "claim": "C93",
                "quantity": "greatest deviation of mu from f at shallow angles",
                "angle_deg": max(settings.shallow_angles_deg),
                "value": value,
                "limit": settings.friction_within,
                "met": value <= settings.friction_within,
            }
        )
    return pd.DataFrame(rows)


def _of_variant(part: pd.DataFrame, settings: Statements) -> Iterator[dict[str, object]]:
    """Yield the rows of one variant; angles are the index."""
    apart = (part["relative_restitution"] - part["smooth_relative_restitution"]).abs()
    error = part["relative_restitution_error"]
    steep = apart.index >= settings.alike_from_deg
    worst = int(np.argmax(apart[steep]))
    yield {
        "claim": "C94",
        "quantity": "greatest difference of relative e, rough and smooth, from this angle on",
        "angle_deg": settings.alike_from_deg,
        "value": float(apart[steep].iloc[worst]),
        "standard_error": float(error[steep].iloc[worst]),
        "limit": settings.within,
        "met": bool(apart[steep].iloc[worst] < settings.within),
    }
    yield {
        "claim": "C94",
        "quantity": "difference of relative e, rough and smooth",
        "angle_deg": settings.differ_at_deg,
        "value": float(apart[settings.differ_at_deg]),
        "standard_error": float(error[settings.differ_at_deg]),
        "limit": settings.within,
        "met": bool(apart[settings.differ_at_deg] > settings.within),
    }
    low, high = settings.impulse_angles_deg
    for name in ("impulse_ratio", "smooth_impulse_ratio"):
        curve = part[name].loc[low:high]
        slope = -np.diff(curve) / np.diff(curve.index)
        rough = name == "impulse_ratio"
        yield {
            "claim": "C52",
            "quantity": f"least rise of {name} per degree of falling angle, from {high:g} deg down",
            "angle_deg": low,
            "value": float(slope.min()),
            "limit": 0.0,
            "met": bool(slope.min() > LEVEL) if rough else bool(np.abs(slope).max() < LEVEL),
        }
    relative = part["relative_restitution"]
    reaching = relative[relative >= 1.0]
    yield {
        "claim": "C51",
        "quantity": "greatest drawn angle at which relative e reaches unity",
        "value": float(reaching.index.max()) if len(reaching) else None,
        "met": bool(len(reaching)),
    }


def _residual(
    contacts: tuple[Contact, Contact], speed: float, angles: FloatArray, reference: float
) -> FloatArray:
    """Difference of two materials' e, each less its value at the reference angle.

    NaN where either captures.
    """
    normal = speed * np.sin(np.radians(np.append(angles, reference)))
    relative = []
    for contact in contacts:
        e = np.asarray(simulate(contact, normal).coefficient_of_restitution)
        relative.append(np.where(e > 0.0, e, np.nan)[:-1] - e[-1])
    return np.asarray(relative[0] - relative[1])
