"""Numbers behind the claims on rough surfaces: silicon, mirror, Formica."""

from __future__ import annotations

import numpy as np
import pandas as pd

from microimpact.lab.samples import Seen
from microimpact.studies.claims.laboratory_claims.context import Context, Numbers
from microimpact.studies.experiments.mechanisms.spore import as_imaged


def pair(context: Context, name: str, column: str, angles: tuple[float, ...]) -> pd.Series:
    """Return a column of a rough less a smooth surface at some angles."""
    return context.column("surface_pairs", column, pair=name).loc[list(angles)]


def c71(context: Context) -> dict[str, float]:
    """Least difference of restitution above 20 deg, by slopes alone."""
    named = context.params.mechanisms
    found = pair(context, named.slopes_alone, "restitution_difference", named.restitution_deg)
    return {"least_difference_rough_less_smooth": found.min()}


def c72(context: Context) -> dict[str, float]:
    """Largest excess of the impulse ratio on the rough surface, at any angle."""
    excess = context.column(
        "surface_pairs",
        "impulse_ratio_difference_over_half_width",
        pair=context.params.mechanisms.slopes_alone,
    )
    return {"largest_excess_of_rough_surface_over_half_width": excess.max()}


def c73(context: Context) -> dict[str, float]:
    """Largest difference of the energy loss above 50 deg, with half the adhesion and without."""
    named = context.params.mechanisms
    column = "energy_loss_difference_over_half_width"
    half, alone = (
        pair(context, name, column, named.adhesion_deg).max()
        for name in (named.half_adhesion, named.slopes_alone)
    )
    return {
        "largest_difference_rough_less_smooth_with_half_adhesion_over_half_width": half,
        "largest_difference_rough_less_smooth_with_slopes_alone_over_half_width": alone,
    }


def c74(context: Context) -> dict[str, float]:
    """Least difference of the losses on the mirror, and its error by squared restitutions."""
    named = context.params.mechanisms
    of = (named.mirror, "energy_loss_difference", named.mirror_deg)
    error = pair(context, named.mirror, "loss_less_squares_over_half_width", named.mirror_deg)
    return {
        "least_difference_of_losses_rough_less_smooth": pair(context, *of).min(),
        "largest_error_of_difference_over_half_width": error.abs().max(),
    }


def formica(context: Context, column: str) -> pd.Series:
    """Return a column of steel and spores on Formica, by angle."""
    return context.column("formica_mechanism", column)


def compared(context: Context, column: str) -> pd.Series:
    """Return a column of steel and spores on Formica at the angles that are compared."""
    found = formica(context, column)
    return found[found.index >= context.params.mechanisms.formica_from_deg]


def lesser_rise(context: Context) -> float:
    """Return the lesser rise of the impulse ratio of steel and of spores."""
    steep, shallow = context.params.formica.trend_deg
    ratios = [formica(context, f"{name}_impulse_ratio") for name in ("steel", "spore")]
    return float(min(ratio[shallow] - ratio[steep] for ratio in ratios))


def c86(context: Context) -> dict[str, float]:
    """Restitution of steel less that of spores, rises of both, and that of steel itself."""
    samples = context.params.formica
    steel = formica(context, "steel_restitution")
    return {
        "least_difference_steel_less_spore_over_half_width": compared(
            context, "restitution_difference_over_half_width"
        ).min(),
        "lesser_rise_45_to_15_deg_over_half_width": min(
            context.rise_over_half_width(one, "restitution")
            for one in (samples.steel, samples.spore)
        ),
        "measured_restitution_of_steel_at_20_deg": steel[20.0],
        "measured_restitution_of_steel_at_15_deg": steel[15.0],
        "slope_deviation_of_formica": samples.steel.surface_slope,
    }


def c87(context: Context) -> dict[str, float]:
    """Largest difference of the impulse ratios, and the lesser rise towards shallow angles."""
    return {
        "largest_difference_of_impulse_ratios": compared(context, "impulse_ratio_difference")
        .abs()
        .max(),
        "lesser_rise_45_to_15_deg": lesser_rise(context),
    }


def c88(context: Context) -> dict[str, float]:
    """Difference of the losses at 30 deg over that at 80 deg, and of the restitutions at 30."""
    losses = formica(context, "energy_loss_difference")
    restitution = formica(context, "restitution_difference_over_half_width")
    sines = np.sin(np.radians([30.0, 80.0]))
    return {
        "difference_of_losses_30_over_80_deg": losses[30.0] / losses[80.0],
        "difference_of_restitutions_at_30_deg_over_half_width": restitution[30.0],
        "squared_ratio_of_sines": float((sines[0] / sines[1]) ** 2),
    }


def c89(context: Context) -> dict[str, float]:
    """Share of spores captured, or not seen by the camera, while restitution rises."""
    spore = context.params.formica.spore
    shallow = context.params.formica.trend_deg[1]
    return {
        "captured_share_at_15_deg": formica(context, "spore_captured_share")[shallow],
        "rise_45_to_15_deg_over_half_width": context.rise_over_half_width(spore, "restitution"),
        "share_not_observed_at_15_deg": watched(context).captured_share,
        "bias_of_conditional_mean_at_15_deg": formica(context, "spore_bias_of_conditional_mean")[
            shallow
        ],
    }


def watched(context: Context) -> Seen:
    """Return the spores on Formica at the shallow angle, as the camera sees them."""
    params = context.params.formica
    return as_imaged(
        params.spore,
        context.contact(params.spore),
        params.trend_deg[1],
        context.params.sampling,
        params.instrument,
        events=params.seen_events,
        most_dropped=params.seen_dropped,
    )


CLAIMS = {
    "C71": Numbers(of=c71),
    "C72": Numbers(of=c72),
    "C73": Numbers(of=c73),
    "C74": Numbers(of=c74),
    "C86": Numbers(of=c86, evidence="calibrated", units={"slope_deviation_of_formica": "rad"}),
    "C87": Numbers(of=c87),
    "C88": Numbers(of=c88),
    "C89": Numbers(of=c89),
}
