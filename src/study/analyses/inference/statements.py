"""The article's statements on a contact, as likelihoods: an interval, and normal tails beyond it.

Each statement has a value for every contact: of its own spheres, speeds and angles, the mean over
the sizes of the spheres that rebound. Where a basis of friction, a size or an angle is open, it has
one for each.

Velocities are measured about a nominal normal. Where the true one is turned by a small phi, a
sphere meets the surface at the angle alpha + phi, and to first order (Section 4.1)

    e_m = e + phi ((1 + e)(cot(alpha) - mu) + v cos(alpha) de/dv_n),   mu_m = mu + (1 + mu^2) phi,

so that the value of a statement has a normal error, independent from one setting of the target to
the next. The likelihood is the mean over it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import scipy
from pydantic import Field

from microimpact.core.arrays import BoolArray, FloatArray, Real, part_of
from microimpact.core.solve import IntArray
from microimpact.model.calibration import peak_ratios
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar, velocity_components
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.rigid_body.roughness import ROLLING_SHARE
from microimpact.statistics.distributions import Distribution
from study.declared.parameters import AngleDegrees, Ascending, Count, Finite, Name, Positive

# Logarithm of the likelihood where there is no value: a captured sphere never leaves.
IMPOSSIBLE = -1e6
# Of a deviation without an error, in tails; and a turn by which values are derived, rad.
NO_ERROR, TURN = 1e-9, 1e-3
# Contacts this far below the best one of a batch, their worst statement aside, are dropped.
UNLIKELY = 60.0
# A contact is consistent with a statement that it misses by no more standard deviations than these.
CONSISTENT = 2.0
# Nodes over the sizes of a class (Gauss and Hermite), and over those of a share that is captured.
_ROOTS, _WEIGHTS = np.polynomial.hermite_e.hermegauss(3)
NODES = np.array([0.5 * math.erfc(-root / math.sqrt(2.0)) for root in _ROOTS])
WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
SHARES = (np.arange(40) + 0.5) / 40
# Below this share captured none is, for the formula that divides by it.
SMALLEST_SHARE = 1e-9
# Nodes per damping of the ratio of dissipation and adhesion, and points of the paths behind it.
RATIO_NODES, RATIO_POINTS = 7, 200

Quantity = Literal[
    "restitution",
    "fall of restitution",
    "impulse ratio",
    "change of impulse ratio",
    "contact time in ns",
    "capture velocity in m/s",
    "share captured",
    "adhesion over hertz",
    "dissipation over adhesion",
]
FRICTIONAL = ("impulse ratio", "change of impulse ratio")
OF_CAPTURE = ("capture velocity in m/s", "share captured")
# Before the name of a statement: how fast its value changes as normals turn, per radian; and with a
# normal that statements share, and with others.
TURNING, SHARED, OWN = "turning ", "shared ", "own "
Values = dict[str, FloatArray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """A sentence of the article and the interval into which it puts a quantity."""

    words: Name  # Short quotation, and where it stands
    # Of the interval: printed, derived from what is printed, or inferred from what was not seen.
    standing: Literal["printed", "derived", "inferred"]
    # A fall is the first less the last of the impacts, a change the first over the last; all else
    # is the mean over them.
    quantity: Quantity
    diameter_um: Distribution | None = None  # None where the article leaves open which class
    # Of the impacts; one of both may stand for all. Of a share captured, the ends of its speeds.
    speeds_m_per_s: Annotated[tuple[Positive, ...], Field(min_length=1)] = (1.0,)
    angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=1)] = (90.0,)
    # Where the likelihood is one, in the unit that the quantity names; normal tails beyond.
    interval: Annotated[tuple[Finite, Finite], Ascending]
    tail: Positive
    spheres: Count = 1  # Looked at, of a share captured
    is_open: bool = False  # One of its impacts is meant; which, is not stated
    # A statement of the same experiments as its first impact: both have one error of the normal.
    same_normal_as: Name | None = None

    def __post_init__(self) -> None:
        """Refuse impacts that cannot be paired."""
        if len({len(self.speeds_m_per_s), len(self.angles_deg)} - {1}) > 1:
            raise ValueError("speeds_m_per_s and angles_deg must be as many, or one of them one")
        if self.diameter_um is None and self.quantity != OF_CAPTURE[0]:
            raise ValueError(f"diameter_um must be given for {self.quantity}")

    @property
    def median_diameter_um(self) -> float | None:
        """Median of its diameters, None where they are open."""
        return None if self.diameter_um is None else float(self.diameter_um.quantile(np.array(0.5)))

    def impacts(self) -> FloatArray:
        """Diameter (um), normal and tangential speed of its impacts (impacts, nodes, 3)."""
        assert self.diameter_um is not None
        v_n, v_t = velocity_components(np.array(self.speeds_m_per_s), np.array(self.angles_deg))
        columns = (
            self.diameter_um.quantile(NODES),
            -np.asarray(v_n)[:, None],
            np.asarray(v_t)[:, None],
        )
        return np.stack(np.broadcast_arrays(*columns), axis=-1)

    def value(self, of_impacts: FloatArray) -> FloatArray:
        """Its quantity from values at impacts and nodes (..., impacts, nodes), nan for captured."""
        seen = np.isfinite(of_impacts) * WEIGHTS
        with np.errstate(invalid="ignore"):
            means = np.sum(np.nan_to_num(of_impacts) * WEIGHTS, axis=-1) / np.sum(seen, axis=-1)
        if self.quantity == "fall of restitution":
            return np.asarray(means[..., 0] - means[..., -1])
        if self.quantity == "change of impulse ratio":
            return np.asarray(means[..., 0] / means[..., -1])
        return means if self.is_open else np.asarray(np.mean(means, axis=-1))

    def turning(self, of_impacts: FloatArray, rates: FloatArray) -> FloatArray:
        """How fast its value changes as normals turn: root of the sum of squares over impacts.

        Parameters
        ----------
        of_impacts
            As in `value`.
        rates
            Their changes per radian, alike.
        """
        return np.asarray(np.sqrt(np.sum(np.square(self._turned(of_impacts, rates)), axis=0)))

    def turning_together(self, of_impacts: FloatArray, rates: FloatArray) -> FloatArray:
        """How fast its value changes with the normal that it shares, and with its own (2,).

        With sign, and the root of the sum of squares; arguments as in `turning`. An open statement
        shares that of the impact that is meant, any other that of the first.
        """
        changes = self._turned(of_impacts, rates)
        shared = len(changes) if self.is_open else 1
        separate = np.sqrt(np.sum(np.square(changes[shared:]), axis=0))
        return np.stack([np.sum(changes[:shared], axis=0), separate])

    def _turned(self, of_impacts: FloatArray, rates: FloatArray) -> FloatArray:
        value, turned = self.value(of_impacts), np.eye(of_impacts.shape[-2])[:, :, None] * TURN
        return np.array([self.value(of_impacts + rates * each) - value for each in turned]) / TURN

    def captured(self, limits: FloatArray, classes_um: FloatArray) -> FloatArray:
        """Share of its spheres that are captured, from capture velocities (n, classes) in m/s."""
        assert self.diameter_um is not None
        diameter, (low, high) = self.diameter_um.quantile(SHARES), self.speeds_m_per_s
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.log(limits[:, -1] / limits[:, 0]) / np.log(classes_um[-1] / classes_um[0])
            limit = limits[:, :1] * (diameter / classes_um[0]) ** slope[:, None]
        speed = limit / np.sin(np.radians(self.angles_deg[0]))
        return np.asarray(np.mean(np.clip((speed - low) / (high - low), 0.0, 1.0), axis=1))

    def log_likelihood(
        self,
        value: FloatArray,
        interval: tuple[float, float],
        tails: float = 1.0,
        error: Real = 0.0,
    ) -> FloatArray:
        """Logarithm of the likelihood: one inside the interval, and the mean over a normal error.

        Of a share p captured among n spheres of which none was noticed: ``int (1 - q p)^n dq``,
        the share q of captures that would have been noticed being unknown, uniform from 0 to 1.

        Parameters
        ----------
        value
            What contacts have.
        interval
            In place of its own.
        tails
            Factor that stretches its tails.
        error
            Standard deviation of the value.
        """
        if self.quantity == "share captured":
            trials, p = self.spheres + 1, np.clip(value, SMALLEST_SHARE, 1.0 - SMALLEST_SHARE)
            log = np.log(-np.expm1(trials * np.log1p(-p)) / (trials * p))
        else:
            tail, beyond = self.tail * tails, np.stack([interval[0] - value, value - interval[1]])
            spread = np.maximum(error, NO_ERROR * tail)
            both = np.hypot(tail, spread)
            with np.errstate(divide="ignore", invalid="ignore"):
                outside = scipy.special.log_ndtr(beyond / both * tail / spread)
                sides = outside - 0.5 * np.square(beyond / both)
                beyond_ends = np.sum(scipy.special.ndtr(beyond / spread), axis=0)
                inside = np.log(np.maximum(1.0 - beyond_ends, 0.0))
                log = np.logaddexp(inside, np.logaddexp(*sides) + np.log(tail / both))
        return np.where(np.isfinite(log), np.maximum(log, IMPOSSIBLE), IMPOSSIBLE)

    def misses(
        self,
        value: FloatArray,
        interval: tuple[float, float],
        tails: float = 1.0,
        error: Real = 0.0,
    ) -> BoolArray:
        """Whether values lie beyond the interval by more than `CONSISTENT` standard deviations.

        Parameters
        ----------
        value, interval, tails, error
            As in `log_likelihood`; the standard deviation is that of the tails and of the error.
        """
        low, high = interval[0] - value, value - interval[1]
        # Without a value it is missed.
        return ~(np.maximum(low, high) <= CONSISTENT * np.hypot(self.tail * tails, error))


def log_mean(logs: FloatArray) -> FloatArray:
    """Logarithm of the mean of exp(logs) over the second axis, if there is one."""
    if logs.ndim == 1:
        return logs
    return np.asarray(scipy.special.logsumexp(logs, axis=1) - np.log(logs.shape[1]))


# Contacts (n, k) at diameters in um (k,), of all draws or of those with these numbers.
AtDiameters = Callable[[FloatArray, IntArray | slice], Contact]


def values_of(
    statements: Mapping[str, Statement],
    contacts: AtDiameters,
    bases: tuple[str, ...],
    classes_um: FloatArray,
    error: float,
) -> Values:
    """Return the values of statements for contacts, and how fast they change as normals turn.

    Parameters
    ----------
    statements
        By name.
    contacts
        The contacts (n, k) at diameters in um (k,), of all draws or some.
    bases
        Of friction, that may be.
    classes_um
        Size classes that may be, ascending.
    error
        Of the normals, rad; contacts that are followed do not depend on it.

    Returns
    -------
    dict
        By statement (n,), or (n, bases) with friction, (n, classes) where the size is open, (n,
        impacts) where the impact is; nan for contacts that the other statements exclude. After
        `TURNING` and its name, the change per radian. ``capture`` (n, classes): capture velocities,
        m/s.
    """
    rest = {k: s for k, s in statements.items() if s.quantity not in OF_CAPTURE}
    frictional = {k: s for k, s in rest.items() if s.quantity in FRICTIONAL}
    values = _normal({k: s for k, s in rest.items() if k not in frictional}, contacts)
    plain = {k: s for k, s in rest.items() if k in values}
    logs = [
        log_mean(s.log_likelihood(values[k], s.interval, error=error * values[TURNING + k]))
        for k, s in plain.items()
    ]
    score = np.sum(logs, axis=0) - np.min(logs, axis=0)
    likely = np.flatnonzero(score > score.max() - UNLIKELY)

    parts = _frictional(frictional, contacts, bases, likely) if frictional else {}
    limits = np.asarray(capture_velocity(contacts(classes_um, likely)))
    for name, statement in statements.items():
        if statement.quantity == "share captured":
            parts[name] = statement.captured(limits, classes_um)
        elif statement.quantity in OF_CAPTURE:
            parts[name] = limits
            if statement.median_diameter_um is not None:
                apart = np.abs(classes_um - statement.median_diameter_um)
                parts[name] = limits[:, int(np.argmin(apart))]
    for name, part in {**parts, "capture": limits}.items():
        values[name] = np.full((len(score), *part.shape[1:]), np.nan)
        values[name][likely] = part
    return values


def _shared(statements: Iterable[Statement]) -> tuple[FloatArray, FloatArray, list[IntArray]]:
    """Impacts of statements (k, 3), the normal ones among them once (m, 2), and which is whose."""
    impacts = [s.impacts() for s in statements]
    rows = np.concatenate([each.reshape(-1, 3) for each in impacts])
    normal, index = np.unique(rows[:, :2], axis=0, return_inverse=True)
    ends = np.cumsum([each.shape[0] * each.shape[1] for each in impacts])[:-1]
    shapes = [each.shape[:2] for each in impacts]
    split = np.split(index.ravel(), ends)
    return rows, normal, [part.reshape(shape) for part, shape in zip(split, shapes, strict=True)]


def _normal(statements: Mapping[str, Statement], contacts: AtDiameters) -> Values:
    _, normal, columns = _shared(statements.values())
    contact = contacts(normal[:, 0], slice(None))
    outcome = normal_impact(contact, normal[:, 1])
    restitution = np.where(outcome.captured, np.nan, outcome.coefficient_of_restitution)
    slope = _slope(normal, np.nan_to_num(restitution))
    values = {}
    for (name, statement), part in zip(statements.items(), columns, strict=True):
        rates = np.zeros(1)
        if statement.quantity == "contact time in ns":
            value = np.where(outcome.captured, np.nan, outcome.contact_time)[:, part] * 1e9
        elif statement.quantity == "adhesion over hertz":
            # Both forces peak at the greatest compression, and K r^(1/2) s^(3/2) is Hertz's.
            value = (contact.equilibrium_compression / outcome.maximum_compression)[:, part]
        elif statement.quantity == "dissipation over adhesion":
            value = _dissipation_ratio(contact, normal[:, 1])[:, part]
        else:
            value, v_t = restitution[:, part], statement.impacts()[..., 2]
            cot = v_t / statement.impacts()[..., 1]
            # What friction takes is that of a rigid sphere, sliding throughout or rolling.
            friction = np.asarray(contact.friction)[..., None]
            lost = np.minimum(friction * (1.0 + value), ROLLING_SHARE * cot)
            rates = (1.0 + value) * cot - lost + v_t * slope[:, part]
        values[name] = statement.value(value)
        values[TURNING + name] = statement.turning(value, rates)
        values[SHARED + name], values[OWN + name] = statement.turning_together(value, rates)
    return values


def _slope(impacts: FloatArray, e: FloatArray) -> FloatArray:
    """Slope of e (n, m) over the normal speed, by neighbours among sorted impacts (m, 2)."""
    size, speed = np.diff(impacts, axis=0).T
    secant = np.divide(np.diff(e), speed, out=np.zeros_like(e[:, 1:]), where=size == 0.0)
    sides = np.pad((size == 0.0).astype(float), 1)
    both = np.pad(secant, ((0, 0), (1, 1)))
    return np.asarray((both[:, :-1] + both[:, 1:]) / np.maximum(sides[:-1] + sides[1:], 1.0))


def _frictional(
    statements: Mapping[str, Statement],
    contacts: AtDiameters,
    bases: tuple[str, ...],
    likely: IntArray,
) -> Values:
    impacts, normal, columns = _shared(statements.values())
    ledger = "hertz" in bases
    outcome = normal_impact(contacts(normal[:, 0], likely), normal[:, 1], ledger=ledger)
    each = part_of(outcome, np.concatenate([part.ravel() for part in columns]))
    diameter, v_n, v_t = impacts.T
    contact = contacts(diameter, likely)
    ratios = []
    for basis in bases:
        impact = planar(contact, -v_n, v_t, 0.0, basis, law=lambda *_: each)
        ratios.append(np.where(impact.captured, np.nan, impact.impulse_ratio))
    ends = np.cumsum([part.size for part in columns])[:-1]
    parts = np.split(np.stack(ratios, axis=1), ends, axis=2)
    values = {}
    for (name, statement), part, shape in zip(statements.items(), parts, columns, strict=True):
        value = part.reshape(*part.shape[:2], *shape.shape)
        values[name] = statement.value(value)
        rates = 1.0 + np.square(value)
        values[TURNING + name] = statement.turning(value, rates)
        values[SHARED + name], values[OWN + name] = statement.turning_together(value, rates)
    return values


def _dissipation_ratio(contact: Contact, speeds: FloatArray) -> FloatArray:
    """Ratio of the peaks of dissipation and adhesion, interpolated over c_H and ln c_A (s/m)."""
    hertz = np.broadcast_to(contact.hertz_damping, contact.shape)
    adhesion = np.asarray(contact.adhesion_damping_at(speeds))
    c_h = np.linspace(hertz.min(), hertz.max(), RATIO_NODES)
    c_a = np.geomspace(adhesion.min(), adhesion.max(), RATIO_NODES)
    # One impact is behind the two ratios of the article.
    bare = contact.at((0, 0)).replace(adhesion_rate_exponent=0.0)
    ratios = [
        [
            peak_ratios(
                bare.replace(hertz_damping=float(h), adhesion_damping=float(a)),
                float(speeds[0]),
                points=RATIO_POINTS,
            )[1]
            for a in c_a
        ]
        for h in c_h
    ]
    spline = scipy.interpolate.RectBivariateSpline(c_h, np.log(c_a), np.array(ratios))
    return np.asarray(spline.ev(hertz, np.log(adhesion)))
