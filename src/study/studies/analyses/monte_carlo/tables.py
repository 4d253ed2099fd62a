"""Tables of the Monte Carlo study: methods of sampling, sources of scatter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Annotated

import numpy as np
import pandas as pd
import scipy
from pydantic import Field

from microimpact.statistics.distributions import Distribution
from microimpact.statistics.intervals import student_half_width
from microimpact.statistics.sampling import Correlation, Generator, Method
from study.declared.parameters import AngleDegrees, Name
from study.studies.analyses.monte_carlo.ensembles import Ensemble, Plan, estimate
from study.tables import result_evidence, series_frame

METHODS: tuple[tuple[Method, Generator], ...] = (
    ("plain", "exact"),
    ("antithetic", "exact"),
    ("quasi_random", "exact"),
    ("plain", "central_limit"),
    ("quasi_random", "central_limit"),
)
CONFIDENCE = 0.95
QUANTITIES = ("restitution", "impulse_ratio")

# The slope is inferred from a restitution.
FITTED = ("relative_restitution",)


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Angle at which methods of sampling are compared, and events drawn by each."""

    angle_deg: AngleDegrees
    replicates: Annotated[int, Field(ge=2)]
    events: Annotated[int, Field(ge=2)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A parameter that varies alone: by the distribution of the process, or by this one."""

    distribution: Distribution | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """Angles at which sources of scatter are compared, and the sources."""

    angles_deg: tuple[AngleDegrees, ...]
    sources: Annotated[dict[Name, Source], Field(min_length=1)]


def sampling_table(ensemble: Ensemble, settings: Comparison) -> pd.DataFrame:
    """Return estimates by every method at equal cost, and their variance against plain draws.

    The interval of the variance ratio is that of a ratio of two sample variances.
    """
    size = {"replicates": settings.replicates, "events": settings.events}
    rows = []
    for method, generator in METHODS:
        plan = Plan(method=method, generator=generator, **size)
        sampled = estimate(replace(ensemble, plan=plan), settings.angle_deg)
        rows += [
            {
                "method": method,
                "generator": generator,
                "quantity": quantity,
                "angle_deg": settings.angle_deg,
                "events": settings.replicates * settings.events,
                "estimate": getattr(sampled, quantity),
                "standard_error": getattr(sampled, f"{quantity}_error"),
            }
            for quantity in QUANTITIES
        ]
    table = pd.DataFrame(rows)
    # The first method is plain. The inverse of F with equal degrees of freedom is as F.
    error = table["standard_error"]
    ratio = (error / np.resize(error[: len(QUANTITIES)], len(error))) ** 2
    degrees = settings.replicates - 1
    factor = float(scipy.special.fdtri(degrees, degrees, 0.5 * (1.0 + CONFIDENCE)))
    ends = {"variance_ratio_low": ratio / factor, "variance_ratio_high": ratio * factor}
    return table.assign(variance_ratio=ratio, **ends)


def ablation_table(
    ensembles: Mapping[str, Ensemble], base: Ensemble, settings: Ablation
) -> pd.DataFrame:
    """Return the effect of each source of scatter alone, as a share of all together.

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
    for (variant, ensemble), angle in product(ensembles.items(), settings.angles_deg):
        alone = {p: _alone(ensemble, p, s.distribution) for p, s in settings.sources.items()}
        sources = {"all": ensemble} | alone
        estimates = {name: estimate(one, angle) for name, one in sources.items()}
        bare = estimate(base, angle)
        for (name, source_estimate), quantity in product(estimates.items(), QUANTITIES):
            smooth, value, full = (
                getattr(of, quantity) for of in (bare, source_estimate, estimates["all"])
            )
            rows.append(
                {
                    "variant": variant,
                    "angle_deg": angle,
                    "source": name,
                    "quantity": quantity,
                    "smooth": smooth,
                    "estimate": value,
                    "standard_error": getattr(source_estimate, f"{quantity}_error"),
                    "share": (value - smooth) / (full - smooth),
                }
            )
    return pd.DataFrame(rows)


def _alone(ensemble: Ensemble, parameter: str, distribution: Distribution | None) -> Ensemble:
    process = ensemble.process.at_means(but=(parameter,))
    if distribution is not None:
        process = replace(process, **{parameter: distribution})
    return replace(ensemble, process=process, correlation=Correlation())


# Half-width of the drawn band of standard error.
BAND = 2.0


def figure_data(
    means: pd.DataFrame, base: Ensemble, *, points: int, events_measured: int
) -> pd.DataFrame:
    """Return the data of both panels of Fig. 23, from the table ``monte_carlo``.

    The curve of the smooth surface has so many points.
    """
    reference = float(means["reference_angle_deg"].iloc[0])
    angles = np.linspace(90.0 / points, 90.0, points)
    smooth = pd.DataFrame([estimate(base, float(angle)) for angle in angles])
    bare = estimate(base, reference).restitution
    free = smooth["accepted"].to_numpy() > 0.0
    heights = {
        "restitution": smooth["restitution"].to_numpy() - bare,
        "impulse_ratio": smooth["impulse_ratio"].to_numpy(),
    }
    columns = {"restitution": "relative_restitution", "impulse_ratio": "impulse_ratio"}
    # A measured mean scatters about the true one by Student's t of so many events.
    spread = student_half_width(1.0, events_measured)
    frame = partial(series_frame, x_unit="deg", y_unit="1")
    frames = [frame(panel, "smooth", angles[free], y[free]) for panel, y in heights.items()]
    first = means["variant"].iloc[0]
    for variant, rows in means.groupby("variant", sort=False):
        for panel, column in columns.items():
            y = rows[column].to_numpy()
            bands = {str(variant): BAND * rows[f"{column}_error"].to_numpy()}
            if variant == first:
                bands["measured means"] = spread * rows[f"{panel}_sd"].to_numpy()
            curve = rows["angle_deg"], y, result_evidence(column, FITTED)
            frames += [frame(panel, k, *curve, y - half, y + half) for k, half in bands.items()]
    return pd.concat(frames, ignore_index=True)
