"""SciPy's solve_ivp: four methods on the regular form, and the time form as most write it."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.cases import Cases

FOREVER = 1e6


class _Scipy:
    """One call of `_restitution` after another."""

    source = "scipy"
    method = ""
    share = 800

    def __init__(self, cases: Cases, setting: float) -> None:
        self.cases, self.tolerance = cases, setting

    def __call__(self) -> np.ndarray:
        c = self.cases
        rows = zip(c.speed.tolist(), c.hertz.tolist(), c.adhesion.tolist(), strict=True)
        return np.array([self._restitution(*row) for row in rows])

    def _restitution(self, speed: float, hertz: float, adhesion: float) -> float:
        raise NotImplementedError


class TimeForm(_Scipy):
    """x(t) with the damping switched inside the force, and two events."""

    name = "solve_ivp RK45, time form"
    method = "RK45"
    settings = (1e-4, 1e-6, 1e-8, 1e-10)

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
            force, (0.0, FOREVER), (0.0, speed), self.method,
            rtol=self.tolerance, atol=1e-4 * self.tolerance, events=(separated, captured),
        )  # fmt: skip
        return -run.y[1, -1] / speed if run.t_events[0].size else 0.0


class _RegularForm(_Scipy):
    """solve_ivp at its best here: smooth equations, one call for each leg."""

    with_jacobian = False

    def _restitution(self, speed: float, hertz: float, adhesion: float) -> float:
        state, damping = (0.0, speed), 0.0

        def slope(_t: float, y: np.ndarray) -> tuple[float, float]:
            s, u = float(y[0]), float(y[1])
            p = s * s
            return 0.5 * u, p * (1.0 - damping * u - p * (1.0 + hertz * u))

        def jacobian(_t: float, y: np.ndarray) -> tuple[tuple[float, float], ...]:
            s, u = float(y[0]), float(y[1])
            p = s * s
            along = 2.0 * s * (1.0 - damping * u) - 4.0 * s * p * (1.0 + hertz * u)
            return (0.0, 0.5), (along, -p * (damping + hertz * p))

        def turned(_t: float, y: np.ndarray) -> float:
            return y[1]

        def separated(_t: float, y: np.ndarray) -> float:
            return y[0]

        def captured(_t: float, y: np.ndarray) -> float:
            s, u = float(y[0]), float(y[1])
            return 0.5 * u * u + s**3 * (0.4 * s * s - 2.0 / 3.0)

        for event in (turned, separated, captured):
            event.terminal, event.direction = True, -1.0
        extra = {"jac": jacobian} if self.with_jacobian else {}
        for events in ((turned, captured), (separated, captured)):
            run = solve_ivp(
                slope, (0.0, FOREVER), state, self.method,
                rtol=self.tolerance, atol=1e-2 * self.tolerance, events=events, **extra,
            )  # fmt: skip
            if not run.t_events[0].size:
                return 0.0
            state, damping = run.y[:, -1], adhesion
        return -state[1] / speed


class RK45(_RegularForm):
    name = "solve_ivp RK45"
    method = "RK45"
    settings = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)


class DOP853(_RegularForm):
    name = "solve_ivp DOP853"
    method = "DOP853"
    settings = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)


class LSODA(_RegularForm):
    name = "solve_ivp LSODA"
    method = "LSODA"
    settings = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
    with_jacobian = True


class Radau(_RegularForm):
    name = "solve_ivp Radau"
    share = 2000
    method = "Radau"
    settings = (1e-4, 1e-6, 1e-8, 1e-10)
    with_jacobian = True
