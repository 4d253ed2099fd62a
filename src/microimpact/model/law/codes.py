"""Coefficients with which the contacts of LAMMPS, Lethe and YADE rebound as a contact does.

LAMMPS's ``granular`` contact ``jkr`` with the damping ``viscoelastic`` is that of
`microimpact.model.contact_laws.JKR`: ``eta m a`` times the speed of compression, with the contact
radius a, so that ``eta = 2 E* A/m``. But it breaks at the greatest pull, which loses half of JKR's
energy. Lethe and YADE know the overlap and its rate. Lethe's ``JKR`` closes and breaks at zero
overlap, so that nothing is lost but by its damping, ``2 (5/6)^(1/2) z (2 E* (R n)^(1/2) m)^(1/2)``
times the rate n' with ``z = -ln e/(ln^2 e + pi^2)^(1/2)``: without adhesion its restitution is the
e that is put in. YADE's Hertz and Mindlin contact has the pull of Derjaguin, Muller and Toporov,
``2 pi w R`` at any overlap, and the damping ``2 E* a A n'`` of Brilliantov et al. 1996, by e at a
speed (`yades_e`).

The surface energy is chosen so that an impact at the capture velocity just does not rebound. The
damping then makes the squares of the differences of e the least at the speeds that matter.
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
from microimpact.core.compiled import jit
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


def template(name: str, **fields: object) -> str:
    """A template of this folder with its fields filled."""
    text = files(__package__).joinpath("templates", name).read_text(encoding="utf-8")
    return Template(text).substitute(fields)


def fit_table(fit: Coefficients) -> str:
    """Restitution of the model and of the fitted contact over speed, as CSV."""
    rows = zip(*(a.tolist() for a in (fit.speeds, fit.restitution, fit.fitted)), strict=True)
    return "normal_speed_m_per_s,restitution,restitution_of_fit\n" + "".join(
        f"{speed!r},{e!r},{fitted!r}\n" for speed, e, fitted in rows
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
        "in.microimpact_jkr": template("in.microimpact_jkr", **fields),
        "microimpact_jkr.csv": fit_table(fit),
    }


LETHE, YADE = 0, 1
# Of a time step, in the time in which a sphere passes the depth of its impact; of steps.
STEP, LONGEST = 2e-3, 100_000
# Padé approximant of e over v* by its powers from 0 on (Mueller and Poeschel 2011), as in YADE.
OVER = (1.0, 1.07232, 0.574198, 0.141552)
UNDER = (1.0, 1.07232, 1.72765, 1.37842, 1.19449, 0.467273, 0.235585)


def lethe(contact: Contact) -> Code:
    """Lethe's contact ``JKR``; the damping is ``-ln e`` of the restitution that is put in."""
    modulus, _, mass = _bodies(contact)
    unit = 2.0 * math.sqrt(5.0 / 6.0) * math.sqrt(2.0 * modulus * mass)

    def rebounds(loss: float, work: float, speeds: FloatArray) -> FloatArray:
        return _rebounds(contact, LETHE, unit * loss / math.hypot(loss, math.pi), work, speeds)

    return rebounds


def yade(contact: Contact) -> Code:
    """YADE's ``MindlinPhys`` with ``includeAdhesion``; the damping is A, s."""
    modulus = _bodies(contact)[0]

    def rebounds(time: float, work: float, speeds: FloatArray) -> FloatArray:
        return _rebounds(contact, YADE, 2.0 * modulus * time, work, speeds)

    return rebounds


def _rebounds(
    contact: Contact, code: int, drag: float, work: float, speeds: FloatArray
) -> FloatArray:
    e = np.empty_like(speeds)
    restitutions(code, *_bodies(contact), drag, work, speeds, e)
    return e


@jit()
def force(
    code: int, modulus: float, radius: float, drag: float, work: float, overlap: float, rate: float
) -> float:
    """Force between two bodies, N, positive if it parts them, by a code's contact."""
    n = max(overlap, 0.0) * radius
    if code == YADE:
        adhesion = 2.0 * math.pi * work * radius
        elastic = 4.0 / 3.0 * modulus / radius * n**1.5 - adhesion
        damping = drag * math.sqrt(n) * rate
        # A damping that pulls is cut off at the adhesion; without any, the contact never pulls.
        if elastic + damping < 0.0:
            damping = max(damping, -adhesion) if adhesion > 0.0 else -elastic
        return float(elastic + damping)
    # x^4 - touch^(1/2) x = R n, of x = a^(1/2): Newton's method from above its root.
    root = math.sqrt(2.0 * math.pi * work * radius**2 / modulus)
    x = n**0.25 + root ** (1.0 / 3.0)
    change = x if root > 0.0 else 0.0
    while change > 1e-13 * x:
        change = (x**4 - root * x - n) / (4.0 * x**3 - root)
        x -= change
    elastic = modulus / radius * x**3 * (4.0 / 3.0 * x**3 - 2.0 * root)
    return float(elastic + drag * n**0.25 * rate)


@jit()
def restitutions(
    code: int,
    modulus: float,
    radius: float,
    mass: float,
    drag: float,
    work: float,
    speeds: FloatArray,
    e: FloatArray,
) -> None:
    """Restitutions by a code's contact, put into e: Runge's and Kutta's method of fourth order.

    The contact acts while there is overlap; a sphere that turns again before it has parted stays.
    """
    pull = (work**5 * radius**4 / modulus**2) ** (1.0 / 6.0) / math.sqrt(mass)
    for i in range(speeds.size):
        fast = max(speeds[i], pull)
        depth = (15.0 / 16.0 * mass * fast**2 / (modulus * math.sqrt(radius))) ** 0.4
        n, v, h, back = 0.0, speeds[i], STEP * depth / fast, False
        e[i] = 0.0
        ends = 0  # steps towards the end, once it is passed
        for _ in range(LONGEST):
            a = -force(code, modulus, radius, drag, work, n, v) / mass
            v_b = v + 0.5 * h * a
            b = -force(code, modulus, radius, drag, work, n + 0.5 * h * v, v_b) / mass
            v_c = v + 0.5 * h * b
            c = -force(code, modulus, radius, drag, work, n + 0.5 * h * v_b, v_c) / mass
            v_d = v + h * c
            d = -force(code, modulus, radius, drag, work, n + h * v_c, v_d) / mass
            n += h / 6.0 * (v + 2.0 * v_b + 2.0 * v_c + v_d)
            v += h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            if n <= 0.0 or ends > 0:
                ends += 1
                h = -n / v
                if ends == 4:
                    e[i] = -v / speeds[i]
                    break
            elif back and v >= 0.0:
                break
            back = back or v < 0.0


def yades_e(contact: Contact, time: float, speed: float) -> float:
    """Restitution without adhesion at a speed, m/s, from which YADE makes this A, s.

    ``A = 2/3 v*^2 (k/m)^(-2/5) speed^(-1/5)`` with ``k = 4/3 E* R^(1/2)``, and e is an approximant
    of v* (Mueller and Poeschel 2011).
    """
    modulus, radius, mass = _bodies(contact)
    rate = (4.0 / 3.0 * modulus * math.sqrt(radius) / mass) ** 0.4
    scaled = math.sqrt(1.5 * time * rate * speed**0.2)
    over, under = (np.polynomial.Polynomial(powers)(scaled) for powers in (OVER, UNDER))
    return float(over / under)


def _bodies(contact: Contact) -> tuple[float, float, float]:
    """Contact modulus, Pa, reduced radius, m, and reduced mass, kg."""
    return float(contact_modulus(contact)), float(contact.hertz_radius), float(contact.mass)


def lethe_files(contact: Contact, speeds: FloatArray) -> dict[str, str]:
    """Contents by name: parameters of Lethe for a sphere and a wall, and its e beside the model's.

    Raises ValueError as `fitted`.
    """
    fit = fitted(contact, speeds, lethe(contact), 1e-3)
    modulus, radius, _ = _bodies(contact)
    touch = (4.0 * math.pi * fit.surface_energy * radius**2 / modulus) ** (1.0 / 3.0)
    fields = described(contact, fit) | {
        "restitution": f"{math.exp(-fit.damping):.10g}",
        "touch": f"{touch:.2g}",
    }
    return {
        "microimpact_lethe.prm": template("microimpact_lethe.prm", **fields),
        "microimpact_lethe.csv": fit_table(fit),
    }


def yade_files(contact: Contact, speeds: FloatArray) -> dict[str, str]:
    """Contents by name: functors of YADE for a contact, and its e beside the model's.

    Raises ValueError as `fitted`.
    """
    longest = 1e-3 * float(contact.radius / speeds.max())
    fit = fitted(contact, speeds, yade(contact), longest)
    fastest = float(speeds.max())
    fields = described(contact, fit) | {
        "time": f"{fit.damping:.6g}",
        "speed": repr(fastest),
        "restitution": f"{yades_e(contact, fit.damping, fastest):.10g}",
    }
    return {
        "microimpact_yade.py": template("microimpact_yade", **fields),
        "microimpact_yade.csv": fit_table(fit),
    }


# Files of the codes whose contacts are fitted, by format.
FITTED = {"lammps-jkr": lammps_files, "lethe": lethe_files, "yade": yade_files}
