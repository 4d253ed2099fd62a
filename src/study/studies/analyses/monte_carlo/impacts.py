"""Outcomes of impacts in an ensemble: the rigid body model, or the dynamic simulation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.lab.surface import Spheres, Strike, rigid_sums, simulated
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.law.families import NoTableError
from microimpact.model.law.table import TOLERANCE, Law, tabulate
from microimpact.statistics.distributions import LARGEST_PROBABILITY, SMALLEST_PROBABILITY, Constant
from study.studies.analyses.monte_carlo.ensembles import (
    Draws,
    Ensemble,
    Events,
    Impact,
    Process,
    Struck,
)

# How far the tables of e reach beyond the sizes and speeds drawn: spin before impact may make a
# second one faster than the first.
MARGIN, FASTEST = 0.01, 1.5
# Sizes at which all spheres must have a capture velocity.
SIZES = 12
# Very wide distributions of sizes get tables of this relative error.
WIDE_TOLERANCE = 1e-6

# Parameters of a process that only one of the models has.
RIGID_BODY_ONLY = ("restitution_factor", "restitution_offset")
SIMULATION_ONLY = ("hertz_damping_factor", "adhesion_damping_factor")
NEUTRAL = {"restitution_offset": 0.0}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RigidBody:
    """Rigid body model with the restitution of simulated normal impacts.

    At given damping, work of adhesion and diameter count by their quotient alone, the velocity
    scale being its power 5/6: all spheres are one family of `model.families`.
    """

    law: Law  # e of all speeds and sizes that a process may draw
    # Diameter in um divided by the factor of the work of adhesion, of the family's middle.
    size: float

    @classmethod
    def of(cls, contact: Contact, process: Process) -> RigidBody:
        """Return the model of a contact for all speeds and sizes that a process may draw.

        Raises ValueError if some of these spheres rebound at no speed, or at every one, or the
        surface is curved.
        """
        if np.any(np.isfinite(contact.surface_radius)):
            raise ValueError(
                f"surface_radius: must be infinite in the rigid body model of an ensemble, got "
                f"{contact.surface_radius}"
            )
        ends = np.array([SMALLEST_PROBABILITY, LARGEST_PROBABILITY])
        diameter, factor, speed = (
            np.asarray(getattr(process, name).quantile(ends))
            for name in ("diameter_um", "work_of_adhesion_factor", "speed_m_per_s")
        )
        smallest, largest = diameter[0] / factor[1], diameter[1] / factor[0]
        size = np.geomspace(smallest * (1.0 - MARGIN), largest * (1.0 + MARGIN), SIZES)
        spheres = resized(contact, size * 1e-6)
        limit = np.asarray(capture_velocity(spheres))
        odd = size[~(np.isfinite(limit) & (limit > 0.0))]
        if odd.size:
            raise ValueError(
                f"process: spheres of {odd.max():.3g} um (diameter_um over "
                "work_of_adhesion_factor) have no capture velocity; narrow these distributions"
            )
        speeds = limit.max(), FASTEST * max(speed[1], limit.max())
        return cls(law=_table(spheres, speeds), size=float(np.sqrt(size[0] * size[-1])))

    def scales(self, draws: Draws) -> tuple[FloatArray, FloatArray]:
        """Return the velocity scales of spheres, m/s, and their places in the family."""
        size = draws["diameter_um"] / draws["work_of_adhesion_factor"]
        steps, family = (5.0 / 6.0) * np.log(size / self.size), self.law.family
        shape_index = np.zeros(1) if family.alike else -steps / family.half_width
        return np.asarray(family.velocity_scale * np.exp(-steps)), np.asarray(shape_index)

    def sums(self, ensemble: Ensemble, groups: Iterable[Events]) -> FloatArray:
        """Return the sums over events, see `Impact`."""
        return rigid_sums(ensemble.surface, self.law, map(self._spheres, groups))

    def _spheres(self, events: Events) -> Spheres:
        draws = events.draws
        names = "spin_ratio", "friction", "restitution_factor", "restitution_offset"
        drawn = [draws["speed_m_per_s"], events.angle_deg + draws["angle_offset_deg"]]
        drawn += [draws[name] for name in names] + list(self.scales(draws))
        return Spheres(drawn, events.facets, events.count, events.replicates)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Simulation(Struck):
    """Dynamic simulation of every impact (Eqs. 19-29)."""

    contact: Contact

    def __call__(self, draws: Draws) -> Strike:
        """Return the rebounds of spheres with these draws, as a function of their contacts."""
        base, diameter = self.contact, draws["diameter_um"] * 1e-6
        contact = base.replace(
            diameter=diameter,
            friction=draws["friction"],
            work_of_adhesion=np.asarray(base.work_of_adhesion) * draws["work_of_adhesion_factor"],
            hertz_damping=base.hertz_damping * draws["hertz_damping_factor"],
            adhesion_damping=base.adhesion_damping * draws["adhesion_damping_factor"],
        )
        return simulated(contact, diameter.size)


def _table(spheres: Contact, speeds: tuple[float, float]) -> Law:
    try:
        return tabulate(spheres, *speeds, tolerance=TOLERANCE)
    except NoTableError:
        return tabulate(spheres, *speeds, tolerance=WIDE_TOLERANCE)


def impact_of(model: str, contact: Contact, process: Process) -> Impact:
    """Return the impact of a model, ``"rigid_body"`` or ``"simulation"``.

    Raises ValueError if some of the process's spheres have no capture velocity (rigid body model
    only).
    """
    return RigidBody.of(contact, process) if model == "rigid_body" else Simulation(contact=contact)


def require_meaning(model: str, process: Process) -> None:
    """Raise a ValueError if a process varies a parameter that the model lacks."""
    for name in SIMULATION_ONLY if model == "rigid_body" else RIGID_BODY_ONLY:
        neutral = NEUTRAL.get(name, 1.0)
        if getattr(process, name) != Constant(at=neutral):
            raise ValueError(
                f"process.{name}: without meaning in the model {model!r}, must be the constant "
                f"{neutral:g}"
            )
