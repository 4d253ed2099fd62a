"""Inputs shared by the functions of the claims: settings, contacts, samples and tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.lab.dispenser import NO_SPIN
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import Impact, simulate
from study.studies.claims.claim_numbers.params import Common
from study.studies.contacts import all_printed, calibrated_contact
from study.studies.samples import Dropped, Sample, Sampling, Seen, contact_of, half_width
from study.tables import NotComputedError

# Values, or `Estimate`, by quantity; by alternative and quantity, where the claim has alternatives
# of its own.
Numbers = Mapping[str, Any]
Number = float | np.floating[Any]


class Estimate(NamedTuple):
    """A number with its standard error, of sampling or of the computation."""

    value: Number
    error: Number

    def __abs__(self) -> Estimate:
        """Return the size of the number."""
        return Estimate(abs(float(self.value)), self.error)

    def __sub__(self, subtrahend: Estimate) -> Estimate:
        """Return the difference of two independent numbers."""
        return Estimate(self.value - subtrahend.value, np.hypot(self.error, subtrahend.error))

    def __truediv__(self, width: Number) -> Estimate:
        """Return the number over one that is known."""
        return Estimate(self.value / width, self.error / width)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Context:
    """One case of steel on silicon, or none (""), with all settings and tables."""

    params: Common  # Parameters of the study
    inputs: Mapping[str, pd.DataFrame]  # Declared rows and tables of earlier studies by name
    # Name of the calibrated case; the first of those declared is meant where there is none.
    case: str = ""
    # Contacts of steel on silicon (n,) in place of that of the case.
    contacts: Contact | None = None
    # Made once, here for all cases: a table of the impact law serves one and the same contact.
    _seen: dict[tuple[Dropped, float, Sampling], Seen] = field(default_factory=dict)
    _contacts: dict[Dropped, Contact] = field(default_factory=dict)
    _steel: dict[str, Contact] = field(default_factory=dict)
    _sweeps: dict[tuple[str, bool], Impact] = field(default_factory=dict)

    def cases(self) -> Iterator[Self]:
        """Yield the context of every case."""
        return (replace(self, case=case) for case in self.params.steel.cases)

    def stacked(self) -> Self:
        """Return the context with the contact of its case as a contact of arrays (1,)."""
        return replace(self, contacts=resized(self.steel, np.atleast_1d(self.steel.diameter)))

    # Contacts and impacts

    @property
    def steel(self) -> Contact:
        """Contact of the case, or contacts (n,), as large and with such friction as is meant."""
        _ = self.inputs["calibration"], self.inputs["materials"]
        steel = self.params.steel
        if self.contacts is not None:
            return resized(self.contacts, steel.diameter_um * 1e-6)
        if self.case not in self._steel:
            contact = calibrated_contact(self.inputs, self.case or steel.cases[0])
            sized = resized(contact, steel.diameter_um * 1e-6)
            self._steel[self.case] = sized.replace(friction=steel.friction)
        return self._steel[self.case]

    def impacts(
        self, speed: Real, angle: Real = 90.0, spin_ratio: Real | None = None, basis: str = ""
    ) -> Impact:
        """Return impacts of steel at speeds and angles, the contacts along one more axis, the last.

        `spin_ratio`: r omega/v, and `basis`: that of friction; those meant, if not given.
        """
        meant = self.params.steel
        ratio = meant.spin_ratio if spin_ratio is None else spin_ratio
        speed, angle, ratio = (np.asarray(x, float)[..., None] for x in (speed, angle, ratio))
        spin = ratio * speed / self.steel.radius
        return simulate(self.steel, speed, angle, spin, basis or meant.friction_basis)

    def capture_angle(self, above: float = 0.0) -> FloatArray:
        """Return the angle at and below which the impact meant is captured, degrees; at most 90.

        Parameters
        ----------
        above
            How far above the capture velocity the normal speed is, relatively.
        """
        limit = np.asarray(capture_velocity(self.steel))
        angle: FloatArray = np.degrees(
            np.arcsin(np.minimum(limit * (1.0 + above) / self.speed, 1.0))
        )
        return angle

    @property
    def calibrated_capture_velocity(self) -> float:
        """Capture velocity that the calibration met, m/s."""
        return self.number("calibration", "value", role="target", quantity="capture_velocity")

    @property
    def speed(self) -> float:
        """Speed of the impact meant, m/s."""
        return self.params.steel.speed_m_per_s

    def hit(self, contact: Contact, speed: Real, angle: Real = 90.0) -> Impact:
        """Simulate impacts with the initial spin and the friction meant."""
        steel = self.params.steel
        spin = steel.spin_ratio * np.asarray(speed) / contact.radius
        return simulate(contact, speed, angle, spin, steel.friction_basis)

    def all_angles(self, high: float = 90.0, low: float = 0.0) -> FloatArray:
        """Return all steps of the angle from high to low, without 0, in degrees."""
        step = self.params.steel.angle_step_deg
        angles = step * np.arange(1, int(90.0 / step) + 1)
        inside = angles[(angles >= low) & (angles <= high)][::-1]
        return inside.astype(np.float64)

    def rebounds(self, angles: FloatArray | None = None) -> Impact:
        """Return the impacts meant at angles (all steps, if none given), the contacts last.

        Raises ValueError if no contact rebounds at any.
        """
        _ = self.steel
        if angles is not None:
            impact = self.impacts(self.speed, angles)
        elif (key := (self.case, self.contacts is None)) in self._sweeps:
            impact = self._sweeps[key]
        else:
            impact = self._sweeps[key] = self.impacts(self.speed, self.all_angles())
        if np.all(impact.captured):
            raise ValueError(f"steel.speed_m_per_s: at {self.speed:g} it rebounds at no angle")
        return impact

    def shallowest_rebounds(self) -> FloatArray:
        """Return the least angle of all steps at which each contact rebounds, degrees.

        90, if it does at none. Raises ValueError if no contact rebounds at any.
        """
        captured = self.rebounds().captured
        return np.asarray(np.where(captured, 90.0, self.all_angles()[:, None]).min(axis=0))

    # Samples of virtual impacts

    @property
    def series(self) -> Sampling:
        """How samples are drawn at many angles or settings."""
        return replace(self.params.sampling, impacts=self.params.series_impacts)

    def contact(self, dropped: Dropped) -> Contact:
        """Return the contact of the dropped particles, at the mean diameter."""
        # Made once, but read for every sample.
        _ = self.inputs["calibration"], self.inputs["materials"]
        key = replace(dropped, spin=NO_SPIN, surface_slope=0.0)
        if key not in self._contacts:
            self._contacts[key] = contact_of(dropped, self.inputs)
        return self._contacts[key]

    def seen(self, dropped: Dropped, angle: float, sampling: Sampling | None = None) -> Seen:
        """Return the results of a large sample of virtual impacts; of the case, if there is one."""
        case_dropped = replace(dropped, case=self.case or dropped.case)
        key = (case_dropped, angle, sampling or self.params.sampling)
        contact = self.contact(case_dropped)  # whose tables count as read by this claim, too
        if key not in self._seen:
            sample = Sample(dropped=case_dropped, contact=contact, sampling=key[2])
            self._seen[key] = sample.seen(angle)
        return self._seen[key]

    def mean(
        self, quantity: str, dropped: Dropped, angle: float, sampling: Sampling | None = None
    ) -> Estimate:
        """Return the mean over the rebounds of a sample; arguments as in `over_half_width`."""
        sample = self.seen(dropped, angle, sampling)
        mean = sample.means[quantity]
        return Estimate(mean.value, mean.sd / np.sqrt(max(len(sample.measured), 1)))

    def over_half_width(
        self,
        quantity: str,
        first: tuple[Dropped, float],
        second: tuple[Dropped, float],
        sampling: Sampling | None = None,
    ) -> Estimate:
        """Return a difference of means over the half-width of its interval.

        Parameters
        ----------
        quantity
            ``restitution``, ``impulse_ratio`` or ``energy_loss``.
        first, second
            Of the difference first less second: samples, and their angles in degrees.
        sampling
            How the samples are drawn.
        """
        a, b = (self.seen(*end, sampling).means[quantity] for end in (first, second))
        apart = self.mean(quantity, *first, sampling) - self.mean(quantity, *second, sampling)
        return apart / half_width(a, b, sampling or self.params.sampling)

    # Tables

    def printed(self, key: str) -> float:
        """Return a printed value."""
        return float(all_printed(self.inputs)[key])

    def table(self, name: str, **where: object) -> pd.DataFrame:
        """Return the rows of a table with these values, of the case if it has a column of cases.

        Raises ValueError if there is none, or if one of them could not be computed.
        """
        rows = self.inputs[name]
        if self.case and "case" in rows:
            where = {"case": self.case, **where}
        for column, value in where.items():
            rows = rows[rows[column] == value]
        if rows.empty:
            wanted = ", ".join(f"{key} {value}" for key, value in where.items())
            raise ValueError(f"{name}: no row with {wanted}" if wanted else f"{name}: no row")
        if "problem" in rows and not (problems := rows["problem"].dropna()).empty:
            raise NotComputedError(problems.iloc[0])
        return rows

    def number(self, name: str, column: str, **where: object) -> float:
        """Return a number of the first row of a table with these values; errors as in `table`."""
        return float(self.table(name, **where)[column].iloc[0])

    def column(
        self, name: str, column: str, angles: ArrayLike | None = None, **where: object
    ) -> pd.Series:
        """Return a column of a table by angle (degrees), at some angles or at all.

        Raises ValueError if the table has no such row, or not all the angles.
        """
        rows = self.table(name, **where)
        series = pd.Series(rows[column].to_numpy(float), index=rows["angle_deg"].to_numpy(float))
        if angles is None:
            return series
        wanted = np.atleast_1d(np.asarray(angles, dtype=np.float64)).tolist()
        if missing := [f"{angle:g}" for angle in wanted if angle not in series.index]:
            raise ValueError(f"{name}: no row at {', '.join(missing)} deg")
        at: pd.Series = series.loc[wanted]
        return at


def of_share(share: Number, drawn: int) -> Estimate:
    """Return a share of so many independent draws with its standard error."""
    return Estimate(share, np.sqrt(share * (1.0 - share) / drawn))


def over_draws(values: Sequence[float]) -> Estimate:
    """Return the mean of independent draws with its standard error."""
    return Estimate(np.mean(values), np.std(values, ddof=1) / np.sqrt(len(values)))


def greatest(values: FloatArray, where: BoolArray) -> FloatArray:
    """Return the greatest of the values (m, n) over the first axis where they count, else nan."""
    largest = np.max(values, axis=0, where=where, initial=-np.inf)
    return np.asarray(np.where(np.any(where, axis=0), largest, np.nan))


def without_adhesion(contact: Contact) -> Contact:
    """Return the contact with the same damping and no ring force."""
    return contact.replace(work_of_adhesion=0.0)


def between(ends: tuple[float, float], points: int) -> FloatArray:
    """Return speeds or sizes between two ends, in equal ratios."""
    return np.geomspace(*ends, points)
