"""Impacts by the kernel in the units of the explorer's tables: own speed, mass and Hertz length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import threshold
from microimpact.model.dynamics.normal import normal_impact
from microimpact.studies.models.explorer_tables.coordinates import damping_numbers

# By similarity no result depends on this contact.
_BODY = Material(name="any", youngs_modulus=100e9, poissons_ratio=0.3, density=3000.0)
_CONTACT = Contact(particle=_BODY, surface=_BODY, diameter=10e-6, ring_force=0.0)

# Of small damping: (threshold)^3 / D tends to twice the integral I of the well.
_SHALLOW_THRESHOLD = 1.65470
_SEARCH: Any = {"xatol": 1e-14, "xrtol": 1e-14, "fatol": 0.0, "frtol": 0.0}


@dataclass(frozen=True, slots=True)
class ScaledImpacts:
    """Outcomes in units of speed, mass and the Hertz length ``(m v^2/(sqrt(r) K))^(2/5)``.

    ``hertz_work`` is what Hertz damping takes, as a share of the energy of approach.
    """

    captured: BoolArray
    restitution: FloatArray
    contact_time: FloatArray
    compressive_impulse: FloatArray
    peak_net_impulse: FloatArray
    hertz_impulse: FloatArray
    hertz_work: FloatArray


def impacts(damping: FloatArray, share: FloatArray, strength: FloatArray) -> ScaledImpacts:
    """Integrate impacts of given damping D, share of Hertz damping and strength of adhesion b."""
    mass, root = _CONTACT.mass, np.sqrt(_CONTACT.hertz_radius) * _CONTACT.stiffness
    length = (mass / root) ** 0.4
    hertz, adhesion = damping_numbers(damping, share)
    contact = _CONTACT.replace(
        ring_force=strength * length * _CONTACT.stiffness / (2.0 * np.pi),
        hertz_damping=hertz,
        adhesion_damping=adhesion,
    )
    found = normal_impact(contact, np.ones(np.shape(strength)), ledger=True)
    assert found.hertz_impulse is not None
    assert found.ledger is not None
    return ScaledImpacts(
        captured=found.captured,
        restitution=found.coefficient_of_restitution,
        contact_time=found.contact_time / length,
        compressive_impulse=found.compressive_impulse / mass,
        peak_net_impulse=found.peak_net_impulse / mass,
        hertz_impulse=found.hertz_impulse / mass,
        hertz_work=found.ledger.hertz_work / found.ledger.kinetic_before,
    )


def scaled_thresholds(damping: FloatArray, share: FloatArray) -> FloatArray:
    """Return the speed, in velocity scales, at which impacts of given damping are just captured.

    Solves ``w = threshold(c_H v/w, c_A v/w)``; the right side falls with w, so one w does.

    Raises
    ------
    RuntimeError
        If the search failed.
    """
    # SciPy's optimizers take longer to import than all else here.
    from scipy.optimize import elementwise

    def excess(log_w: FloatArray, hertz: FloatArray, adhesion: FloatArray) -> FloatArray:
        w = np.exp(log_w)
        limit = threshold(np.ravel(hertz / w), np.ravel(adhesion / w), False)
        return np.where(np.isinf(limit), -1.0, np.tanh(log_w - np.log(limit.reshape(w.shape))))

    arguments = tuple(np.ravel(number) for number in damping_numbers(damping, share))
    shallow = np.ravel(np.cbrt(_SHALLOW_THRESHOLD * damping))
    bracket = (np.log(shallow) - 1.0, np.log(shallow + 3.0 * np.ravel(damping)) + 1.0)
    found = elementwise.find_root(excess, bracket, args=arguments, tolerances=_SEARCH)
    if not np.all(found.success):
        raise RuntimeError("the search for a threshold did not converge")
    thresholds: FloatArray = np.exp(found.x).reshape(np.shape(damping))
    return thresholds
