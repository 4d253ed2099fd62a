"""Coefficients of the contacts of Lethe and YADE, and a table of restitution for a wall.

Both codes know the overlap and its rate. Lethe's ``JKR`` closes and breaks at zero overlap, so that
nothing is lost but by its damping, ``2 (5/6)^(1/2) z (2 E* (R n)^(1/2) m)^(1/2)`` times the rate n'
with ``z = -ln e/(ln^2 e + pi^2)^(1/2)``: without adhesion its restitution is the e that is put in.
YADE's Hertz and Mindlin contact has the pull of Derjaguin, Muller and Toporov, ``2 pi w R`` at any
overlap, and the damping ``2 E* a A n'`` of Brilliantov et al. 1996, by e at a speed (`yades_e`).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.compiled import jit
from microimpact.model.closed_forms import contact_modulus
from microimpact.model.contact import Contact
from microimpact.model.law.jkr import (
    Code,
    described,
    fit_table,
    fitted,
    lammps_files,
    template,
)

if TYPE_CHECKING:
    from microimpact.model.law.export import Rebounds

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

    Raises ValueError as `microimpact.model.law.jkr.fitted`.
    """
    fit = fitted(contact, speeds, lethe(contact), 1e-3)
    modulus, radius, _ = _bodies(contact)
    touch = (4.0 * math.pi * fit.surface_energy * radius**2 / modulus) ** (1.0 / 3.0)
    fields = described(contact, fit) | {
        "restitution": f"{math.exp(-fit.damping):.10g}",
        "touch": f"{touch:.2g}",
    }
    return {
        "microimpact_lethe.prm": template("microimpact_lethe.prm", fields),
        "microimpact_lethe.csv": fit_table(fit),
    }


def yade_files(contact: Contact, speeds: FloatArray) -> dict[str, str]:
    """Contents by name: functors of YADE for a contact, and its e beside the model's.

    Raises ValueError as `microimpact.model.law.jkr.fitted`.
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
        "microimpact_yade.py": template("microimpact_yade", fields),
        "microimpact_yade.csv": fit_table(fit),
    }


def acusolve_files(law: Rebounds, rows: FloatArray, words: list[str]) -> dict[str, str]:
    """Contents by name: e over normal speed for a wall of AcuSolve, and a text on its use.

    Parameters
    ----------
    law
        The rebound law of one size.
    rows
        Normal speeds above capture, m/s, and e, (2, n).
    words
        Lines that describe the law.
    """
    diameter = float(law.sizes.middle.diameter)
    limit = float(law.unit(diameter))
    first = [[0.0, limit], [0.0, 0.0]] if law.captures else [[0.0], [1.0]]
    last = np.array([law.fastest * (1.0 - 1e-12)])  # the end itself is in no piece of the table
    speed, e = np.concatenate([first, rows, [last, law(last, diameter)[0]]], axis=1)
    within = np.concatenate([speed[:-1] + share * np.diff(speed) for share in (0.25, 0.5)])
    misfit = np.max(np.abs(np.interp(within, speed, e) - law(within, diameter)[0]))
    lines = [
        *words,
        f"Between the rows e is right to {misfit:.1e}.",
        "Two columns, normal speed in m/s and e: wall_en_curve_fit_values of",
        "FINITE_MASS_BOUNDARY_CONDITION with wall_type = reflect, wall_en_type = piecewise_linear.",
        "A sphere with e = 0 keeps its velocity along the wall, which has no friction.",
    ]
    pairs = zip(speed.tolist(), e.tolist(), strict=True)
    return {
        "microimpact_restitution.txt": "".join(f"{v!r} {ratio!r}\n" for v, ratio in pairs),
        "microimpact_acusolve.txt": "\n".join(lines) + "\n",
    }


# Files of the codes whose contacts are fitted, by format.
FITTED = {"lammps-jkr": lammps_files, "lethe": lethe_files, "yade": yade_files}
