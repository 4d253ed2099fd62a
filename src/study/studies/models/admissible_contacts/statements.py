"""Printed statements as likelihoods: an interval, and normal tails beyond it.

Each is evaluated at its own diameters, speeds and angles. Where the article leaves a diameter open,
a statement has a value per size class; where friction enters, one per basis of friction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Literal

import numpy as np
import scipy
from pydantic import Field

from microimpact.core.arrays import FloatArray, part_of
from microimpact.core.solve import IntArray
from microimpact.model.calibration import peak_ratios
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar, velocity_components
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.distributions import Distribution
from study.declared.parameters import (
    AngleDegrees,
    Ascending,
    Count,
    Finite,
    Positive,
    PositiveRange,
)

# Far enough below all else, where a statement has no value: a captured sphere never leaves.
IMPOSSIBLE = -1e6
# Quantiles of sizes and speeds that stand for the spheres of an experiment.
NODES = 40
# Below this share captured none is, for the formula that divides by it.
SMALLEST_SHARE = 1e-9
# Logarithm of the likelihood below which the rest is not looked at.
UNLIKELY = -50.0
# Per axis, for the ratio of dissipation and adhesion over both coefficients of damping.
RATIO_NODES = 7
RATIO_POINTS = 200

Quantity = Literal[
    "restitution",
    "spread of restitution",
    "impulse ratio",
    "change of impulse ratio",
    "contact time in ns",
    "capture velocity in m/s",
    "adhesion over hertz",
    "dissipation over adhesion",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Within:
    """A quantity that a statement puts into an interval."""

    # The mean over the impacts; of a spread the largest less the smallest, of a change the first
    # over the last.
    quantity: Quantity
    diameter_um: Positive | None = None  # None where the article leaves it open
    # Of the impacts; one of both may stand for all.
    speeds_m_per_s: Annotated[tuple[Positive, ...], Field(min_length=1)] = (1.0,)
    angles_deg: Annotated[tuple[AngleDegrees, ...], Field(min_length=1)] = (90.0,)
    # Where the likelihood is one, in the unit that the quantity names.
    interval: Annotated[tuple[Finite, Finite], Ascending]
    tail: Positive  # Standard deviation of the normal tails beyond

    def __post_init__(self) -> None:
        """Refuse impacts that cannot be paired."""
        if len({len(self.speeds_m_per_s), len(self.angles_deg)} - {1}) > 1:
            raise ValueError("speeds_m_per_s and angles_deg must be as many, or one of them one")

    @property
    def of_capture(self) -> bool:
        """Whether it needs the capture velocity, which costs far more than an impact."""
        return self.quantity == "capture velocity in m/s"

    @property
    def frictional(self) -> bool:
        """Whether it depends on the basis of friction."""
        return self.quantity in ("impulse ratio", "change of impulse ratio")

    def value(self, values: FloatArray, classes: int) -> FloatArray:
        """The quantity from its values at the impacts, the last axis: (n,), or (n, classes)."""
        if self.diameter_um is None:
            values = values.reshape(values.shape[0], classes, -1)
        if self.quantity == "spread of restitution":
            return np.asarray(np.ptp(values, axis=-1))
        if self.quantity == "change of impulse ratio":
            return np.asarray(values[..., 0] / values[..., -1])
        return np.asarray(np.mean(values, axis=-1))

    def log_likelihood(self, value: FloatArray) -> FloatArray:
        """Logarithm of the likelihood, 0 inside the interval."""
        low, high = self.interval
        with np.errstate(invalid="ignore"):
            beyond = np.maximum(np.maximum(low - value, value - high), 0.0) / self.tail
        return np.where(np.isfinite(value), np.maximum(-0.5 * beyond**2, IMPOSSIBLE), IMPOSSIBLE)


@cache
def impacts_of(statement: Within, classes_um: tuple[float, ...]) -> FloatArray:
    """Diameter (um), normal and tangential speed of its impacts (k, 3), size by size."""
    v_n, v_t = velocity_components(
        np.array(statement.speeds_m_per_s), np.array(statement.angles_deg)
    )
    velocities = np.column_stack(np.broadcast_arrays(-v_n, v_t))
    sizes = classes_um if statement.diameter_um is None else (statement.diameter_um,)
    return np.vstack([np.insert(velocities, 0, size, axis=1) for size in sizes])


@cache
def shared_impacts(
    statements: tuple[Within, ...], classes_um: tuple[float, ...]
) -> tuple[FloatArray, FloatArray, list[IntArray]]:
    """Impacts of statements (k, 3), see `impacts_of`, and the normal ones among them, once each.

    The latter as diameter and normal speed (m, 2), and per statement, which of them its own are:
    impacts that differ along the surface alone share one.
    """
    parts = [impacts_of(statement, classes_um) for statement in statements]
    impacts = np.concatenate(parts)
    normal, index = np.unique(impacts[:, :2], axis=0, return_inverse=True)
    ends = np.cumsum([len(part) for part in parts])
    return impacts, normal, np.split(index.ravel(), ends[:-1])


@dataclass(frozen=True, slots=True, kw_only=True)
class NoCapture:
    """No capture was noticed among spheres of a size class at a slow speed.

    A captured sphere may have rolled away or never been looked for: the share of captures that
    would have been noticed is unknown, uniform between none and all.
    """

    diameter_um: Distribution
    speed_range_m_per_s: PositiveRange
    angle_deg: AngleDegrees
    spheres: Count

    @property
    def of_capture(self) -> bool:
        """It needs the capture velocity."""
        return True

    def captured(self, at: Mapping[float, FloatArray]) -> FloatArray:
        """Share of the spheres that are captured, from capture velocities at two diameters (um)."""
        share = (np.arange(NODES) + 0.5) / NODES
        diameter = np.asarray(self.diameter_um.quantile(share))[:, None]
        low, high = self.speed_range_m_per_s
        speed = (low + (high - low) * share) * math.sin(math.radians(self.angle_deg))
        small, large = min(at), max(at)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.log(at[large] / at[small]) / math.log(large / small)
        limit = at[small][:, None, None] * (diameter / small) ** slope[:, None, None]
        return np.asarray(np.mean(limit > speed, axis=(1, 2)))

    def log_likelihood(self, value: FloatArray) -> FloatArray:
        """Logarithm of ``int (1 - q p)^n dq``, p the share captured and q the share noticed."""
        trials, p = self.spheres + 1, np.clip(value, SMALLEST_SHARE, 1.0 - SMALLEST_SHARE)
        return np.asarray(np.log(-np.expm1(trials * np.log1p(-p)) / (trials * p)))


Statement = Within | NoCapture
Statements = Mapping[str, Statement]  # By name


# Contacts at points (n, axes) and diameters in um (k,): fields (n, k).
Contacts = Callable[[FloatArray, FloatArray], Contact]


@dataclass(frozen=True, slots=True, kw_only=True)
class Likelihood:
    """Log likelihoods of contacts (n,)."""

    # Of statements without an open axis (n,), and of the others, summed, per size class (n,
    # classes) and per basis of friction (n, bases).
    plain: FloatArray
    by_class: FloatArray
    by_basis: FloatArray

    @property
    def total(self) -> FloatArray:
        """Log likelihood, classes and bases being alike before the statements (n,)."""
        return self.plain + mean_over(self.by_class) + mean_over(self.by_basis)


def mean_over(logs: FloatArray) -> FloatArray:
    """Logarithm of the mean of exp(logarithms) over the last axis."""
    top = np.max(logs, axis=-1)
    return np.asarray(top + np.log(np.mean(np.exp(logs - top[..., None]), axis=-1)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """How statements are evaluated."""

    contacts: Contacts  # From points to contacts
    # Size classes and bases of friction that the article leaves open.
    classes_um: tuple[float, ...]
    bases: tuple[str, ...]
    # Ratio of the peaks of dissipation and adhesion by c_H and ln c_A; None if none is stated.
    ratio: scipy.interpolate.RectBivariateSpline | None = None

    def quantities(
        self, points: FloatArray, statements: Statements, limits: FloatArray | None = None
    ) -> dict[str, FloatArray]:
        """Quantities by statement: (n,), (n, classes) or (n, bases).

        Those with friction are nan where the others are too unlikely; those of capture are left out
        where no capture velocities (n, classes) are given.
        """
        frictional, normal = dict[str, Within](), dict[str, Within]()
        for name, statement in statements.items():
            if isinstance(statement, Within) and not statement.of_capture:
                (frictional if statement.frictional else normal)[name] = statement
        values = self._normal(points, normal)
        if frictional:
            likely = self.likelihood(normal, values).total > UNLIKELY
            for name, value in self._frictional(points[likely], frictional).items():
                values[name] = np.full((len(points), len(self.bases)), np.nan)
                values[name][likely] = value
        if limits is not None:
            values |= self._captures(limits, statements)
        return values

    def likelihood(
        self, statements: Statements, quantities: Mapping[str, FloatArray]
    ) -> Likelihood:
        """Return the joint log-likelihood of statements, given their quantities."""
        (n,) = {len(value) for value in quantities.values()}
        plain, by_class = np.zeros(n), np.zeros((n, len(self.classes_um)))
        by_basis = np.zeros((n, len(self.bases)))
        for name, statement in statements.items():
            log = statement.log_likelihood(quantities[name])
            if isinstance(statement, Within) and statement.frictional:
                by_basis += log
            elif log.ndim == 1:
                plain += log
            else:
                by_class += log
        return Likelihood(plain=plain, by_class=by_class, by_basis=by_basis)

    def _normal(
        self, points: FloatArray, statements: Mapping[str, Within]
    ) -> dict[str, FloatArray]:
        """Quantities of normal motion."""
        if not statements:
            return {}
        _, events, places = shared_impacts(tuple(statements.values()), self.classes_um)
        contact = self.contacts(points, events[:, 0])
        outcome = normal_impact(contact, events[:, 1])
        values = {}
        for (name, statement), columns in zip(statements.items(), places, strict=True):
            if statement.quantity == "contact time in ns":
                value = outcome.contact_time[:, columns] * 1e9
            elif statement.quantity == "adhesion over hertz":
                # Both forces peak at the greatest compression, and K r^(1/2) s^(3/2) is Hertz's.
                value = (contact.equilibrium_compression / outcome.maximum_compression)[:, columns]
            elif statement.quantity == "dissipation over adhesion":
                assert self.ratio is not None
                damping = np.asarray(contact.adhesion_damping_at(events[:, 1]))
                value = self.ratio.ev(np.asarray(contact.hertz_damping), np.log(damping))[
                    :, columns
                ]
            else:
                value = outcome.coefficient_of_restitution[:, columns]
            values[name] = statement.value(value, len(self.classes_um))
        return values

    def _frictional(
        self, points: FloatArray, statements: Mapping[str, Within]
    ) -> dict[str, FloatArray]:
        """Quantities of oblique impacts (n, bases)."""
        impacts, events, places = shared_impacts(tuple(statements.values()), self.classes_um)
        diameter, v_n, v_t = impacts.T
        contact = self.contacts(points, events[:, 0])
        impact = normal_impact(contact, events[:, 1], ledger="hertz" in self.bases)
        normal = part_of(impact, np.concatenate(places))
        contact = self.contacts(points, diameter)
        ratios = [
            planar(contact, -v_n, v_t, 0.0, basis, law=lambda *_: normal).impulse_ratio
            for basis in self.bases
        ]
        ends = np.cumsum([len(own) for own in places])
        parts = np.split(np.stack(ratios, axis=1), ends[:-1], axis=2)
        return {
            name: statement.value(part, 0)
            for (name, statement), part in zip(statements.items(), parts, strict=True)
        }

    def limits(self, points: FloatArray) -> FloatArray:
        """Capture velocities (n, classes), m/s."""
        return capture_velocity(self.contacts(points, np.array(self.classes_um)))

    def _captures(self, limits: FloatArray, statements: Statements) -> dict[str, FloatArray]:
        """Capture velocities, or shares captured."""
        at = dict(zip(self.classes_um, limits.T, strict=True))
        return {
            name: statement.captured(at)
            if isinstance(statement, NoCapture)
            else limits
            if statement.diameter_um is None
            else at[statement.diameter_um]
            for name, statement in statements.items()
            if statement.of_capture
        }


def dissipation_ratio(
    contact: Contact, speed: float, hertz: tuple[float, float], adhesion: tuple[float, float]
) -> scipy.interpolate.RectBivariateSpline:
    """Ratio of the peaks of dissipation and adhesion over ranges of c_H and c_A (s/m)."""
    c_h, c_a = np.linspace(*hertz, RATIO_NODES), np.geomspace(*adhesion, RATIO_NODES)
    bare = contact.replace(adhesion_rate_exponent=0.0)
    ratios = [
        [
            peak_ratios(
                bare.replace(hertz_damping=h, adhesion_damping=a), speed, points=RATIO_POINTS
            )[1]
            for a in c_a
        ]
        for h in c_h
    ]
    return scipy.interpolate.RectBivariateSpline(c_h, np.log(c_a), np.array(ratios))
