"""SciPy's solve_ivp: two methods on the regular form, one call for each leg."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.cases import Cases

FOREVER = 1e6


class RK45:
    """One call after another."""

    name = "solve_ivp RK45"
    source = "scipy"
    method = "RK45"
    settings = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
    share = 800

    def __init__(self, cases: Cases, setting: float) -> None:
        self.cases, self.tolerance = cases, setting

    def __call__(self) -> np.ndarray:
        c = self.cases
        rows = zip(c.speed.tolist(), c.hertz.tolist(), c.adhesion.tolist(), strict=True)
        return np.array([self._restitution(*row) for row in rows])

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
                slope, (0.0, FOREVER), state, self.method,
                rtol=self.tolerance, atol=1e-2 * self.tolerance, events=events,
            )  # fmt: skip
            if not run.t_events[0].size:
                return 0.0
            state, damping = run.y[:, -1], adhesion
        return -state[1] / speed


class DOP853(RK45):
    name = "solve_ivp DOP853"
    method = "DOP853"
