"""Coefficients of LAMMPS's granular contact ``jkr`` with which it rebounds as a contact does.

Its damping ``viscoelastic`` is the one of `microimpact.model.contact_laws.JKR`: ``eta m a`` times
the speed of compression, with the contact radius a, so that ``eta = 2 E* A/m``. But its contact
breaks at the greatest pull, which loses half of JKR's energy. So the surface energy is chosen for
that break: an impact at the capture velocity just does not rebound. The damping then makes the
squares of the differences of e the least at the speeds that matter.
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
from microimpact.model.dynamics.laws import BROKEN, PULL_OFF, jkr_restitution
from microimpact.model.dynamics.normal import normal_impact

# Time steps of the shortest contact.
STEPS = 500
# Of the capture velocity: speeds of the fit where none are asked for.
FIRST, LAST, COUNT = 1.5, 15.0, 12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coefficients:
    """Coefficients of a JKR contact with viscous damping, and its restitution beside the model's.

    Attributes
    ----------
    surface_energy
        gamma, J/m2: half the work of adhesion.
    viscous_time
        A, s.
    speeds, restitution, fitted
        Normal speeds, m/s, and e of the model and of the contact with these coefficients; (n,).
    """

    surface_energy: float
    viscous_time: float
    speeds: FloatArray
    restitution: FloatArray
    fitted: FloatArray

    @property
    def misfit(self) -> float:
        """Largest difference of e at these speeds."""
        return float(np.max(np.abs(self.fitted - self.restitution)))


def jkr_coefficients(contact: Contact, speeds: FloatArray, end: float = PULL_OFF) -> Coefficients:
    """Coefficients with the contact's capture velocity and, as near as may be, its e at speeds.

    Parameters
    ----------
    contact
        A single contact with a surface.
    speeds
        Normal speeds, m/s, above its capture velocity, (n,).
    end
        s^3/b at which the other code's contact breaks.

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

    def viscous(time: float, work: float) -> Contact:
        return plain.by_law(JKR(viscous_time=time), work)

    def work_at_capture(time: float) -> float:
        if limit == 0.0:
            return 0.0
        slow = np.array([limit])

        def stays(work: float) -> bool:
            return bool(jkr_restitution(viscous(time, work), slow, end=end)[0] == 0.0)

        most = 0.1
        while not stays(most):
            most *= 4.0
        return float(threshold(stays, 0.0, most, relative=1e-10))

    def fitted(time: float) -> FloatArray:
        return jkr_restitution(viscous(time, work_at_capture(time)), speeds, end=end)

    # Up to where the bulk alone loses more than the model does anywhere.
    longest = 1e-3 * float(contact.radius / speeds.max())
    lowest = 0.5 * float(restitution.min())
    while np.max(jkr_restitution(viscous(longest, 0.0), speeds, end=end)) > lowest:
        longest *= 2.0
    # A cube is as fine near zero, the best of a contact that loses nothing in the bulk.
    best = minimize_scalar(
        lambda share: float(np.sum((fitted(longest * share**3) - restitution) ** 2)),
        bounds=(0.0, 1.0),
        method="bounded",
        options={"xatol": 1e-6},
    )
    time = longest * float(best.x) ** 3
    return Coefficients(
        surface_energy=0.5 * work_at_capture(time),
        viscous_time=time,
        speeds=speeds,
        restitution=restitution,
        fitted=fitted(time),
    )


def lammps_files(contact: Contact, speeds: Numbers | None) -> dict[str, str]:
    """Contents by name: an input of LAMMPS for a wall, and its e beside the model's.

    Parameters
    ----------
    contact
        A single contact with a surface.
    speeds
        Normal speeds of the fit, m/s; None: from 1.5 to 15 times the capture velocity.

    Raises
    ------
    TypeError, ValueError
        As `jkr_coefficients`; without adhesion speeds are needed.
    """
    if contact.shape:
        raise ValueError(f"format 'lammps-jkr' is of one contact, got {contact.shape}")
    limit = float(capture_velocity(contact))
    if not math.isfinite(limit):
        raise ValueError("no sphere leaves this contact at any speed: JKR has nothing to fit")
    if speeds is None:
        if limit == 0.0:
            raise ValueError("speeds are needed where nothing is captured")
        speeds = limit * np.geomspace(FIRST, LAST, COUNT)
    v = np.atleast_1d(np.asarray(checked("speeds", speeds, POSITIVE)))
    fit, whole = (jkr_coefficients(contact, v, end) for end in (PULL_OFF, BROKEN))
    modulus, mass = float(contact_modulus(contact)), float(contact.mass)
    tabor = float(tabor_number(contact))
    poissons_ratio = float(contact.particle.poissons_ratio)
    fastest = float(v.max())
    times = normal_impact(contact, v).contact_time
    rows = zip(*(a.tolist() for a in (v, fit.restitution, fit.fitted)), strict=True)
    table = "normal_speed_m_per_s,restitution,restitution_of_jkr\n" + "".join(
        f"{speed!r},{e!r},{jkr!r}\n" for speed, e, jkr in rows
    )
    template = files(__package__) / "templates" / "in.microimpact_jkr"
    text = Template(template.read_text(encoding="utf-8")).substitute(
        version=version("microimpact"),
        pair=f"{contact.particle.name} on {contact.surface.name}, {contact.diameter * 1e6:g} um",
        limit=f"{limit:.6g}",
        tabor=f"{tabor:.3g}: {contact_regime(tabor)}",
        slowest=f"{v.min():.4g}",
        fastest=f"{fastest:.4g}",
        misfit=f"{fit.misfit:.3f}",
        whole=f"{whole.surface_energy:.6g}",
        whole_damping=f"{2.0 * modulus * whole.viscous_time / mass:.6g}",
        diameter=repr(float(contact.diameter)),
        radius=repr(float(contact.radius)),
        start=repr(1.0005 * float(contact.radius)),
        density=repr(float(contact.particle.density)),
        modulus=f"{2.0 * (1.0 - poissons_ratio**2) * modulus:.10g}",
        poissons_ratio=repr(poissons_ratio),
        energy=f"{fit.surface_energy:.10g}",
        damping=f"{2.0 * modulus * fit.viscous_time / mass:.10g}",
        friction=repr(float(contact.friction)),
        speed=repr(fastest),
        step=f"{float(np.min(times)) / STEPS:.4g}",
        steps=STEPS,
        count=int(2 * STEPS + 0.001 * float(contact.radius) / fastest / float(times.min()) * STEPS),
    )
    return {"in.microimpact_jkr": text, "microimpact_jkr.csv": table}
