"""Normal impacts by the laws of `microimpact.model.contact_laws`, mostly in closed form.

With a the contact radius, F = K a^3/R - (6 pi w K a^3)^(1/2) and compression
a^2/R - (2/3)(6 pi w a/K)^(1/2) (Johnson, Kendall and Roberts 1971), and with s the square root of
a/a_0, everything is a polynomial in s::

    force  s^6 - 6 b s^3      compression  s^4 - 4 b s      energy  2/5 s^10 - 4 b s^7 + 6 b^2 s^4

in units of K a_0^3/R, a_0^2/R and their product; b goes with the square root of the work of
adhesion. The contact closes where the compression is zero, at s^3 = 4 b, and breaks where the
compression is least, at s^3 = b. The unit a_0 is that at which the unit of speed is the impact's
own, or, below it, that of a contact with b = 1.

The energy holds elastic and surface energy, so that what is lost follows from its values at the
places where the contact closes, turns and breaks: only the times are quadratures. Where the work of
separation goes with the speed of the edge, the way back is integrated (`dynamics.peeling`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import BoolArray, Columns, FloatArray, Real, common_shape
from microimpact.core.computable import NotComputable
from microimpact.core.solve import roots
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, Hysteresis, MaugisBarquins, ThorntonNing
from microimpact.model.dynamics import peeling, viscous

# s^3/b of a JKR contact at touch, at the greatest pull and at the break of an impact.
CLOSED, PULL_OFF, BROKEN = 4.0, 3.0, 1.0

# Distance from the break, of its s, at which a path backwards begins; the energy that it neglects
# is the cube of it.
BACKWARD_START = 1e-6

# An edge that adds a smaller share x to the work of adhesion is too fast to matter: the break is
# late by x^(2/(2 + m)).
LEAST_EXCESS = 1e-20
# Logarithms of a capture velocity over that of JKR: the least, the first and the largest one tried,
# and the error.
LOG_RATIOS, LOG_ERROR = (-0.01, 1.0, 32.0), 1e-10

# Beyond this drag a rebound would keep less than 1e-14 of its speed, and takes too many steps.
LARGEST_DRAG = 1e3

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
_SINE, _COSINE = np.sin(0.25 * np.pi * (_NODES + 1.0)), np.cos(0.25 * np.pi * (_NODES + 1.0))
_WEIGHTS = 0.25 * np.pi * _WEIGHTS * _COSINE
# All of many impacts, with an axis for nodes.
COLUMN = (slice(None), None)
# Impacts whose times are integrated together.
ROWS = 128


@dataclass(frozen=True, slots=True)
class Scales:
    """Scales of length, velocity and mass of each impact (flat arrays, or one for all, SI)."""

    length: FloatArray
    velocity: FloatArray
    mass: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Problem(Columns):
    """Impacts in scaled form, every field (n,)."""

    speed: FloatArray  # Of approach, 1 or less
    # Strength b of adhesion while the contact grows, and while it shrinks.
    closing: FloatArray
    opening: FloatArray
    pressure: FloatArray  # Yield pressure; infinite where nothing yields
    drag: FloatArray  # Viscous loss in the bulk
    # Speed c and exponent m of the edge; infinite where it opens by its own work at any speed.
    edge_speed: FloatArray
    edge_exponent: FloatArray

    @property
    def peels(self) -> BoolArray:
        """Whether the speed of the edge changes the work of separation by more than rounding."""
        fastest = np.maximum(self.speed**0.6, self.closing)
        excess = (fastest / self.edge_speed) ** self.edge_exponent
        return np.asarray((excess > LEAST_EXCESS) & (self.closing > 0.0))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScaledOutcome(Columns):
    """Outcome of scaled impacts, every field (n,); impulses and energies per unit mass.

    As in `microimpact.model.dynamics.normal.NormalImpact`; ``deepest`` is s at the turning point,
    ``bulk`` and ``adhesion`` are the energies lost to either (adhesion: all else, if captured).
    """

    captured: BoolArray
    speed: FloatArray
    time: FloatArray
    turning_time: FloatArray
    deepest: FloatArray
    compressive: FloatArray
    greatest: FloatArray
    bulk: FloatArray
    adhesion: FloatArray


def scaled(contact: Contact, speed: Real) -> tuple[Problem, Scales, tuple[int, ...]]:
    """Write impacts of a contact with a law in scaled form, with the shape of the results.

    Raises ValueError if shapes do not broadcast, or an impact is too viscous for double precision.
    """
    shape = common_shape({"contact": contact.extent, "speed": speed})

    def flat(value: object) -> FloatArray:
        return np.full(shape, value, dtype=np.float64).ravel()

    law, v = contact.law, flat(speed)
    radius, mass, stiffness = (
        flat(value) for value in (contact.hertz_radius, contact.mass, contact.hertz_stiffness)
    )
    closing = flat(contact.work_of_adhesion)
    opening = flat(law.unloading_work) if isinstance(law, Hysteresis) else closing
    cube = np.pi * radius**2 / (6.0 * stiffness)  # a^3 at the break, per work of adhesion
    inertia = radius**2 * mass / stiffness
    unit_speed = np.maximum(v, np.sqrt((cube * opening) ** (5.0 / 3.0) / inertia))
    unit_speed[unit_speed == 0.0] = 1.0  # neither speed nor adhesion: any unit will do
    unit = (unit_speed**2 * inertia) ** 0.2
    length = unit**2 / radius
    pressure = law.yield_pressure if isinstance(law, ThorntonNing) else np.inf
    time = law.viscous_time if isinstance(law, JKR) else 0.0
    closed = np.sqrt(cube * closing / unit**3)
    edge: tuple[Real, Real] = (np.inf, 1.0)
    if isinstance(law, MaugisBarquins):
        edge = law.edge_speed, law.edge_exponent
    drag = 1.5 * flat(time) * unit_speed / length
    stiff = (drag > LARGEST_DRAG) & (drag * np.cbrt(closed) <= viscous.OVERDAMPED)
    if np.any(stiff):
        raise NotComputable(
            f"law.viscous_time must be at most {(flat(time) * LARGEST_DRAG / drag)[stiff].min():g} "
            f"s at these speeds, got {flat(time)[stiff].max():g}"
        )
    problem = Problem(
        speed=v / unit_speed,
        closing=closed,
        opening=np.sqrt(cube * opening / unit**3),
        pressure=np.pi * flat(pressure) * radius / (stiffness * unit),
        drag=drag,
        edge_speed=flat(edge[0]) * unit / (radius * unit_speed),
        edge_exponent=flat(edge[1]),
    )
    return problem, Scales(length, unit_speed, mass), shape


def force(s: FloatArray, b: FloatArray) -> FloatArray:
    """Force of a JKR contact."""
    cube = s * s * s
    return np.asarray(cube * (cube - 6.0 * b))


def energy(s: FloatArray, b: FloatArray, flattening: Real = 1.0) -> FloatArray:
    """Elastic and surface energy of a JKR contact, its radius of curvature ``flattening`` R.

    Parameters
    ----------
    s
        Square root of the scaled contact radius.
    b
        Strength of adhesion.
    flattening
        Radius of curvature over R.
    """
    cube = s * s * s
    flat = cube / flattening
    return np.asarray(cube * s * (flat * (0.4 * flat - 4.0 * b) + 6.0 * b * b))


def solve(problem: Problem) -> ScaledOutcome:
    """Solve scaled impacts: closed forms, or integration where bulk or edge dissipate."""
    peels = problem.peels
    others = _integrated if np.any(problem.drag > 0.0) else _quasi_static
    if not np.any(peels):
        return others(problem)
    if np.all(peels):
        return _peeled(problem)
    both = ScaledOutcome.joined([_peeled(problem.select(peels)), others(problem.select(~peels))])
    return both.select(np.argsort(np.argsort(~peels, kind="stable")))


def _peeled(problem: Problem) -> ScaledOutcome:
    b, v, drag = problem.closing, problem.speed, problem.drag
    closed = np.cbrt(4.0 * b)
    closing = followed(b, drag, closed, v, np.full_like(v, np.inf))
    top, turned = closing[:, viscous.TURNING_S], closing[:, viscous.STATUS] == viscous.REBOUND
    back = np.zeros((v.size, peeling.RESULT_COLUMNS))
    back[:, peeling.STATUS] = peeling.TURNED
    back[turned] = separated(problem.select(turned), top[turned])
    captured = back[:, peeling.STATUS] == peeling.TURNED
    approach = 0.5 * v**2 + energy(closed, b) - energy(top, b)
    bulk = np.where(drag > 0.0, approach + np.where(captured, 0.0, back[:, peeling.BULK]), 0.0)
    # JKR loses least at the edge; errors of integration are not to make it less.
    snap = energy(np.cbrt(b), b) - energy(closed, b)
    most = np.sqrt(np.maximum(v**2 - 2.0 * (bulk + snap), 0.0))
    speed = np.where(captured, 0.0, np.minimum(back[:, peeling.SPEED], most))
    turning = closing[:, viscous.TURNING_TIME]
    return ScaledOutcome(
        captured=captured,
        speed=speed,
        time=np.where(captured, np.inf, turning + back[:, peeling.TIME]),
        turning_time=turning,
        deepest=top,
        compressive=closing[:, viscous.COMPRESSIVE_IMPULSE] + back[:, peeling.RISE],
        greatest=v + np.maximum(back[:, peeling.HIGHEST_V], -closing[:, viscous.LOWEST_V]),
        bulk=bulk,
        adhesion=0.5 * (v**2 - speed**2) - bulk,
    )


def separated(problem: Problem, top: FloatArray, *, through: bool = False) -> FloatArray:
    """Results of `peeling.integrate`, of problems that have turned at s = ``top``.

    Raises RuntimeError if an integration failed.
    """
    edge, exponent = problem.edge_speed, problem.edge_exponent
    rows = np.stack([problem.closing, problem.drag, edge, exponent, top**2], axis=1)
    results = np.zeros((len(rows), peeling.RESULT_COLUMNS))
    peeling.integrate(rows, through, results)
    return _ended(rows, results, results[:, peeling.STATUS] == peeling.FAILED)


def _integrated(problem: Problem) -> ScaledOutcome:
    closed, broken = np.cbrt(4.0 * problem.closing), np.cbrt(problem.opening)
    results = followed(problem.closing, problem.drag, closed, problem.speed, broken)
    captured = results[:, viscous.STATUS] == viscous.CAPTURED
    speed = np.where(captured, 0.0, results[:, viscous.SPEED])
    turning = results[:, viscous.TURNING_S]
    started = 0.5 * problem.speed**2 + energy(closed, problem.closing)
    # All that was lost before the break, or before the turning point.
    bulk = started - 0.5 * speed**2 - energy(np.where(captured, turning, broken), problem.opening)
    return ScaledOutcome(
        captured=captured,
        speed=speed,
        time=np.where(captured, np.inf, results[:, viscous.TIME]),
        turning_time=results[:, viscous.TURNING_TIME],
        deepest=turning,
        compressive=results[:, viscous.COMPRESSIVE_IMPULSE],
        greatest=problem.speed - results[:, viscous.LOWEST_V],
        bulk=bulk,
        adhesion=0.5 * (problem.speed**2 - speed**2) - bulk,
    )


def followed(*columns: FloatArray) -> FloatArray:
    """Results of `viscous.integrate`, of problems given by its columns.

    Raises RuntimeError if an integration failed.
    """
    problems = np.stack(np.broadcast_arrays(*columns), axis=1)
    results = np.zeros((len(problems), viscous.RESULT_COLUMNS))
    viscous.integrate(problems, results)
    return _ended(problems, results, results[:, viscous.STATUS] == viscous.FAILED)


def _ended(problems: FloatArray, results: FloatArray, failed: BoolArray) -> FloatArray:
    if np.any(failed):
        raise RuntimeError(
            f"the integration of {np.count_nonzero(failed)} impact(s) failed; "
            f"the first in scaled form: {problems[np.argmax(failed)].tolist()}"
        )
    return results


@dataclass(frozen=True, slots=True)
class Loading(Columns):
    """Loading of scaled contacts: JKR, and plastic from the yield pressure in the middle on.

    Beyond, ``dF/ds = 4 p s^3 - 6 b s^2`` (Thornton and Ning 1998); force and stiffness do not jump.
    """

    b: FloatArray
    pressure: FloatArray
    closed: FloatArray
    yields: FloatArray

    @classmethod
    def of(cls, b: FloatArray, pressure: FloatArray) -> Loading:
        """Return the loading of contacts of adhesion b and yield pressure, infinite if elastic."""
        # Pressure in the middle, times s^4: 3/2 s^6 - 3 b s^3.
        soft = np.isfinite(pressure)
        finite, adhesion = pressure[soft], b[soft]
        yields = np.full(b.shape, np.inf)
        ends = np.cbrt(2.0 * adhesion), np.sqrt(finite / 1.5)  # with either part alone
        yields[soft] = roots(
            lambda s, b, p: 1.5 * s**3 - 3.0 * b - p * s,
            0.999 * np.maximum(*ends),
            1.001 * np.add(*ends),
            adhesion,
            finite,
        )
        return cls(b, np.where(soft, pressure, 0.0), np.cbrt(4.0 * b), yields)

    @property
    def _offset(self) -> FloatArray:
        s = np.where(np.isfinite(self.yields), self.yields, 0.0)
        return np.asarray(force(s, self.b) - self.pressure * s**4 + 2.0 * self.b * s**3)

    def force(self, s: FloatArray) -> FloatArray:
        """Force at s."""
        plastic = self._offset + self.pressure * s**4 - 2.0 * self.b * s**3
        return np.where(s <= self.yields, force(s, self.b), plastic)

    def _plastic_work(self, s: FloatArray) -> FloatArray:
        b, p = self.b, self.pressure
        cube = s * s * s
        fourth = cube * s
        yielding = p * fourth * s * (0.5 * cube - 0.8 * b)
        constant = self._offset * (fourth - 4.0 * b * s)
        return np.asarray(constant + yielding - b * fourth * (8.0 / 7.0 * cube - 2.0 * b))

    def work(self, s: FloatArray) -> FloatArray:
        """Work of compression from the closing of the contact to s."""
        if not np.any(self.pressure):
            return np.asarray(energy(s, self.b) - energy(self.closed, self.b))
        start = np.maximum(np.minimum(self.yields, s), self.closed)
        elastic = energy(start, self.b) - energy(self.closed, self.b)
        beyond = np.maximum(s, start)
        return np.asarray(elastic + (self._plastic_work(beyond) - self._plastic_work(start)))

    def deepest(self, speed: FloatArray) -> FloatArray:
        """Return s at which a speed is used up."""
        top = 2.0 * self.closed + 1.0
        while np.any(short := self.work(top) <= 0.5 * speed**2):
            top = np.where(short, 2.0 * top, top)
        shares = self.b, self.pressure, self.closed, self.yields, 0.5 * speed**2
        return roots(lambda s, *a: Loading(*a[:4]).work(s) - a[4], self.closed, top, *shares)

    def balance(self, deepest: FloatArray) -> FloatArray:
        """Return s where the force changes its sign."""
        radius = np.cbrt(6.0 * self.b)
        early = radius > self.yields
        if np.any(early):
            plastic = self.select(early)
            shares = plastic.b, plastic.pressure, plastic.closed, plastic.yields
            radius[early] = roots(
                lambda s, *a: Loading(*a).force(s), plastic.closed, deepest[early], *shares
            )
        return radius


@dataclass(frozen=True, slots=True)
class Unloading(Columns):
    """Unloading from s: at constant radius while adhesion grows, then JKR, to the break."""

    b: FloatArray
    top: FloatArray
    first_force: FloatArray
    flattening: FloatArray
    pinned: FloatArray

    @classmethod
    def of(cls, loading: Loading, opening: FloatArray, top: FloatArray) -> Unloading:
        """Return the unloading from the turning point ``top`` on, against another adhesion."""
        b, at_top = loading.b, loading.force(top)
        flattening = top**6 / (at_top + 6.0 * b * top**3)
        back = at_top - 3.0 * (opening - b) * top**3  # mean force at constant radius
        return cls(opening, top, at_top, flattening, back * 4.0 * (opening - b) * top)

    @property
    def end(self) -> FloatArray:
        """Return s at the break."""
        return np.minimum(np.cbrt(self.b * self.flattening), self.top)

    def regained(self, s: FloatArray) -> FloatArray:
        """Work regained down to s."""
        first, last = (energy(x, self.b, self.flattening) for x in (self.top, s))
        return np.asarray(self.pinned + first - last)


def _quasi_static(problem: Problem) -> ScaledOutcome:
    v, b = problem.speed, problem.closing
    loading = Loading.of(b, problem.pressure)
    top = loading.deepest(v)
    unloading = Unloading.of(loading, problem.opening, top)
    end, left = unloading.end, unloading.regained(unloading.end)
    captured = left <= 0.0
    speed = np.sqrt(2.0 * np.maximum(left, 0.0))
    fastest_in = np.sqrt(v**2 - 2.0 * loading.work(loading.balance(top)))
    # The force changes its sign on the way back by JKR, or already at constant radius.
    turns = np.cbrt(6.0 * unloading.b * unloading.flattening)
    regained = np.where(
        turns <= top,
        unloading.regained(np.minimum(turns, top)),
        unloading.first_force**2 / (3.0 * top**2),
    )
    fastest_out = np.sqrt(2.0 * np.maximum(regained, 0.0))
    turning_time = _some_at_a_time(_loading_time, loading, v, top)
    back = np.full(v.shape, np.inf)
    gone = ~captured
    back[gone] = _some_at_a_time(_unloading_time, unloading.select(gone), end[gone])
    plastic = energy(loading.closed, b) + loading.work(top) - energy(top, b, unloading.flattening)
    bulk = np.where(top > loading.yields, plastic, 0.0)
    return ScaledOutcome(
        captured=captured,
        speed=speed,
        time=turning_time + back,
        turning_time=turning_time,
        deepest=top,
        compressive=fastest_in + fastest_out,
        greatest=v + fastest_out,
        bulk=bulk,
        adhesion=0.5 * (v**2 - speed**2) - bulk,
    )


def _some_at_a_time(
    time: Callable[..., FloatArray], state: Loading | Unloading, *columns: FloatArray
) -> FloatArray:
    """Times (n,) by quadrature, whose temporary arrays stay in the cache."""
    times = np.empty(columns[0].size)
    for start in range(0, times.size, ROWS):
        rows = slice(start, start + ROWS)
        times[rows] = time(state.select(rows), *(column[rows] for column in columns))
    return times


def _loading_time(loading: Loading, v: FloatArray, top: FloatArray) -> FloatArray:
    """Time from touch to the turning point."""
    middle = np.clip(loading.yields, loading.closed, top)
    total = np.zeros_like(v)
    wide = loading.select(COLUMN)
    for first, last in ((loading.closed, middle), (middle, top)):
        if not np.any(last > first):
            continue
        # The sine takes the root of the speed at the turning point away.
        s = first[:, None] + (last - first)[:, None] * _SINE
        speed = np.sqrt(np.maximum(v[:, None] ** 2 - 2.0 * wide.work(s), 1e-300))
        step = 4.0 * (s**3 - wide.b) / speed * _WEIGHTS
        total += (last - first) * np.sum(step, axis=1)
    return total


def _unloading_time(unloading: Unloading, end: FloatArray) -> FloatArray:
    """Time from the turning point to the break, of contacts that break."""
    top, b = unloading.top, unloading.b
    at_end = top**3 * (top**3 / unloading.flattening - 6.0 * b)  # force after constant radius
    held = np.arccos(np.clip(at_end / unloading.first_force, -1.0, 1.0)) / (np.sqrt(1.5) * top)
    s = end[:, None] + (top - end)[:, None] * _SINE
    wide = unloading.select(COLUMN)
    speed = np.sqrt(2.0 * np.maximum(wide.regained(s), 1e-300))
    step = 4.0 * (s**3 / wide.flattening - wide.b) / speed * _WEIGHTS
    return np.asarray(held + (top - end) * np.sum(step, axis=1))


def capture_speed(contact: Contact) -> FloatArray:
    """Normal speed below which a contact with a law captures, m/s, in the contact's shape."""
    problem, scales, shape = scaled(contact, 0.0)
    speed = np.zeros(problem.speed.shape)
    adhesive = problem.opening > 0.0
    sticky = problem.select(adhesive)
    speed[adhesive] = (
        _backwards(sticky) if np.any(problem.drag > 0.0) else _stops_at_the_break(sticky)
    )
    slowed = adhesive & problem.peels & np.isfinite(speed)
    if np.any(slowed):
        speed[slowed] = _parts_at_rest(problem.select(slowed), speed[slowed])
    return np.asarray((speed * scales.velocity).reshape(shape)[()])


def _backwards(problem: Problem) -> FloatArray:
    """Speeds of scaled impacts that just end at the break, by time reversal."""
    broken = np.cbrt(problem.opening)
    start = broken * BACKWARD_START
    pace = np.sqrt(60.0) * problem.opening * start
    closed = np.cbrt(4.0 * problem.closing)
    results = followed(problem.opening, -problem.drag, broken + start, pace, closed)
    escaped = results[:, viscous.STATUS] == viscous.ESCAPED
    return np.where(escaped, np.inf, results[:, viscous.SPEED])


def _stops_at_the_break(problem: Problem) -> FloatArray:
    """Scaled speeds whose unloading regains just the energy needed: a root in s at the turning."""
    loading = Loading.of(problem.closing, problem.pressure)
    shares = (*(getattr(loading, name) for name in loading.__slots__), problem.opening)

    def left(log_s: FloatArray, *a: FloatArray) -> FloatArray:
        s = np.exp(log_s)
        unloading = Unloading.of(Loading(*a[:4]), a[4], s)
        return np.asarray(unloading.regained(unloading.end) / s**10)

    # From the balance of closing on, where at the latest the way back is all uphill.
    low = np.log(np.maximum(np.cbrt(6.0 * problem.closing), 1e-3 * np.cbrt(problem.opening)))
    high = low + 1.0
    while np.any(short := left(high, *shares) <= 0.0):
        high = np.where(short, high + 1.0, high)
    top = np.exp(roots(left, low, high, *shares))
    return np.sqrt(np.maximum(2.0 * loading.work(top), 0.0))


def _parts_at_rest(problem: Problem, least: FloatArray) -> FloatArray:
    """Scaled speeds at which the sphere stops as the contact parts, from those without an edge."""
    columns = {name: getattr(problem, name) for name in problem.__dataclass_fields__}

    def left(log_ratio: FloatArray, least: FloatArray, *values: FloatArray) -> FloatArray:
        speed = least * np.exp(log_ratio)
        return _left(Problem(**dict(zip(columns, values, strict=True)) | {"speed": speed}))

    rows = least, *columns.values()
    lowest, first, largest = LOG_RATIOS
    low, high = np.full_like(least, lowest), np.full_like(least, first)
    while np.any(short := left(high, *rows) <= 0.0) and np.max(high) < largest:
        low, high = np.where(short, high, low), np.where(short, 2.0 * high, high)
    there = ~short
    ratio = np.full_like(least, np.inf)
    ends = (each[there] for each in (low, high, *rows))
    ratio[there] = roots(left, *ends, absolute=LOG_ERROR)
    return least * np.exp(ratio - LOG_ERROR)  # of two neighbours the one that captures


def _left(problem: Problem) -> FloatArray:
    """Speed after over speed before an impact, negative if captured."""
    b, v = problem.closing, problem.speed
    closing = followed(b, problem.drag, np.cbrt(4.0 * b), v, np.full_like(v, np.inf))
    turned, left = closing[:, viscous.STATUS] == viscous.REBOUND, np.full_like(v, -1.0)
    back = separated(problem.select(turned), closing[turned, viscous.TURNING_S], through=True)
    parted = back[:, peeling.STATUS] == peeling.PARTED
    left[turned] = np.where(parted, back[:, peeling.SPEED] / v[turned], -1.0)
    return left


def jkr_restitution(
    contact: Contact, speed: FloatArray, start: float = CLOSED, end: float = BROKEN
) -> FloatArray:
    """Restitution of a JKR contact that may close and break elsewhere, as in some codes.

    Parameters
    ----------
    contact
        One contact, with the law JKR.
    speed
        Normal speeds, m/s, (n,).
    start, end
        s^3/b at which it closes and breaks.
    """
    problem, _, _ = scaled(contact, speed)
    first, last = np.cbrt(start * problem.closing), np.cbrt(end * problem.opening)
    results = followed(problem.closing, problem.drag, first, problem.speed, last)
    rebounds = results[:, viscous.STATUS] == viscous.REBOUND
    return np.where(rebounds, results[:, viscous.SPEED] / problem.speed, 0.0)
