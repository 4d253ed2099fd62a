"""diffrax on JAX: all impacts in one compiled loop in double precision, Tsitouras' 5(4) method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from benchmarks.cases import Cases

jax.config.update("jax_enable_x64", True)

FOREVER = 1e6
MAX_STEPS = 4096
ROOT_TOLERANCE = 1e-14

State = tuple[jax.Array, jax.Array]
Groups = tuple[jax.Array, jax.Array]


def _slope(_t: jax.Array, y: State, groups: Groups) -> State:
    """The regular form; the groups are C_H, and C_A on the current leg."""
    (s, u), (hertz, adhesion) = y, groups
    p = s * s
    return 0.5 * u, p * (1.0 - adhesion * u - p * (1.0 + hertz * u))


def _turned(t: jax.Array, y: State, args: Groups, **_: Any) -> jax.Array:
    del t, args
    return y[1]


def _separated(t: jax.Array, y: State, args: Groups, **_: Any) -> jax.Array:
    del t, args
    return y[0]


def _captured(t: jax.Array, y: State, args: Groups, **_: Any) -> jax.Array:
    del t, args
    s, u = y
    return 0.5 * u * u + s**3 * (0.4 * s * s - 2.0 / 3.0)


def _leg(start: State, groups: Groups, tolerance: jax.Array, end: Callable[..., jax.Array]) -> Any:
    """Integrate to the leg's end; tell the state there and whether it was capture."""
    newton = optimistix.Newton(rtol=ROOT_TOLERANCE, atol=ROOT_TOLERANCE)
    run = diffrax.diffeqsolve(
        diffrax.ODETerm(_slope),
        diffrax.Tsit5(),
        0.0,
        FOREVER,
        None,
        start,
        groups,
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=1e-2 * tolerance),
        event=diffrax.Event([end, _captured], newton, direction=[False, False]),
        max_steps=MAX_STEPS,
        throw=False,
    )
    return (run.ys[0][-1], run.ys[1][-1]), run.event_mask[1]


@jax.jit
def _restitution(
    tolerance: jax.Array, speed: jax.Array, hertz: jax.Array, adhesion: jax.Array
) -> jax.Array:
    def one(w: jax.Array, c_h: jax.Array, c_a: jax.Array) -> jax.Array:
        turning, overdamped = _leg((0.0 * w, w), (c_h, 0.0 * c_a), tolerance, _turned)
        end, captured = _leg(turning, (c_h, c_a), tolerance, _separated)
        return jnp.where(captured | overdamped, 0.0, -end[1] / w)

    return jax.vmap(one)(speed, hertz, adhesion)


class Tsit5:
    """One call for all impacts; it takes as many steps as the longest of them needs."""

    name = "diffrax Tsit5"
    source = "diffrax"
    settings = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13)
    share = 40

    def __init__(self, cases: Cases, setting: float) -> None:
        self.arguments = (setting, cases.speed, cases.hertz, cases.adhesion)

    def __call__(self) -> np.ndarray:
        return np.asarray(_restitution(*self.arguments))
