"""Samples of rough particles: touching off their centre, and as the imaging system sees them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from microimpact.lab.distributions import generator
from microimpact.lab.events import Measured
from microimpact.lab.experiment import Target
from microimpact.lab.oblique_incidence import Recipe, collect
from microimpact.lab.ptis import Instrument
from microimpact.model.contact import Contact, resized
from microimpact.model.eccentric import eccentric_rebound
from microimpact.model.normal import normal_impact
from microimpact.studies._dropped import (
    Dropped,
    Sampling,
    Seen,
    impacts_of,
    in_class,
    reduce_to,
)

# Offsets are cut here: a point of contact lies on the lower half of the body.
LARGEST_OFFSET = 0.9


def off_centre(
    dropped: Dropped, contact: Contact, angle: float, offset_sd: float, sampling: Sampling
) -> Seen:
    """Return a sample of bodies that touch a smooth plane off their centre.

    The offset along the motion is normal. Restitution at the point of contact, and the friction
    that its compressive impulse can support, are those of the sphere at its normal speed. Bodies
    that still move towards the plane count as captured.

    Parameters
    ----------
    dropped, contact, angle, sampling
        As in `_dropped.seen`; slopes and spin are not used.
    offset_sd
        Standard deviation of the offset over the radius.
    """
    impacts = impacts_of(dropped, contact, angle, sampling)
    inside = np.flatnonzero(in_class(dropped, impacts))
    diameter, v = impacts.diameter[inside], impacts.velocity[inside]
    draws = generator(sampling.seed, 1).standard_normal(sampling.impacts)[inside]
    offset = np.clip(offset_sd * draws, -LARGEST_OFFSET, LARGEST_OFFSET)
    normal = normal_impact(resized(contact, diameter), -v[:, 2])
    e = normal.coefficient_of_restitution
    pressed = normal.compressive_impulse / resized(contact, diameter).mass
    after = eccentric_rebound(
        v[:, 2],
        v[:, 0],
        0.0,
        0.5 * diameter,
        offset,
        e,
        contact.friction * pressed / ((1.0 + e) * -v[:, 2]),
    )
    free = ~normal.captured & (after.V_n > 0.0)
    measured = Measured(
        event=inside[free],
        incident_normal=v[free, 2],
        incident_tangential=v[free, 0],
        rebound_normal=after.V_n[free],
        rebound_tangential=after.V_t[free],
    )
    return reduce_to(measured, inside.size, sampling)


def as_imaged(
    dropped: Dropped,
    contact: Contact,
    angle: float,
    sampling: Sampling,
    instrument: Instrument,
    *,
    events: int,
    most_dropped: int,
) -> Seen:
    """Return what the camera sees of a sample, without errors that its events share.

    Parameters
    ----------
    dropped, contact, angle, sampling
        As in `_dropped.seen`.
    instrument
        The imaging system; its errors of rate, scale and angle are left out.
    events, most_dropped
        Events wanted, and particles after which the sample is taken as it is.
    """
    exact = replace(instrument, rate_error=0.0, scale_error=0.0, angle_error_deg=0.0)
    recipe = Recipe(
        target=Target(contact=contact, slope_sd=dropped.slope_sd),
        diameter_um=dropped.diameter_um,
        speed=dropped.speed_m_per_s,
        speed_range=dropped.speed_range_m_per_s,
        dispenser=sampling.dispenser,
        spin=dropped.spin,
        instrument=exact,
        method="model",
    )
    rng = generator(sampling.seed, 2, round(10 * angle))
    outcome = collect(recipe, angle, events, most_dropped, rng)
    return reduce_to(outcome.measured, outcome.captured + outcome.rebounded, sampling)
