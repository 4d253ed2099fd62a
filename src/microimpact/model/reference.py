"""Reference of adhesive impacts: cases that any code of contacts can run, closed forms beside them.

All bodies are of one elastic material, so that a code needs only its own words for the numbers of
`CASES`. What has no closed form is integrated, to some parts in 10^13; slip in a compliant contact
to 1e-4 of itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.materials import Material
from microimpact.model.closed_forms import (
    YIELD_PRESSURE_RATIO,
    hertz_contact_time,
    jkr_loss,
    plastic_restitution,
    sticking_restitution,
    yield_velocity,
)
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, RING_FORCE, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar

GLASS = Material(name="glass", youngs_modulus=70e9, poissons_ratio=0.25, density=2500.0)
SPEEDS = (0.03, 0.045, 0.06, 0.1, 0.2, 0.5, 1.0)  # m/s, along the normal
DIAMETER, WORK, FRICTION = 10e-6, 0.1, 0.2
VISCOUS_TIME, YIELD_PRESSURE = 0.5e-9, 0.4e9

# Restitution of a contact at normal speeds in m/s.
ClosedForm = Callable[[Contact, FloatArray], FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Impacts of one contact.

    Attributes
    ----------
    contact
        The contact.
    closed_form
        Restitution in closed form, where there is one.
    tangential_speed
        Before impact, m/s; the contact then complies along the surface by Mindlin's law.
    speeds
        Normal speeds before impact, m/s.
    """

    contact: Contact
    closed_form: ClosedForm | None = None
    tangential_speed: float = 0.0
    speeds: tuple[float, ...] = SPEEDS


def _contact(**changes: Any) -> Contact:
    """Two like materials with the adhesion of the reference, without friction."""
    bodies: dict[str, Any] = {"particle": GLASS, "surface": GLASS, "diameter": DIAMETER}
    return Contact(**(bodies | {"work_of_adhesion": WORK, "friction": 0.0} | changes))


def _snap(contact: Contact, speed: FloatArray) -> FloatArray:
    return sticking_restitution(speed, np.sqrt(2.0 * jkr_loss(contact) / contact.mass))


def _plastic(contact: Contact, speed: FloatArray) -> FloatArray:
    strength = YIELD_PRESSURE / YIELD_PRESSURE_RATIO
    return plastic_restitution(speed, yield_velocity(contact, strength))


def _elastic(_: Contact, speed: FloatArray) -> FloatArray:
    return np.ones_like(speed)


_PAIR = {"partner_diameter": DIAMETER}
_VISCOUS, _YIELDING = JKR(viscous_time=VISCOUS_TIME), ThorntonNing(yield_pressure=YIELD_PRESSURE)
_DAMPED = {"hertz_damping": 0.1, "adhesion_damping": 1.0}
_BARE = _contact(work_of_adhesion=0.0, friction=FRICTION)

CASES = {
    "hertz-wall": Case(contact=_contact(work_of_adhesion=0.0), closed_form=_elastic),
    "jkr-wall": Case(contact=_contact(law=JKR()), closed_form=_snap),
    "jkr-pair": Case(contact=_contact(law=JKR(), **_PAIR), closed_form=_snap),
    "viscous-jkr-wall": Case(contact=_contact(law=_VISCOUS)),
    "viscous-jkr-pair": Case(contact=_contact(law=_VISCOUS, **_PAIR)),
    "plastic-wall": Case(
        contact=_contact(work_of_adhesion=0.0, law=_YIELDING), closed_form=_plastic
    ),
    "thornton-ning-wall": Case(contact=_contact(law=_YIELDING)),
    "ring-force-wall": Case(contact=_contact(**_DAMPED)),
    "ring-force-pair": Case(contact=_contact(**_DAMPED, **_PAIR)),
    "sticking-wall": Case(contact=_BARE, tangential_speed=0.5, speeds=(1.0,)),
    "sliding-wall": Case(contact=_BARE, closed_form=_elastic, tangential_speed=3.0, speeds=(1.0,)),
}

Row = dict[str, Any]


def impacts() -> list[Row]:
    """Impacts of all cases, a row each, in SI units; NaN where there is no closed form."""
    return [row for name, case in CASES.items() for row in _impacts(name, case)]


def _impacts(name: str, case: Case) -> list[Row]:
    speed, contact = np.array(case.speeds), case.contact
    along = case.tangential_speed
    impact = planar(contact, -speed, along, tangential="mindlin" if along else "rigid")
    nothing = np.full_like(speed, math.nan)
    e = nothing if case.closed_form is None else case.closed_form(contact, speed)
    elastic = case.closed_form is _elastic
    sliding = bool(elastic and along and not np.any(impact.rolling))
    kinetic = 0.5 * contact.mass * (speed**2 + along**2)
    columns = {
        "normal_speed_m_per_s": speed,
        "tangential_speed_m_per_s": np.full_like(speed, along),
        "restitution": impact.coefficient_of_restitution,
        "restitution_closed_form": e,
        "contact_time_s": impact.contact_time,
        "contact_time_closed_form_s": hertz_contact_time(contact, speed) if elastic else nothing,
        "energy_loss_J": impact.energy_loss * kinetic,
        "tangential_velocity_m_per_s": impact.tangential_velocity,
        "tangential_velocity_closed_form_m_per_s": (
            along - contact.friction * (1.0 + e) * speed if sliding else nothing
        ),
        "spin_rad_per_s": impact.spin,
    }
    rows = zip(*(np.asarray(values).tolist() for values in columns.values()), strict=True)
    return [{"case": name, **dict(zip(columns, row, strict=True))} for row in rows]


def contacts() -> list[Row]:
    """Contacts of all cases, a row each, in SI units; zero or infinite where a number is not used.

    A wall is a plane of the sphere's material; a second sphere is like the first, and speeds are
    relative.
    """
    return [_numbers(name, case) for name, case in CASES.items()]


def _numbers(name: str, case: Case) -> Row:
    contact, law = case.contact, case.contact.law
    closed = math.nan
    if case.closed_form is _snap:
        closed = float(np.sqrt(2.0 * jkr_loss(contact) / contact.mass))
    bare = RING_FORCE if contact.work_of_adhesion else "hertz"
    return {
        "case": name,
        "law": bare if law is None else law.name,
        "diameter_m": contact.diameter,
        "partner_diameter_m": contact.partner_diameter,
        "youngs_modulus_Pa": GLASS.youngs_modulus,
        "poissons_ratio": GLASS.poissons_ratio,
        "density_kg_per_m3": GLASS.density,
        "work_of_adhesion_J_per_m2": contact.work_of_adhesion or 0.0,
        "viscous_time_s": law.viscous_time if isinstance(law, JKR) else 0.0,
        "yield_pressure_Pa": law.yield_pressure if isinstance(law, ThorntonNing) else math.inf,
        "hertz_damping_s_per_m": contact.hertz_damping,
        "adhesion_damping_s_per_m": contact.adhesion_damping,
        "friction": contact.friction,
        "pull_off_force_N": contact.pull_off_force if law is not None else math.nan,
        "capture_velocity_m_per_s": float(capture_velocity(contact)),
        "capture_velocity_closed_form_m_per_s": closed,
    }


LAMMPS_CASE, LAMMPS_SPEED, LAMMPS_STEPS = "jkr-pair", 0.06, 5000


def lammps_test() -> str:
    """One impact of two spheres as a test of LAMMPS's granular suite, by its model of restitution.

    LAMMPS's coefficient of cohesion is half the work of adhesion. The spheres start a tenth of the
    contact time before they touch.
    """
    contact = CASES[LAMMPS_CASE].contact
    impact = planar(contact, -LAMMPS_SPEED, 0.0)
    time = float(impact.contact_time)
    radius, half = contact.radius, 0.5 * LAMMPS_SPEED
    step, ahead = time / LAMMPS_STEPS, LAMMPS_STEPS // 10
    coefficients = "jkr ${emod} 0.0 ${poisson} ${coh}"
    style = f"{coefficients} tangential linear_nohistory 0.0 0.0 damping velocity"
    return f"""\
---
lammps_version: 22 Jul 2025
tags: granular
date_generated: never
epsilon: 1e-10
skip_tests:
prerequisites: |
  atom sphere
  pair granular
pre_commands: |
  units si
  dimension 3
  boundary p p p
  atom_style sphere
  region box block {_span(8 * radius)} {_span(4 * radius)} {_span(4 * radius)} units box
  create_box 1 box
  create_atoms 1 single -${{sep}} 0.0 0.0 units box
  create_atoms 1 single ${{sep}} 0.0 0.0 units box
  set group all diameter ${{diam}} density ${{dens}}
  set atom 1 vx ${{vin}}
  set atom 2 vx -${{vin}}
  comm_modify vel yes
  neighbor {float(radius)!r} bin
  neigh_modify delay 0
  timestep {step!r}
post_commands: |
  fix integr all nve/sphere
input_file:
natoms: 2
variables: |
  diam {float(contact.diameter)!r}
  dens {GLASS.density!r}
  emod {GLASS.youngs_modulus!r}
  poisson {GLASS.poissons_ratio!r}
  coh {0.5 * WORK!r}
  vin {half!r}
  en {float(impact.coefficient_of_restitution)!r}
  radius {float(radius)!r}
  sep {float(radius) + half * ahead * step!r}
pair_style: granular
pair_coeff: |
  * * {style}
run_segments: |-
  {ahead // 2} {2 * LAMMPS_STEPS}
analytic_enable: yes
analytic_model: collision_restitution
analytic_tol: 0.01
analytic_segment: 1
analytic_only: yes
...
"""


def _span(half: Real) -> str:
    return f"{-float(half)!r} {float(half)!r}"
