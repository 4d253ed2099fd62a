"""The methods compared: each class is one way of computing e of many impacts, run on call.

What can be prepared once for any impacts (compiled code, integrators) is made in ``__init__`` and
not timed; everything that depends on the impacts' numbers is.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.cases import Cases, as_contact
from microimpact.model import kernel
from microimpact.model.normal import normal_impact, scaled_problems

FOREVER = 1e6


class Package:
    """microimpact: the whole call, from a contact in SI units to every result of an impact."""

    name = "microimpact"
    tolerance = kernel.TOLERANCE

    def __init__(self, cases: Cases) -> None:
        self.contact, self.speed = as_contact(cases)

    def __call__(self) -> np.ndarray:
        return normal_impact(self.contact, self.speed).coefficient_of_restitution


class Kernel:
    """The compiled kernel of microimpact alone, on problems that are scaled already."""

    name = "microimpact, kernel alone"
    tolerance = kernel.TOLERANCE

    def __init__(self, cases: Cases) -> None:
        self.problems = scaled_problems(*as_contact(cases))[0]
        self.results = np.zeros((len(cases), kernel.RESULT_COLUMNS))

    def __call__(self) -> np.ndarray:
        kernel.integrate(self.problems, kernel.PLAIN, self.results)
        captured = self.results[:, kernel.STATUS] == kernel.CAPTURED
        e = -self.results[:, kernel.END_U] / self.problems[:, kernel.START_U]
        return np.where(captured, 0.0, e)


class ScipyTimeForm:
    """solve_ivp as most would write it: x(t), damping switched inside the force, two events."""

    name = "SciPy RK45, time form"
    tolerance = 1e-8

    def __init__(self, cases: Cases) -> None:
        self.cases = cases

    def __call__(self) -> np.ndarray:
        rows = zip(*self._lists(), strict=True)
        return np.array([self._restitution(*row) for row in rows])

    def _lists(self) -> tuple[list[float], list[float], list[float]]:
        c = self.cases
        return c.speed.tolist(), c.hertz.tolist(), c.adhesion.tolist()

    def _restitution(self, speed: float, hertz: float, adhesion: float) -> float:
        def force(_t: float, y: np.ndarray) -> tuple[float, float]:
            x, v = max(float(y[0]), 0.0), float(y[1])
            ring = 1.0 - adhesion * v if v < 0.0 else 1.0
            root = math.sqrt(x)
            return v, root * (ring - x * (1.0 + hertz * v))

        def separated(_t: float, y: np.ndarray) -> float:
            return y[0]

        def captured(_t: float, y: np.ndarray) -> float:
            x = max(float(y[0]), 0.0)
            return 0.5 * y[1] ** 2 + math.sqrt(x) * x * (0.4 * x - 2.0 / 3.0)

        for event in (separated, captured):
            event.terminal, event.direction = True, -1.0
        run = solve_ivp(
            force, (0.0, FOREVER), (0.0, speed), "RK45",
            rtol=self.tolerance, atol=1e-4 * self.tolerance, events=(separated, captured),
        )  # fmt: skip
        return -run.y[1, -1] / speed if run.t_events[0].size else 0.0


class ScipyRegularForm(ScipyTimeForm):
    """solve_ivp at its best here: a high order on the regular form, one call for each leg."""

    name = "SciPy DOP853, regular form"
    tolerance = 1e-12

    def _restitution(self, speed: float, hertz: float, adhesion: float) -> float:
        state, damping = (0.0, speed), 0.0

        def slope(_t: float, y: np.ndarray) -> tuple[float, float]:
            s, u = float(y[0]), float(y[1])
            p = s * s
            return 0.5 * u, p * (1.0 - damping * u - p * (1.0 + hertz * u))

        def turned(_t: float, y: np.ndarray) -> float:
            return y[1]

        def separated(_t: float, y: np.ndarray) -> float:
            return y[0]

        def captured(_t: float, y: np.ndarray) -> float:
            s, u = float(y[0]), float(y[1])
            return 0.5 * u * u + s**3 * (0.4 * s * s - 2.0 / 3.0)

        for event in (turned, separated, captured):
            event.terminal, event.direction = True, -1.0
        for events in ((turned, captured), (separated, captured)):
            run = solve_ivp(
                slope, (0.0, FOREVER), state, "DOP853",
                rtol=self.tolerance, atol=1e-2 * self.tolerance, events=events,
            )  # fmt: skip
            if not run.t_events[0].size:
                return 0.0
            state, damping = run.y[:, -1], adhesion
        return -state[1] / speed
