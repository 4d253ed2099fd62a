"""From records of a laboratory to rebounds: tracks of a camera, drop heights, times of bounces.

A track is cut into flights, each a path under gravity as the imaging system fits it. An impact is
where one flight meets the next: the place of the wall and the size of the sphere are not needed,
nor is the frame in which it touches. Velocities are those at that instant, in the frame of the
wall. The spin before impact is not known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from microimpact.core.arrays import (
    NON_NEGATIVE,
    POSITIVE,
    BoolArray,
    Columns,
    FloatArray,
    ObjectArray,
    checked,
)
from microimpact.core.constants import gravity
from microimpact.lab.events import IntArray, Measured
from microimpact.lab.ptis.tracks import Leg, fit_path

# Points of a flight. A cut, and the loss of a point at it, must explain more than chance does, and
# the velocity change by this share of the speed: drag or a distorted picture bend a flight, too.
LEAST_POINTS = 3
CUT, BLUR, KINK = 1e-4, 1e-3, 0.1
# Deviations of a flight that the scatter of all flights counts as (an empirical prior as of Smyth,
# 2004), and its multiple at which a flight is no single one.
PRIOR, ROUGH = 10.0, 5.0
# Standard deviations by which flights may miss each other, and one between rebound and rest.
MEETING, RESTING = 6.0, 3.0
# Shares of the speed before impact: a sphere at rest moves less; its speed is known better.
STILL, KNOWN = 0.01, 0.05
# Standard deviation of a wall that was found, degrees, at most.
FOUND = 1.0
# Air of 20 C: density and viscosity, kg/m3 and Pa s.
AIR_DENSITY, AIR_VISCOSITY = 1.204, 1.82e-5
# Of the integral over a fall through it, and of the search for the speed.
NODES, HALVINGS = 40, 60


@dataclass(frozen=True, slots=True, kw_only=True)
class Reduced(Columns):
    """Impacts of n rows; one that cannot be used has a reason, and no numbers.

    Attributes
    ----------
    track
        Name of the track, or number of the row, (n,).
    v, angle
        Speed before impact, m/s, and its angle from the wall, degrees, (n,).
    V, e, impulse_ratio
        Normal speed after impact, m/s, coefficient of restitution and impulse ratio, (n,).
    sigma, sigma_v
        Standard deviations of e, and of v: relatively that of its normal part, m/s, (n,).
    d
        Diameter, m, nan if it is not known, (n,).
    fall, sigma_fall
        Downward acceleration of the track itself and its standard deviation, m/s2, (n,).
    captured
        Whether it stays, (n,).
    reason
        Why there are no numbers; empty if there are, (n,).
    """

    track: ObjectArray
    v: FloatArray
    angle: FloatArray
    V: FloatArray
    e: FloatArray
    impulse_ratio: FloatArray
    sigma: FloatArray
    sigma_v: FloatArray
    d: FloatArray
    fall: FloatArray
    sigma_fall: FloatArray
    captured: BoolArray
    reason: ObjectArray

    @property
    def used(self) -> BoolArray:
        """Rows with numbers."""
        return np.equal(self.reason, "")

    @property
    def columns(self) -> dict[str, Any]:
        """Columns by their headers, as `microimpact.read_rebounds` takes them."""
        words = np.where(self.used, np.where(self.captured, "yes", "no"), "")
        names = {"v": "v (m/s)", "angle": "angle (deg)", "V": "V (m/s)", "e": "e"}
        names |= {"sigma": "sigma", "sigma_v": "sigma_v (m/s)", "impulse_ratio": "impulse_ratio"}
        if not np.any(self.sigma > 0.0):  # no error is known
            del names["sigma"], names["sigma_v"]
        columns = {"track": self.track} | {head: getattr(self, k) for k, head in names.items()}
        if np.any(np.isfinite(self.d)):
            columns["d (um)"] = 1e6 * self.d
        return columns | {"captured": words, "reason": self.reason}


def _reduced(
    track: ArrayLike,
    velocities: FloatArray,
    sigma: FloatArray,
    sigma_v: FloatArray,
    d: ArrayLike,
    *,
    captured: BoolArray,
    reason: ObjectArray,
    fall: tuple[ArrayLike, ArrayLike] = (np.nan, np.nan),
) -> Reduced:
    """Rows of velocities in the frame of the wall, (n, 2, 2) as in `Measured`."""
    n = len(velocities)
    velocities = np.where(captured[:, None, None] & (np.arange(2) == 1)[:, None], 0.0, velocities)
    measured = Measured(event=np.arange(n), velocities=velocities)
    before, after = measured.normal
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio, e = measured.impulse_ratio, measured.coefficient_of_restitution
        numbers = {
            "v": measured.speed,
            "angle": np.degrees(np.arctan2(-before, np.abs(measured.tangential[0]))),
            "V": after,
            "e": e,
            "impulse_ratio": np.where(captured, np.nan, ratio + 0.0),
            "sigma": np.where(captured, np.nan, sigma),
            "sigma_v": sigma_v * measured.speed / -before,
            "d": np.broadcast_to(np.asarray(d, dtype=float), n),
        }
    good = np.equal(reason, "")
    numbers = {name: np.where(good, x, np.nan) for name, x in numbers.items()}
    fallen = {"fall": fall[0], "sigma_fall": fall[1]}
    numbers |= {k: np.broadcast_to(np.asarray(x, dtype=float), n) for k, x in fallen.items()}
    names = np.asarray(track, dtype=object)
    return Reduced(track=names, **numbers, captured=captured & good, reason=reason)


def reduce_tracks(
    time: ArrayLike,
    x: ArrayLike,
    y: ArrayLike,
    track: Sequence[object] | None = None,
    *,
    wall: float | Literal["find"],
    diameter: ArrayLike = np.nan,
    tilt: float = 0.0,
    with_gravity: bool = True,
) -> Reduced:
    """Reduce tracks of spheres that hit a wall to rebounds.

    Errors follow from the scatter of the points about their flights, and from the tilt.

    Parameters
    ----------
    time
        Of the points, s, (n,).
    x, y
        Horizontal place, and height (upwards), m, (n,).
    track
        Name of the track of each point, (n,); None: all are of one.
    wall
        Direction of the wall, degrees from the horizontal towards the vertical; ``"find"``: that
        of the line on which the spheres turn.
    diameter
        m, one or (n,).
    tilt
        Standard deviation of the angle of the camera to wall and plumb line, degrees; all impacts
        share it.
    with_gravity
        Whether flights are paths under gravity, or straight lines.

    Raises
    ------
    TypeError, ValueError
        If a number is out of range, or a wall cannot be found.
    """
    t, points = _arrays(time, x, y)
    tilt = float(checked("tilt", tilt, NON_NEGATIVE))
    sizes = np.broadcast_to(np.asarray(diameter, dtype=float), t.shape)
    labels = [1] * t.size if track is None else [*track]
    if len(labels) != t.size:
        raise ValueError(f"track must have one name for each point, {t.size}, got {len(labels)}")
    rows: dict[object, list[int]] = {}
    for i in np.argsort(t, kind="stable").tolist():
        rows.setdefault(labels[i], []).append(i)
    order = [name for name in dict.fromkeys(labels) if name in rows]
    pull = gravity if with_gravity else 0.0
    lost: dict[object, str] = {}
    pairs: list[tuple[object, IntArray, IntArray]] = []
    for name in order:
        index = np.array(rows[name])
        flights, reason = _flights_of(t[index], points[index], pull)
        lost[name] = reason
        pairs += [(name, index[first], index[second]) for first, second in pairwise(flights)]
    impacts = _impacts(t, points, sizes, pairs, pull, wall, tilt)
    # A track has a row for each of its impacts, or one that says why there is none.
    parts = []
    for name in order:
        mine = np.flatnonzero([of is name or of == name for of in impacts.track])
        good = mine[impacts.used[mine]]
        if lost[name] or not mine.size:
            parts.append(_left_out(name, lost[name] or "no impact: it is one flight"))
        else:
            parts.append(impacts.select(good if good.size else mine[:1]))
    return Reduced.joined(parts)


def _arrays(time: ArrayLike, x: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:
    t, *coordinates = (np.ravel(checked(k, a)) for k, a in (("time", time), ("x", x), ("y", y)))
    if not t.size or any(of.size != t.size for of in coordinates):
        sizes = ", ".join(str(of.size) for of in (t, *coordinates))
        raise ValueError(f"time, x and y must be of one length above 0, got {sizes}")
    return t, np.stack(coordinates, axis=-1)


def _left_out(track: object, reason: str) -> Reduced:
    """One row without numbers."""
    unknown = np.full(1, np.nan)
    return _reduced(
        np.array([track, None], dtype=object)[:1],
        np.full((1, 2, 2), np.nan),
        unknown,
        unknown,
        unknown,
        captured=np.zeros(1, dtype=bool),
        reason=np.array([reason], dtype=object),
    )


def _flights_of(time: FloatArray, points: FloatArray, pull: float) -> tuple[list[slice], str]:
    """Flights of a track in order of time, or why there are none."""
    if time.size < 2 * LEAST_POINTS:
        return [], f"{time.size} points; {LEAST_POINTS} before and {LEAST_POINTS} after are needed"
    if (twice := np.flatnonzero(np.diff(time) <= 0.0)).size:
        return [], f"two points at {time[twice[0]]:g} s"
    places = points - points.mean(axis=0)
    flights = _flights(time, places, pull, 0)
    # The first cuts of many bounces were a compromise: neighbours are cut anew, where that is less.
    for width in (2, 3, 2):
        i = 0
        while i + width <= len(flights):
            part = slice(flights[i].start, flights[i + width - 1].stop)
            anew = _flights(time[part], places[part], pull, part.start)
            better = len(anew) < width or width == len(anew) == 2
            flights[i : i + width] = anew if better else flights[i : i + width]
            i += len(anew) >= width
    return flights, ""


def _flights(time: FloatArray, points: FloatArray, pull: float, begin: int) -> list[slice]:
    """Cut a track, again and again, where two flights explain it better than one."""
    n = time.size
    cut = np.arange(LEAST_POINTS, n - LEAST_POINTS + 1)
    if not cut.size:
        return [slice(begin, begin + n)]
    first = _squares(time, points, pull)
    last = _squares(-time[::-1], points[::-1], pull)[::-1]
    whole = max(first[n], np.finfo(float).tiny)
    rounding = 1e-13 * float(np.sum(points**2))
    cuts = first[cut] + last[cut] + rounding
    at, gap, free = int(np.argmin(cuts)), 0, 2 * n - 9
    if scipy.special.fdtrc(5, free, max(whole / cuts[at] - 1.0, 0.0) * free / 5) > CUT:
        return [slice(begin, begin + n)]
    if cut.size > 1:  # the frame of the impact, in which the sphere turns, may be of neither
        blurred = first[cut[:-1]] + last[cut[1:]] + rounding
        out = int(np.argmin(blurred))
        excess = max(cuts[at] / blurred[out] - 1.0, 0.0) * (free - 2) / 2
        if scipy.special.fdtrc(2, free - 2, excess) < BLUR:
            at, gap = out, 1
    k = int(cut[at])
    after = k + gap
    start, end = time[k - 1], time[after]
    legs = [fit_path(points[of], time[of] - zero, pull).velocity
            for of, zero in ((slice(k), start), (slice(after, n), end))]  # fmt: skip
    change = legs[1] - legs[0] + [0.0, pull * (end - start)]
    steps = np.diff(points, axis=0) / np.diff(time)[:, None]
    if np.sum(change**2) < KINK**2 * np.mean(np.sum(steps**2, axis=1)):
        return [slice(begin, begin + n)]
    return _flights(time[:k], points[:k], pull, begin) + _flights(
        time[after:], points[after:], pull, begin + after
    )


def _squares(time: FloatArray, points: FloatArray, pull: float) -> FloatArray:
    """Sum of squares about the flight through the first k points, k = 0 ... n.

    Of a path under gravity, or of a straight line, as of a sphere on the wall, if that is closer.
    """
    t = time - time[0]
    number = np.maximum(np.arange(time.size + 1), 1)

    def total(values: FloatArray) -> FloatArray:
        return np.concatenate([[0.0], np.cumsum(values)])

    t1 = total(t)
    spread = total(t * t) - t1**2 / number
    spread = np.where(spread > 0.0, spread, np.inf)
    x, y = points.T

    def left(values: FloatArray) -> FloatArray:
        s1, s2, cross = total(values), total(values**2), total(t * values)
        rest: FloatArray = s2 - s1**2 / number - (cross - t1 * s1 / number) ** 2 / spread
        return np.maximum(rest, 0.0)

    across, level = left(x), left(y)
    return across + (np.minimum(left(y + 0.5 * pull * t**2), level) if pull else level)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Legs:
    """A flight of each of k impacts, with places and velocities at the time 0.

    Attributes
    ----------
    time, used
        Of the points, s, and which count, (k, m).
    path
        The paths that are fitted.
    """

    time: FloatArray
    used: BoolArray
    path: Leg

    def residuals(self) -> FloatArray:
        """Points less their path, m, (k, m, 2); 0 where there is none."""
        t = self.time[..., None]
        level = self.path.points + 0.5 * np.array([0.0, self.path.gravity]) * t**2
        off = level - self.path.origin[:, None] - self.path.velocity[:, None] * t
        return np.where(self.used[..., None], off, 0.0)

    def bend(self) -> FloatArray:
        """How far unit acceleration bends the path off the fitted line, s2, (k, m)."""
        share, square = self.used / self.used.sum(axis=1, keepdims=True), 0.5 * self.time**2
        middle, mean = (np.sum(share * of, axis=1, keepdims=True) for of in (self.time, square))
        slope = np.sum(self.path.weights * square, axis=1, keepdims=True)
        return np.asarray(self.used * (square - mean - slope * (self.time - middle)))

    def spread(self) -> FloatArray:
        """Covariance of place and velocity of each component for unit noise, (k, 2, 2)."""
        share = self.used / self.used.sum(axis=1, keepdims=True)
        weights = self.path.weights
        position = share - weights * np.sum(share * self.time, axis=1, keepdims=True)
        both = np.stack([position, weights], axis=1)
        return np.asarray(both @ np.swapaxes(both, 1, 2))


def _legs(
    time: FloatArray, points: FloatArray, index: Sequence[IntArray], zero: FloatArray, pull: float
) -> _Legs:
    """Fit the points of each of k flights, filled up to arrays."""
    most = max(map(len, index))
    used = np.arange(most) < np.array([len(of) for of in index])[:, None]
    padded = np.array([np.pad(of, (0, most - len(of)), "edge") for of in index])
    t = time[padded] - zero[:, None]
    return _Legs(time=t, used=used, path=fit_path(points[padded], t, pull, used))


def _impacts(
    time: FloatArray,
    points: FloatArray,
    sizes: FloatArray,
    pairs: Sequence[tuple[object, IntArray, IntArray]],
    pull: float,
    wall: float | Literal["find"],
    tilt: float,
) -> Reduced:
    """Reduce pairs of flights, each with the name of its track."""
    if not pairs:
        return _left_out(None, "no impact")
    names, before, after = (list(of) for of in zip(*pairs, strict=True))
    gap = np.array([(time[a[-1]], time[b[0]]) for a, b in zip(before, after, strict=True)])
    zero = gap.mean(axis=1)
    incident = _legs(time, points, before, zero, pull)
    rebound = _legs(time, points, after, zero, pull)
    direction, uncertainty = (
        _wall(incident, rebound) if wall == "find" else (float(checked("wall", wall)), 0.0)
    )
    frame = _frames(incident, direction)
    legs = [incident, rebound]
    straight = [
        replace(leg, path=fit_path(leg.path.points, leg.time, 0.0, leg.used)) for leg in legs
    ]
    turn = float(np.hypot(tilt, uncertainty))
    noise, rough = _noise([*legs, straight[1]], frame, pull * np.radians(turn))
    # At rest, or on its way along the wall: no path under gravity is much closer.
    still = np.abs(_turn(frame, straight[1].path.velocity)[:, 1])
    blur = np.sqrt(noise[2][:, 1] * straight[1].spread()[:, 1, 1])
    speed = np.abs(_turn(frame, incident.path.velocity)[:, 1])
    level, curved = (np.sum(of.residuals() ** 2, axis=(1, 2)) for of in (straight[1], rebound))
    resting = (still < np.maximum(RESTING * blur, STILL * speed)) & (level <= 2.0 * curved)
    noise[1] = np.where(resting[:, None], noise[2], noise[1])
    rough[1] = np.where(resting, rough[2], rough[1])
    variance = np.stack([n[:, :, None, None] for n in noise[:2]], axis=1) * np.stack(
        [leg.spread()[:, None] for leg in legs], axis=1
    )
    # A picture that is turned turns the points, but not their fall.
    flat = np.stack([_flight(leg) for leg in straight], axis=1)
    bent = np.stack([_flight(leg) for leg in legs], axis=1) - flat
    bent[resting, 1] = 0.0
    fall = _turn(frame, np.broadcast_to([0.0, -pull], (len(pairs), 2)))

    def met(angle: float) -> _Meeting:
        """How the flights meet if the picture is turned by an angle, degrees."""
        sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
        position, slope = np.moveaxis(flat @ [[cosine, sine], [-sine, cosine]] + bent, 2, 0)
        of_legs = (
            np.stack([_turn(frame, of[:, leg]) for leg in (0, 1)], axis=1)
            for of in (position, slope)
        )
        return _meet(next(of_legs), next(of_legs), fall, variance)

    meeting = met(0.0)
    errors, missed = _errors(meeting, met(turn), met(-turn))
    reason = _reasons(meeting.velocities, errors, resting, blur / speed)
    step = np.array([np.ptp(time[of]) / (len(of) - 1) for of in before])
    early = np.abs(meeting.contact) > 0.5 * (gap[:, 1] - gap[:, 0]) + step
    for bad, words in (
        (early, "its flights meet elsewhere in time"),
        (missed > MEETING, "its flights do not meet"),
        (np.any(rough[:2], axis=0), "its points lie off a flight, more than those of others"),
    ):
        reason[bad & np.equal(reason, "")] = words
    d = np.array([np.nanmean(sizes[of]) if np.any(np.isfinite(sizes[of])) else np.nan
                  for of in before])  # fmt: skip
    return _reduced(
        np.array([*names, None], dtype=object)[:-1], meeting.velocities, *errors, d,
        captured=resting, reason=reason, fall=_fall(legs, resting),
    )  # fmt: skip


def _fall(legs: Sequence[_Legs], resting: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Downward acceleration that the points of both flights have, and its error, m/s2, (k,).

    The noise is that of all points about paths of any acceleration.
    """
    squares = free = 0.0
    total = information = np.zeros(len(resting))
    for leg, flies in zip(legs, (np.ones_like(resting), ~resting), strict=False):
        bend, off = leg.bend() * flies[:, None], leg.residuals()[..., 1]
        moment, inertia = np.sum(bend * off, axis=1), np.sum(bend**2, axis=1)
        total, information = total + moment, information + inertia
        telling = flies & (inertia > 0.0)
        squares += float(
            np.sum(np.sum(off**2, axis=1)[telling] - moment[telling] ** 2 / inertia[telling])
        )
        free += float(np.sum(leg.used[telling])) - 3.0 * np.count_nonzero(telling)
    with np.errstate(divide="ignore", invalid="ignore"):
        noise = np.sqrt(np.divide(max(squares, 0.0), free)) if free else np.inf
        return legs[0].path.gravity - total / information, noise / np.sqrt(information)


def _flight(leg: _Legs) -> FloatArray:
    """Place and velocity at the time 0, (k, 2, 2)."""
    return np.stack([leg.path.origin, leg.path.velocity], axis=1)


def _turn(frame: FloatArray, vectors: FloatArray) -> FloatArray:
    """Tangential and normal components (k, ..., 2) of horizontal and vertical ones."""
    turned_to: FloatArray = np.einsum("kij,k...j->k...i", frame, vectors)
    return turned_to


def _frames(incident: _Legs, direction: float) -> FloatArray:
    """Tangent and normal as rows, (k, 2, 2): along the flight, and against it."""
    angle = np.radians(direction)
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    along = incident.path.velocity @ axes.T * [1.0, -1.0]
    return np.asarray(np.where(along < 0.0, -1.0, 1.0)[..., None] * axes)


def _wall(incident: _Legs, rebound: _Legs) -> tuple[float, float]:
    """Direction of the line on which flights meet, and its standard deviation, degrees."""
    shift = rebound.path.origin - incident.path.origin
    slope = rebound.path.velocity - incident.path.velocity
    contact = -np.sum(shift * slope, axis=1) / np.sum(slope**2, axis=1)
    kinks = incident.path.at(contact)
    size, axes = np.zeros(2), np.eye(2)
    for _ in range(3):  # without those far off, which are of no wall
        centre = np.median(kinks, axis=0)
        _, size, axes = np.linalg.svd(kinks - centre, full_matrices=False)
        off = (kinks - centre) @ axes[-1]
        near = np.abs(off - np.median(off)) <= 5.0 * np.median(np.abs(off - np.median(off)))
        if near.sum() < LEAST_POINTS or len(size) < 2:
            break
        kinks = kinks[near]
    if len(kinks) < LEAST_POINTS or not size[0] > 0.0:
        raise ValueError(
            f"wall must be given: to find it takes {LEAST_POINTS} or more impacts at different "
            f"places, got {len(kinks)}"
        )
    spread = float(np.degrees(size[1] / size[0] / np.sqrt(len(kinks) - 2)))
    if not spread < FOUND:
        raise ValueError(
            f"wall must be given: the impacts tell its direction to {spread:.2g} degrees only, "
            f"{FOUND:g} is needed"
        )
    return float(np.degrees(np.arctan2(axes[0, 1], axes[0, 0]))), spread


def _noise(
    legs: Sequence[_Legs], frame: FloatArray, swing: float
) -> tuple[list[FloatArray], list[BoolArray]]:
    """Variance of tangential and normal places of each leg, m2, (k, 2), and which is rough (k,).

    Each leg's own scatter with that of all, of which the median is taken; it may lie off its flight
    as an acceleration, ``swing`` (m/s2), bends that.
    """
    squares = [np.sum(_turn(frame, leg.residuals()) ** 2, axis=1) for leg in legs]
    free = [(leg.used.sum(axis=1) - 2.0)[:, None] for leg in legs]
    # The rebounds by the closer of both paths.
    closer = np.minimum(squares[1].sum(axis=1), squares[2].sum(axis=1))[:, None]
    after = np.where(squares[1].sum(axis=1)[:, None] > closer, squares[2], squares[1])
    flown, number = np.concatenate([squares[0], after]), np.concatenate([free[0], free[0]])
    number[len(free[0]) :] = free[1]
    common = np.median(flown / scipy.special.chdtri(number, 0.5), axis=0)
    variance = [(s + PRIOR * common) / (n + PRIOR) for s, n in zip(squares, free, strict=True)]
    bends = [swing**2 * np.sum(leg.bend() ** 2, axis=1, keepdims=True) for leg in legs]
    rough = [np.any(s > ROUGH**2 * (n * np.maximum(common, 1e-18) + b), axis=1)
             for s, n, b in zip(squares, free, bends, strict=True)]  # fmt: skip
    return variance, rough


@dataclass(frozen=True, slots=True, kw_only=True)
class _Meeting:
    """How the two flights of each of k impacts meet.

    Attributes
    ----------
    contact
        Time at which they are closest, s, (k,).
    velocities
        Then, by leg and component, m/s, (k, 2, 2).
    covariance
        Of these four, (k, 4, 4).
    missed, error
        Distance then and its standard deviation, m, (k,).
    """

    contact: FloatArray
    velocities: FloatArray
    covariance: FloatArray
    missed: FloatArray
    error: FloatArray


def _meet(
    position: FloatArray, slope: FloatArray, fall: FloatArray, variance: FloatArray
) -> _Meeting:
    """Let the flights meet.

    Parameters
    ----------
    position, slope
        At the time 0, by leg and component, (k, 2, 2).
    fall
        Acceleration of both, (k, 2).
    variance
        Covariance of place and slope by leg and component, (k, 2, 2, 2, 2).
    """
    apart, change = position[:, 1] - position[:, 0], slope[:, 1] - slope[:, 0]
    square = np.maximum(np.sum(change**2, axis=1), np.finfo(float).tiny)
    contact = -np.sum(apart * change, axis=1) / square
    # Derivatives of the contact's time by places and slopes of the rebound; the others' are less.
    by_place = -change / square[:, None]
    by_slope = -(apart + 2.0 * contact[:, None] * change) / square[:, None]
    sign = np.array([-1.0, 1.0])[None, :, None, None]
    time = sign * np.stack([by_place, by_slope], axis=-1)[:, None]
    k = len(contact)
    by_leg = np.einsum("kc,klap->kclap", fall, time)[:, None].repeat(2, axis=1)
    for leg, part in np.ndindex(2, 2):
        by_leg[:, leg, part, leg, part, 1] += 1.0
    jacobian = by_leg.reshape(k, 4, 2, 2, 2)
    aside = np.stack([-change[:, 1], change[:, 0]], axis=-1) / np.sqrt(square)[:, None]
    t = np.stack([np.ones(k), contact], axis=-1)
    return _Meeting(
        contact=contact,
        velocities=slope + contact[:, None, None] * fall[:, None],
        covariance=np.einsum("kxlap,klapq,kylaq->kxy", jacobian, variance, jacobian),
        missed=np.sum(aside * apart, axis=1),
        error=np.sqrt(np.einsum("kc,klcpq,kp,kq->k", aside**2, variance, t, t)),
    )


def _errors(
    meeting: _Meeting, high: _Meeting, low: _Meeting
) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Standard deviations of e and of the normal speed, and how far flights miss, in theirs, (k,).

    Parameters
    ----------
    meeting
        As the wall is.
    high, low
        Turned by a standard deviation.
    """
    (before, after), (steep, flat) = meeting.velocities[..., 1].T, (
        of.velocities[..., 1].T for of in (high, low)
    )  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        gradient = np.stack([after / before**2, -1.0 / before], axis=-1)
        e = np.einsum("ki,kij,kj->k", gradient, meeting.covariance[:, 1::2, 1::2], gradient)
        e = np.hypot(np.sqrt(e), 0.5 * (steep[1] / steep[0] - flat[1] / flat[0]))
    v = np.hypot(np.sqrt(meeting.covariance[:, 1, 1]), 0.5 * (steep[0] - flat[0]))
    error = np.hypot(meeting.error, 0.5 * (high.missed - low.missed))
    return (e, v), np.abs(meeting.missed) / np.maximum(error, 1e-15)


def _reasons(
    velocities: FloatArray,
    errors: tuple[FloatArray, FloatArray],
    resting: BoolArray,
    unknown: FloatArray,
) -> ObjectArray:
    """Say why impacts cannot be used, in words, (k,)."""
    before, after = velocities[:, 0, 1], velocities[:, 1, 1]
    reasons = np.full(len(before), "", dtype=object)
    with np.errstate(divide="ignore", invalid="ignore"):
        e = -after / before
    for i in range(len(before)):
        if not errors[1][i] < -0.5 * before[i]:
            reasons[i] = "no impact: it does not move towards the wall"
        elif resting[i] and unknown[i] > KNOWN:
            reasons[i] = "a slow rebound cannot be told from rest"
        elif not resting[i] and not after[i] > 0.0:
            reasons[i] = "no impact: it does not turn at the wall"
        elif not resting[i] and e[i] > 1.0 + RESTING * errors[0][i]:
            reasons[i] = f"e = {e[i]:.3g} is above 1 by more than its error"
    return reasons


def reduce_heights(
    fallen: ArrayLike,
    risen: ArrayLike,
    *,
    sigma: ArrayLike = 0.0,
    diameter: ArrayLike = np.nan,
    density: float | None = None,
) -> Reduced:
    """Reduce heights of drop and rebound, of spheres released at rest, to rebounds.

    Parameters
    ----------
    fallen, risen
        Heights, m, (n,); a sphere that does not rise is captured.
    sigma
        Standard deviation of the heights, m.
    diameter
        m, one or (n,).
    density
        Of spheres in air of 20 C, kg/m3, with the drag of Stokes, Schiller and Naumann; None: in
        vacuum.

    Raises
    ------
    TypeError, ValueError
        If a number is out of range, or a diameter is missing.
    """
    h0 = np.ravel(checked("fallen", fallen, POSITIVE))
    h1 = np.ravel(checked("risen", risen, NON_NEGATIVE))
    if h0.shape != h1.shape:
        raise ValueError(f"fallen and risen must be of one length, got {h0.size} and {h1.size}")
    error = np.broadcast_to(checked("sigma", sigma, NON_NEGATIVE), h0.shape)
    d = np.broadcast_to(np.asarray(diameter, dtype=float), h0.shape)
    if density is not None:
        checked("density", density, POSITIVE)
        checked("diameter", np.array(d), POSITIVE)
    v, V = (_speed(h, d, density, sign) for h, sign in ((h0, -1.0), (h1, 1.0)))
    step = 1e-4 * h0
    dv, dV = (
        (_speed(h + step, d, density, sign) - _speed(np.maximum(h - step, 0.0), d, density, sign))
        / (step + np.minimum(h, step))
        for h, sign in ((h0, -1.0), (h1, 1.0))
    )
    captured = h1 == 0.0
    reason = np.where(v < V, "its rebound is faster than its impact", "").astype(object)
    return _normal(1 + np.arange(h0.size), v, V, np.hypot(dV, V / v * dv) * error / v, dv * error,
                   d, captured, reason)  # fmt: skip


def _speed(height: FloatArray, d: FloatArray, density: float | None, sign: float) -> FloatArray:
    """Speed at the wall, m/s, of a fall (sign -1) from, or a rise (1) to rest at a height, m."""
    free = np.sqrt(2.0 * gravity * height)
    if density is None:
        return free
    share, weights = scipy.special.roots_sh_legendre(NODES)

    def reached(speed: FloatArray) -> FloatArray:
        """Height at a speed, m: the integral of v dv over the deceleration."""
        v = speed[:, None] * np.append(share, 1.0)
        reynolds = AIR_DENSITY * v * d[:, None] / AIR_VISCOSITY
        drag = 18.0 * AIR_VISCOSITY * v / (density * d[:, None] ** 2)
        pull = gravity + sign * drag * (1.0 + 0.15 * reynolds**0.687)
        inner = np.where(pull > 0.0, pull, np.nan)
        rise = np.sum((weights * v[:, :-1] * speed[:, None]) / inner[:, :-1], axis=1)
        return np.where(pull[:, -1] > 0.0, rise, np.inf)  # no fall is faster than the last one

    low, high = 0.0 * free, free
    while np.any(short := reached(high) < height):
        high = np.where(short, 2.0 * high, high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        below = reached(middle) < height
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)


def reduce_times(times: ArrayLike, *, sigma: float = 0.0) -> Reduced:
    """Reduce the times at which one sphere bounces on a level wall, in vacuum, to rebounds.

    Parameters
    ----------
    times
        Of three or more bounces in turn, s, (n,); the result has n - 2 rows.
    sigma
        Standard deviation of the clock, s.

    Raises
    ------
    TypeError, ValueError
        If a number is out of range, or times do not ascend.
    """
    t = np.ravel(checked("times", times))
    error = float(checked("sigma", sigma, NON_NEGATIVE))
    flight = np.diff(t)
    if t.size < 3 or np.any(flight <= 0.0):
        raise ValueError(f"times must be three or more that ascend, got {t.tolist()}")
    v, V = 0.5 * gravity * flight[:-1], 0.5 * gravity * flight[1:]
    e = V / v
    # The bounce between both flights belongs to both.
    sigma_e = error / flight[:-1] * np.sqrt(1.0 + (1.0 + e) ** 2 + e**2)
    reason = np.where(e > 1.0 + RESTING * sigma_e, "its flight is longer than the one before", "")
    return _normal(1 + np.arange(v.size), v, V, sigma_e, np.full(v.size, gravity * error / 2**0.5),
                   np.nan, np.zeros(v.size, dtype=bool), reason.astype(object))  # fmt: skip


def _normal(
    track: NDArray[Any],
    v: FloatArray,
    V: FloatArray,
    sigma: FloatArray,
    sigma_v: FloatArray,
    d: ArrayLike,
    captured: BoolArray,
    reason: ObjectArray,
) -> Reduced:
    """Rows of normal impacts."""
    velocities = Measured.of_normal(np.arange(v.size), np.stack([-v, V], axis=-1)).velocities
    return _reduced(track, velocities, sigma, sigma_v, d, captured=captured, reason=reason)
