"""heyoka.py, adaptive Taylor integration, on the regular form: scalar, batch and reference."""

from __future__ import annotations

import math
from collections.abc import Callable

import heyoka as hy
import numpy as np

from benchmarks.cases import Cases

hy.set_nthreads(1)

FOREVER = 1e12
ENDED_BY_EVENT = -2  # outcome of the second of two terminal events: s = 0


def _system(s: hy.expression, u: hy.expression) -> list[tuple[hy.expression, hy.expression]]:
    """The regular form; par[0] = C_H, par[1] = C_A on the current leg."""
    p = s * s
    slope = p - p * p * (1.0 + hy.par[0] * u) - hy.par[1] * p * u
    return [(s, 0.5 * u), (u, slope)]


def _jkr(x: hy.expression, u: hy.expression) -> list[tuple[hy.expression, hy.expression]]:
    """The form of `benchmarks.cases.jkr_scales`; the viscous group is on both legs the same."""
    cube, group = x * x * x, hy.par[0] + hy.par[1]
    return [(x, u), (u, -(cube - 1.0) * (cube * (cube - 6.0) + group * x * x * u))]


class Scalar:
    """One integrator, built once; each impact is two runs, to u = 0 and on to the end of s.

    Capture is u = 0 for a second time: that costs less than an event for the energy.
    """

    name = "heyoka, scalar"
    source = "heyoka"
    settings: tuple[float, ...] = (1e-4, 1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-14)
    share = 1
    number = float
    fast_math = True
    system = staticmethod(_system)
    start, end = "0", "0"  # s at touch, and where the bodies part

    def __init__(self, cases: Cases, setting: float) -> None:
        s, u = hy.make_vars("s", "u")
        kind = {"fp_type": self.number}
        falling = hy.event_direction.negative
        self.integrator = hy.taylor_adaptive(
            self.system(s, u),
            [self.number(0), self.number(1)],
            pars=[self.number(0), self.number(0)],
            t_events=[
                hy.t_event(u, **kind),
                hy.t_event(s - self.number(self.end), direction=falling, **kind),
            ],
            tol=self.number(setting),
            high_accuracy=False,
            fast_math=self.fast_math,
            compact_mode=False,
            **kind,
        )
        self.cases = cases
        self.restitution = np.zeros(len(cases), dtype=self.number)

    def __call__(self) -> np.ndarray:
        run, e = self.integrator, self.restitution
        state, pars, go, number = run.state, run.pars, run.propagate_until, self.number
        touch, zero, end = number(self.start), number(0), number(FOREVER)
        for i, (speed, hertz, adhesion) in enumerate(self._rows()):
            state[0], state[1] = touch, speed
            pars[0], pars[1] = hertz, zero
            run.time = zero
            run.reset_cooldowns()
            go(end)
            pars[1] = adhesion
            ended = int(go(end)[0]) == ENDED_BY_EVENT
            e[i] = -state[1] / speed if ended else zero
        return e

    def _rows(self) -> zip:
        columns = (self.cases.speed, self.cases.hertz, self.cases.adhesion)
        return zip(*(c.astype(self.number).tolist() for c in columns), strict=True)


class Reference(Scalar):
    """The same in 80-bit numbers at a tolerance of 1e-18: what errors are measured against."""

    name = "heyoka, 80-bit reference"
    settings = (1e-18,)
    number = np.longdouble
    fast_math = False

    def _rows(self) -> zip:
        columns = (self.cases.speed, self.cases.hertz, self.cases.adhesion)
        return zip(*(c.astype(np.longdouble) for c in columns), strict=True)


class Jkr(Scalar):
    """Two JKR spheres, in the square root of the contact radius."""

    system = staticmethod(_jkr)
    start, end = "1.5874010519681994748", "1"  # the cube root of 4


class JkrReference(Reference, Jkr):
    """The same in 80-bit numbers."""


class Batch:
    """Several impacts side by side in SIMD registers; a lane that ends takes the next impact.

    One run over all impacts. The events' callbacks switch the damping and refill the lanes, and
    par[2] = 0 holds a lane for which nothing is left.
    """

    name = "heyoka, batch of 8"
    source = "heyoka"
    settings = Scalar.settings
    share = 1
    lanes = 8

    def __init__(self, cases: Cases, setting: float) -> None:
        self.cases = cases
        self.restitution = np.zeros(len(cases))
        self.rows: list[tuple[float, float, float]] = []
        self.waiting, self.owner = [0], [0] * self.lanes
        s, u = hy.make_vars("s", "u")
        turned, separated = self._callbacks()
        self.integrator = hy.taylor_adaptive_batch(
            [(x, hy.par[2] * slope) for x, slope in _system(s, u)],
            np.zeros((2, self.lanes)),
            pars=np.ones((3, self.lanes)),
            t_events=[
                hy.t_event_batch(u, callback=turned),
                hy.t_event_batch(s, callback=separated, direction=hy.event_direction.negative),
            ],
            tol=setting,
            high_accuracy=False,
            fast_math=True,
            compact_mode=False,
        )
        self.state, self.pars = self.integrator.state, self.integrator.pars

    def __call__(self) -> np.ndarray:
        c = self.cases
        self.rows[:] = zip(c.speed.tolist(), c.hertz.tolist(), c.adhesion.tolist(), strict=True)
        self.restitution[:] = math.nan
        self.waiting[0] = 0
        self.pars[2] = 1.0
        for lane in range(self.lanes):
            self._load(lane)
        self.integrator.set_time(0.0)
        self.integrator.reset_cooldowns()
        self.integrator.propagate_until(FOREVER)
        return self.restitution

    def _load(self, lane: int) -> None:
        impact = self.waiting[0]
        if impact == len(self.rows):
            self.pars[2, lane] = 0.0
            return
        self.waiting[0] = impact + 1
        self.owner[lane] = impact
        self.state[0, lane] = self.pars[1, lane] = 0.0
        self.state[1, lane], self.pars[0, lane], _ = self.rows[impact]

    def _callbacks(self) -> tuple[Callable[..., bool], Callable[..., bool]]:
        """What to do at u = 0 and at s = 0 (functions: heyoka would copy a bound method's self)."""
        rows, owner, e, load = self.rows, self.owner, self.restitution, self._load

        def turned(_integrator: object, sign: int, lane: int) -> bool:
            if sign < 0:
                self.pars[1, lane] = rows[owner[lane]][2]
            else:
                e[owner[lane]] = 0.0
                load(lane)
            return True

        def separated(_integrator: object, _sign: int, lane: int) -> bool:
            impact = owner[lane]
            e[impact] = -self.state[1, lane] / rows[impact][0]
            load(lane)
            return True

        return turned, separated
