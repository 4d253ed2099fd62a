"""Coefficients with which LAMMPS's granular contact ``jkr`` rebounds as a contact does.

With the damping ``viscoelastic`` it is that of `microimpact.model.contact_laws.JKR`: ``eta m a``
times the speed of compression, with the contact radius a, so that ``eta = 2 E* A/m``. But it breaks
at the greatest pull, which loses half of JKR's energy.

The surface energy is chosen so that an impact at the capture velocity just does not rebound. The
damping then makes the squares of the differences of e the least at the speeds that matter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from string import Template

import numpy as np

from microimpact.core.arrays import POSITIVE, FloatArray, Numbers, checked
from microimpact.core.solve import threshold
from microimpact.model.closed_forms import contact_modulus, contact_regime, tabor_number
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.force_laws import BROKEN, PULL_OFF, jkr_restitution
from microimpact.model.dynamics.normal import normal_impact

LAMMPS = "lammps-jkr"
# Time steps of the shortest contact.
STEPS = 500
# Where the sphere starts and has left again, in radii; the longest run, in the time of the slowest.
START, PATIENCE = 1.0005, 20
# Of the capture velocity: speeds of the fit where none are asked for.
FIRST, LAST, COUNT = 1.5, 15.0, 12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coefficients:
    """Coefficients of a viscous JKR contact, and its restitution beside the model's.

    Attributes
    ----------
    surface_energy
        gamma, J/m2: half the work of adhesion.
    damping
        Relaxation time A, s.
    speeds, restitution, fitted
        Normal speeds, m/s, and e of the model and of the contact with these coefficients; (n,).
    """

    surface_energy: float
    damping: float
    speeds: FloatArray
    restitution: FloatArray
    fitted: FloatArray

    @property
    def misfit(self) -> float:
        """Largest difference of e at these speeds."""
        return float(np.max(np.abs(self.fitted - self.restitution)))


def jkr_coefficients(contact: Contact, speeds: FloatArray, end: float = PULL_OFF) -> Coefficients:
    """Coefficients of a viscous JKR contact with a contact's capture velocity and, nearly, its e.

    Parameters
    ----------
    contact
        A single contact.
    speeds
        Normal speeds, m/s, above its capture velocity, (n,).
    end
        Where the JKR contact breaks, in s^3/b of `microimpact.model.dynamics.force_laws`.

    Raises
    ------
    ValueError
        If a speed is not above the capture velocity, or no sphere ever leaves.
    """
    from scipy.optimize import minimize_scalar  # slow to import

    limit = float(capture_velocity(contact))
    if not np.all(speeds > limit):
        raise ValueError(
            f"speeds must be above the capture velocity {limit:.6g} m/s, got {speeds.min():g}"
        )
    restitution = np.asarray(normal_impact(contact, speeds).coefficient_of_restitution)
    plain = contact.replace(stiffness_model="hertz")

    def code(time: float, work: float, speed: FloatArray) -> FloatArray:
        return jkr_restitution(plain.by_law(JKR(viscous_time=time), work), speed, end=end)

    def work_at_capture(damping: float) -> float:
        if limit == 0.0:
            return 0.0
        slow = np.array([limit])

        def stays(work: float) -> bool:
            return bool(code(damping, work, slow)[0] == 0.0)

        most = 0.1
        while not stays(most):
            most *= 4.0
        return float(threshold(stays, 0.0, most, relative=1e-10))

    # Up to where the bulk alone loses more than the model does anywhere.
    largest, lowest = 1e-3 * float(contact.radius / speeds.max()), 0.5 * float(restitution.min())
    while np.max(code(largest, 0.0, speeds)) > lowest:
        largest *= 2.0

    def misfit(share: float) -> float:
        damping = largest * share**3
        return float(np.sum((code(damping, work_at_capture(damping), speeds) - restitution) ** 2))

    # A cube is as fine near zero, the best of a contact that loses nothing in the bulk.
    best = minimize_scalar(misfit, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-6})
    damping = largest * float(best.x) ** 3
    work = work_at_capture(damping)
    return Coefficients(
        surface_energy=0.5 * work,
        damping=damping,
        speeds=speeds,
        restitution=restitution,
        fitted=code(damping, work, speeds),
    )


def speeds_of_fit(contact: Contact, speeds: Numbers | None) -> FloatArray:
    """Normal speeds of the fit, m/s: those asked for, or from 1.5 to 15 times the capture velocity.

    Raises TypeError or ValueError if they are no speeds, or the contact has nothing to be fitted.
    """
    if contact.shape:
        raise ValueError(f"format {LAMMPS!r} is of one contact, got {contact.shape}")
    limit = float(capture_velocity(contact))
    if not math.isfinite(limit):
        raise ValueError("no sphere leaves this contact at any speed: there is nothing to fit")
    if speeds is None:
        if limit == 0.0:
            raise ValueError("speeds are needed where nothing is captured")
        speeds = limit * np.geomspace(FIRST, LAST, COUNT)
    return np.atleast_1d(np.asarray(checked("speeds", speeds, POSITIVE)))


def template(name: str, **fields: object) -> str:
    """A template of this folder with its fields filled."""
    text = files(__package__).joinpath("templates", name).read_text(encoding="utf-8")
    return Template(text).substitute(fields)


def lammps_files(contact: Contact, speeds: FloatArray) -> dict[str, str]:
    """Contents by name: an input of LAMMPS for a wall, and its e beside the model's.

    Raises ValueError as `jkr_coefficients`.
    """
    fit, whole = (jkr_coefficients(contact, speeds, end) for end in (PULL_OFF, BROKEN))
    modulus, mass, radius = (
        float(number) for number in (contact_modulus(contact), contact.mass, contact.radius)
    )
    poissons_ratio, tabor = float(contact.particle.poissons_ratio), float(tabor_number(contact))
    slowest, fastest = float(speeds.min()), float(speeds.max())
    times = normal_impact(contact, speeds).contact_time
    step = float(np.min(times)) / STEPS
    longest = PATIENCE * (float(np.max(times)) + (START - 1.0) * radius / slowest)
    text = template(
        "in.microimpact_jkr",
        version=version("microimpact"),
        pair=f"{contact.particle.name} on {contact.surface.name}, {contact.diameter * 1e6:g} um",
        limit=f"{float(capture_velocity(contact)):.6g}",
        tabor=f"{tabor:.3g}: {contact_regime(tabor)}",
        slowest=f"{slowest:.4g}",
        fastest=f"{fastest:.4g}",
        misfit=f"{fit.misfit:.3f}",
        energy=f"{fit.surface_energy:.10g}",
        whole=f"{whole.surface_energy:.6g}",
        whole_damping=f"{2.0 * modulus * whole.damping / mass:.6g}",
        diameter=repr(float(contact.diameter)),
        density=repr(float(contact.particle.density)),
        friction=repr(float(contact.friction)),
        poissons_ratio=repr(poissons_ratio),
        start=repr(START * radius),
        side=repr(2.0 * radius),
        modulus=f"{2.0 * (1.0 - poissons_ratio**2) * modulus:.10g}",
        damping=f"{2.0 * modulus * fit.damping / mass:.10g}",
        speed=repr(fastest),
        step=f"{step:.4g}",
        steps=STEPS,
        count=math.ceil(longest / step),
    )
    columns = (a.tolist() for a in (fit.speeds, fit.restitution, fit.fitted))
    rows = (",".join(map(repr, row)) for row in zip(*columns, strict=True))
    table = "\n".join(("normal_speed_m_per_s,restitution,restitution_of_fit", *rows, ""))
    return {"in.microimpact_jkr": text, "microimpact_jkr.csv": table}
