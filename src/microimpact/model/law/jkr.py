"""Coefficients with which LAMMPS's granular contact ``jkr`` rebounds as a contact does.

Its damping ``viscoelastic`` is the one of `microimpact.model.contact_laws.JKR`: ``eta m a`` times
the speed of compression, with the contact radius a, so that ``eta = 2 E* A/m``. But its contact
breaks at the greatest pull, which loses half of JKR's energy. So the surface energy is chosen for
that break: an impact at the capture velocity just does not rebound. The damping then makes the
squares of the differences of e the least at the speeds that matter. Other codes' contacts, with
their damping, are fitted alike (`microimpact.model.law.codes`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
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
from microimpact.model.dynamics.laws import BROKEN, PULL_OFF, jkr_restitution
from microimpact.model.dynamics.normal import normal_impact

# Time steps of the shortest contact.
STEPS = 500
# Of the capture velocity: speeds of the fit where none are asked for.
FIRST, LAST, COUNT = 1.5, 15.0, 12
# e at normal speeds (n,), m/s, of a code's contact with a damping and a work of adhesion, J/m2.
Code = Callable[[float, float, FloatArray], FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coefficients:
    """Coefficients of an adhesive contact with damping, and its restitution beside the model's.

    Attributes
    ----------
    surface_energy
        gamma, J/m2: half the work of adhesion.
    damping
        As the code takes it: of a viscous JKR contact A, s.
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
    """Coefficients of a viscous JKR contact that breaks at ``end``, in s^3/b; else as `fitted`."""
    plain = contact.replace(stiffness_model="hertz")

    def rebounds(time: float, work: float, speed: FloatArray) -> FloatArray:
        return jkr_restitution(plain.by_law(JKR(viscous_time=time), work), speed, end=end)

    return fitted(contact, speeds, rebounds, 1e-3 * float(contact.radius / speeds.max()))


def fitted(contact: Contact, speeds: FloatArray, code: Code, damping: float) -> Coefficients:
    """Coefficients with the contact's capture velocity and, as near as may be, its e at speeds.

    Parameters
    ----------
    contact
        A single contact.
    speeds
        Normal speeds, m/s, above its capture velocity, (n,).
    code
        The other code's contact.
    damping
        Some small damping of it.

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
    largest, lowest = damping, 0.5 * float(restitution.min())
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


def speeds_of_fit(contact: Contact, speeds: Numbers | None, form: str) -> FloatArray:
    """Normal speeds of the fit, m/s: those asked for, or from 1.5 to 15 times the capture velocity.

    Raises TypeError or ValueError if they are no speeds, or the contact has nothing to be fitted.
    """
    if contact.shape:
        raise ValueError(f"format {form!r} is of one contact, got {contact.shape}")
    limit = float(capture_velocity(contact))
    if not math.isfinite(limit):
        raise ValueError("no sphere leaves this contact at any speed: there is nothing to fit")
    if speeds is None:
        if limit == 0.0:
            raise ValueError("speeds are needed where nothing is captured")
        speeds = limit * np.geomspace(FIRST, LAST, COUNT)
    return np.atleast_1d(np.asarray(checked("speeds", speeds, POSITIVE)))


def described(contact: Contact, fit: Coefficients) -> dict[str, str]:
    """Words and numbers of a fit that every code's file has."""
    tabor = float(tabor_number(contact))
    second = f" on {contact.partner_diameter * 1e6:g} um" if contact.is_pair else ""
    return {
        "version": version("microimpact"),
        "pair": f"{contact.particle.name} on {contact.surface.name}, "
        f"{contact.diameter * 1e6:g} um{second}",
        "limit": f"{float(capture_velocity(contact)):.6g}",
        "tabor": f"{tabor:.3g}: {contact_regime(tabor)}",
        "slowest": f"{fit.speeds.min():.4g}",
        "fastest": f"{fit.speeds.max():.4g}",
        "misfit": f"{fit.misfit:.3f}",
        "energy": f"{fit.surface_energy:.10g}",
        "diameter": repr(float(contact.diameter)),
        "friction": repr(float(contact.friction)),
        **{
            f"{role}_{name}": repr(float(getattr(getattr(contact, role), name)))
            for role in ("particle", "surface")
            for name in ("youngs_modulus", "poissons_ratio", "density")
        },
    }


def template(name: str, fields: dict[str, str]) -> str:
    """A template of this folder with its fields filled."""
    text = files(__package__).joinpath("templates", name).read_text(encoding="utf-8")
    return Template(text).substitute(fields)


def fit_table(fit: Coefficients) -> str:
    """Restitution of the model and of the fitted contact over speed, as CSV."""
    rows = zip(*(a.tolist() for a in (fit.speeds, fit.restitution, fit.fitted)), strict=True)
    return "normal_speed_m_per_s,restitution,restitution_of_fit\n" + "".join(
        f"{speed!r},{e!r},{own!r}\n" for speed, e, own in rows
    )


def lammps_files(contact: Contact, speeds: FloatArray) -> dict[str, str]:
    """Contents by name: an input of LAMMPS for a wall, and its e beside the model's.

    Raises ValueError as `fitted`.
    """
    fit, whole = (jkr_coefficients(contact, speeds, end) for end in (PULL_OFF, BROKEN))
    modulus, mass = float(contact_modulus(contact)), float(contact.mass)
    poissons_ratio, radius = float(contact.particle.poissons_ratio), float(contact.radius)
    fastest = float(speeds.max())
    step = float(np.min(normal_impact(contact, speeds).contact_time)) / STEPS
    fields = described(contact, fit) | {
        "whole": f"{whole.surface_energy:.6g}",
        "whole_damping": f"{2.0 * modulus * whole.damping / mass:.6g}",
        "start": repr(1.0005 * radius),
        "modulus": f"{2.0 * (1.0 - poissons_ratio**2) * modulus:.10g}",
        "damping": f"{2.0 * modulus * fit.damping / mass:.10g}",
        "speed": repr(fastest),
        "step": f"{step:.4g}",
        "steps": str(STEPS),
        "count": str(int(2 * STEPS + 0.001 * radius / (fastest * step))),
    }
    return {
        "in.microimpact_jkr": template("in.microimpact_jkr", fields),
        "microimpact_jkr.csv": fit_table(fit),
    }
