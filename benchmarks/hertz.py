"""Undamped Hertz impacts, where a closed form is known: contact time over Hertz's.

LAMMPS has no ring force and no Hunt-Crossley damping; this set is what it shares with the others.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import beta

from benchmarks.cases import Cases, as_contact
from microimpact.model.dynamics.normal import normal_impact


def hertz_time(cases: Cases) -> np.ndarray:
    """Contact time by Hertz, s: ``0.8 B(2/5, 1/2) (5/4)^(2/5) (m^2 / (r K^2 v))^(1/5)``."""
    contact, speed = as_contact(cases)
    scale = contact.mass**2 / (contact.radius * contact.stiffness**2 * speed)
    return 0.8 * beta(0.4, 0.5) * 1.25**0.4 * scale**0.2


class Package:
    """microimpact: the whole call, from a contact in SI units to every result of an impact."""

    name = "microimpact"
    source = "microimpact"
    settings = (1e-14,)
    share = 1

    def __init__(self, cases: Cases, setting: float) -> None:
        del setting
        contact, self.speed = as_contact(cases)
        self.contact = contact.replace(work_of_adhesion=0.0)
        self.expected = hertz_time(cases)

    def __call__(self) -> np.ndarray:
        return normal_impact(self.contact, self.speed).contact_time / self.expected


class DOP853:
    """SciPy: s = sqrt(x), u and the time, in the impact's own scale, from touch to separation."""

    name = "solve_ivp DOP853"
    source = "scipy"
    settings = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
    share = 80

    def __init__(self, cases: Cases, setting: float) -> None:
        self.number, self.tolerance = len(cases), setting
        self.expected = 0.8 * beta(0.4, 0.5) * 1.25**0.4

    def __call__(self) -> np.ndarray:
        return np.array([self._time() / self.expected for _ in range(self.number)])

    def _time(self) -> float:
        def slope(_t: float, y: np.ndarray) -> tuple[float, float, float]:
            s = float(y[0])
            return 0.5 * float(y[1]), -(s**4), s

        def separated(_t: float, y: np.ndarray) -> float:
            return y[0]

        separated.terminal, separated.direction = True, -1.0
        run = solve_ivp(
            slope, (0.0, 1e6), (0.0, 1.0, 0.0), "DOP853",
            rtol=self.tolerance, atol=1e-2 * self.tolerance, events=separated,
        )  # fmt: skip
        return float(run.y[2, -1])
