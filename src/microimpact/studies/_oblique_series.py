"""Series of oblique experiments: what is dropped on what, and the curves beside the points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from microimpact.arrays import FloatArray
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.distributions import Distribution, mean
from microimpact.lab.experiment import Target, combined_slope
from microimpact.lab.oblique_incidence import Method, Recipe
from microimpact.lab.ptis import Instrument
from microimpact.model.contact import Contact, resized
from microimpact.model.impact import simulate, velocity_components
from microimpact.model.rigid_body import rigid_body_rebound
from microimpact.parameters import Fraction, Name, NonNegative, Positive
from microimpact.studies._pairs import calibrated_contact


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """One series of a figure: particles, surface, speed class and spin."""

    name: Name
    figures: tuple[Name, ...]
    particle: Name
    surface: Name
    case: Name
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
    series: Series,
    contact: Contact,
    dispenser: Dispenser,
    instrument: Instrument,
    method: Method,
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
        method=method,
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
