"""Numbers behind the claims that large samples of virtual impacts decide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts
from microimpact.lab.samples import (
    Dropped,
    Statistic,
    contact_of,
    impacts_of,
    in_class,
    in_plane,
    statistics,
)
from microimpact.model.rigid_body.algebra import INERTIA
from microimpact.studies.claim_numbers import Numbers
from microimpact.studies.claims.model_claims.context import Context
from microimpact.studies.claims.model_claims.oblique import rotational_share


def sampled(context: Context, dropped: Dropped, angle: float) -> Impacts:
    """Return the impacts of the speed class at one angle, of the context's case."""
    own = replace(dropped, case=context.case)
    impacts = impacts_of(own, contact_of(own, context.inputs), angle, context.params.sampling)
    return impacts.select(in_class(own, impacts))


def c16(context: Context) -> dict[str, float]:
    """Share captured, and mean restitution, of slow impacts below a normal speed.

    At the declared angles at which the nominal speed leads there. A captured sphere counts with the
    restitution 0 that it has: where none rebounds there is no other mean.
    """
    slow = context.params.slow
    angles = np.array(context.params.steel.angles_deg)
    limit = slow.normal_speed_below_m_per_s
    below = angles[slow.dropped.speed_m_per_s * np.sin(np.radians(angles)) < limit]
    captured, restitution = [], []
    for angle in below:
        impacts = sampled(context, slow.dropped, float(angle))
        chosen = impacts.select(-impacts.velocity[:, 2] < limit)
        captured.append(chosen.captured)
        rebound = np.where(chosen.captured, 0.0, chosen.rebound_velocity[:, 2])
        restitution.append(-rebound / chosen.velocity[:, 2])
    return {
        "captured_share_below_0p2_m_per_s": float(np.mean(np.concatenate(captured))),
        "mean_restitution_below_0p2_m_per_s": float(np.mean(np.concatenate(restitution))),
    }


def c41(context: Context) -> dict[str, float]:
    """How far the loss without rotation lies above the true one, and what rotation holds.

    The gap of the means over the half-width of the 95 % interval that an experiment has for the
    loss without rotation, the largest over the declared angles; the least gap, and the share of
    rotation in the final energy at 50 deg, of the mean sphere.
    """
    steel, angles = context.steel, context.params.steel.angles_deg
    oblique = np.array(angles)[np.array(angles) < 90.0]
    _, impact = context.rebounds(steel, oblique)
    at_50 = context.hit(steel, context.speed, context.params.oblique.spin_angle_deg)
    return {
        "largest_gap_of_losses_over_half_width": max(
            gap_over_half_width(context, float(angle)) for angle in oblique
        ),
        "least_gap_of_losses": np.min(impact.translational_energy_loss - impact.energy_loss),
        "rotational_share_of_final_energy_at_50_deg": rotational_share(steel, at_50),
    }


def gap_over_half_width(context: Context, angle: float) -> float:
    """Return the gap of both losses over the half-width of that which is measured.

    It is 0 where so few rebound that there is no such experiment.
    """
    params = context.params
    impacts = sampled(context, replace(params.fast, friction=params.steel.friction), angle)
    free = impacts.select(~impacts.captured)
    if len(free) < params.sampling.events:
        return 0.0
    measured = in_plane(free, np.ones(len(free), dtype=bool))
    loss = statistics(measured, params.sampling.angle_error_deg)["energy_loss"]
    gap = np.mean(gained_by_rotation(free))
    return float(gap / half_width(loss, params.sampling.events))


def gained_by_rotation(impacts: Impacts) -> FloatArray:
    """Return the rotational energy gained over the translational energy before each impact."""
    radius = 0.5 * impacts.diameter
    gained = np.sum(np.square(impacts.rebound_spin) - np.square(impacts.spin), axis=1)
    before = np.sum(np.square(impacts.velocity), axis=1)
    share: FloatArray = INERTIA * np.square(radius) * gained / before
    return share


def half_width(of: Statistic, events: int) -> float:
    """Return the half-width of the 95 % interval of a mean of so many events."""
    quantile = float(scipy.special.stdtrit(events - 1, 0.975))
    return quantile * float(np.sqrt(of.sd**2 / events + of.systematic**2))


CLAIMS = {
    "C16": Numbers(of=c16, by_case=True, evidence="virtual experiment"),
    "C41": Numbers(of=c41, by_case=True, evidence="virtual experiment"),
}
