"""Settings, contacts, samples and tables that the functions of the claims share."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from pydantic import AfterValidator, Field

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.lab.dispenser import NO_SPIN
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.model.choices import FrictionBasis
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import Impact, simulate
from study.contacts import all_printed, calibrated_contact
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Count,
    Finite,
    Fraction,
    InferredName,
    Positive,
    ScenarioName,
)
from study.samples import Dropped, Sample, Sampling, Seen, contact_of, half_width
from study.tables import NotComputedError

# Values, or `Estimate`, by quantity; by alternative and quantity, where the claim has alternatives
# of its own.
Numbers = Mapping[str, Any]
Number = float | np.floating[Any]


def _descending(angles: tuple[float, float]) -> tuple[float, float]:
    """Refuse angles that do not run from a steep one to a shallow one."""
    steep, shallow = angles
    if steep <= shallow:
        raise ValueError(f"[{steep:g}, {shallow:g}] must descend")
    return angles


Angles = Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
AngleRange = tuple[AngleDegrees, AngleDegrees]
SteepToShallow = Annotated[AngleRange, AfterValidator(_descending)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Steel on silicon, and the impact that a claim means unless it says otherwise."""

    # Calibrated cases of the pair, between which the published facts leave the choice open.
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    # Spin as r omega over v; restitution as printed.
    diameter_um: Positive
    speed_m_per_s: Positive
    restitution: Fraction
    friction: Fraction
    spin_ratio: Finite
    friction_basis: FrictionBasis  # Normal force in Coulomb's law
    angles_deg: Angles  # Declared angles of incidence
    angle_step_deg: Positive  # Of sweeps over all angles


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Contacts for which claims are computed as well: those drawn of a case, in scenarios."""

    case: InferredName
    scenarios: Annotated[tuple[ScenarioName, ...], Field(min_length=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Common:
    """Settings that claims share; those of one are the keyword arguments of its function."""

    steel: Steel
    # How samples are drawn, and how many impacts each has where there are many samples.
    sampling: Sampling
    series_impacts: Count
    # Instruments that see events.
    analyser: Analyser
    camera: ImagingSystem
    draws: Draws


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


class Read(dict[str, Any]):
    """Declared rows and tables, and the names of those, and of shared settings, that were read."""

    def __init__(self, tables: Mapping[str, Any]) -> None:
        super().__init__()
        self.tables, self.names = tables, set[str]()

    def __missing__(self, name: str) -> Any:
        """Return a table and note its name."""
        self.names.add(name)
        return self.tables[name]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Context:
    """One case of steel on silicon, or none (""), with all settings and tables."""

    params: Common  # Parameters of the study
    inputs: Mapping[str, pd.DataFrame]  # Declared rows and tables of earlier studies by name
    # Name of the calibrated case; the first of those declared is meant where there is none.
    case: str = ""
    # Contacts of steel on silicon (n,) in place of that of the case.
    contacts: Contact | None = None
    # Contacts, samples and impacts that several claims take, made once for all.
    made: dict[Hashable, Any] = field(default_factory=dict)

    def cases(self) -> Iterator[Self]:
        """Yield the context of every case."""
        return (replace(self, case=case) for case in self.params.steel.cases)

    def stacked(self) -> Self:
        """Return the context with the contact of its case as a contact of arrays (1,)."""
        return replace(self, contacts=resized(self.steel, np.atleast_1d(self.steel.diameter)))

    def once(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """Return a value that claims share, computed once; each of them reads the calibration."""
        _ = self.inputs["calibration"], self.inputs["materials"]
        if key not in self.made:
            self.made[key] = make()
        return self.made[key]

    def _meant(self, key: str) -> float:
        """Return the diameter or speed of the impact meant, which a claim on it then names."""
        if isinstance(self.inputs, Read):
            self.inputs.names.add(f"steel.{key}")
        return float(getattr(self.params.steel, key))

    # Contacts and impacts

    @property
    def steel(self) -> Contact:
        """Contact of the case, or contacts (n,), as large and with such friction as is meant."""
        steel = self.params.steel
        case, diameter = self.case or steel.cases[0], self._meant("diameter_um") * 1e-6

        def contact() -> Contact:
            sized = resized(calibrated_contact(self.inputs, case), diameter)
            return sized.replace(friction=steel.friction)

        if self.contacts is not None:
            return resized(self.contacts, diameter)
        calibrated: Contact = self.once(case, contact)
        return calibrated

    @property
    def speed(self) -> float:
        """Speed of the impact meant, m/s."""
        return self._meant("speed_m_per_s")

    def hit(self, contact: Contact, speed: Real, angle: Real = 90.0, basis: str = "") -> Impact:
        """Simulate impacts with the initial spin meant.

        Parameters
        ----------
        contact, speed, angle
            Any contact; m/s; degrees.
        basis
            Normal force in Coulomb's law; the one meant if empty.
        """
        meant = self.params.steel
        spin = meant.spin_ratio * np.asarray(speed) / contact.radius
        return simulate(contact, speed, angle, spin, basis or meant.friction_basis)

    def impacts(self, speed: Real, angle: Real = 90.0, basis: str = "") -> Impact:
        """Simulate impacts of steel, the contacts along one more axis, the last; see `hit`."""
        speed, angle = (np.asarray(x, float)[..., None] for x in (speed, angle))
        return self.hit(self.steel, speed, angle, basis)

    def capture_angle(self, above: float = 0.0) -> FloatArray:
        """Return the angle (degrees, at most 90) at and below which the impact meant is captured.

        With `above`, that at which the normal speed is by this share above the capture velocity.
        """
        ratio = np.asarray(capture_velocity(self.steel)) * (1.0 + above) / self.speed
        return np.asarray(np.degrees(np.arcsin(np.minimum(ratio, 1.0))))

    @property
    def calibrated_capture_velocity(self) -> float:
        """Capture velocity that the calibration met, m/s."""
        return self.number("calibration", "value", role="target", quantity="capture_velocity")

    def all_angles(self, high: float = 90.0, low: float = 0.0) -> FloatArray:
        """Return all steps of the angle from high to low, without 0, in degrees."""
        step = self.params.steel.angle_step_deg
        angles = step * np.arange(1, int(90.0 / step) + 1)
        return np.asarray(angles[(angles >= low) & (angles <= high)][::-1], dtype=np.float64)

    def rebounds(self, angles: FloatArray | None = None) -> Impact:
        """Return the impacts meant at angles (all steps, if none given), the contacts last.

        Raises NotComputable if no contact rebounds at any.
        """
        steel, speed = self.steel, self.speed
        if angles is None:
            key, steps = ("rebounds", self.case, self.contacts is None), self.all_angles()[:, None]
            impact: Impact = self.once(key, lambda: self.hit(steel, speed, steps))
        else:
            impact = self.impacts(speed, angles)
        if np.all(impact.captured):
            raise NotComputable(f"steel.speed_m_per_s: at {speed:g} it rebounds at no angle")
        return impact

    def shallowest_rebounds(self) -> FloatArray:
        """Return the least angle of all steps at which each contact rebounds, degrees.

        90, if it does at none. Raises NotComputable if no contact rebounds at any.
        """
        captured = self.rebounds().captured
        return np.asarray(np.where(captured, 90.0, self.all_angles()[:, None]).min(axis=0))

    # Samples of virtual impacts

    def drawing(self, **changes: Any) -> Self:
        """Return the context with samples drawn in another way: fields of `Sampling` changed."""
        sampling = replace(self.params.sampling, **changes)
        return replace(self, params=replace(self.params, sampling=sampling))

    @property
    def series(self) -> Self:
        """The context with the smaller samples that are drawn at many angles or settings."""
        return self.drawing(impacts=self.params.series_impacts)

    def sample(self, dropped: Dropped) -> Sample:
        """Return a large sample of virtual impacts; of the case, if there is one."""
        dropped = replace(dropped, case=self.case or dropped.case)
        # The contact has the mean diameter; spin and slopes are none of it.
        key = replace(dropped, spin=NO_SPIN, surface_slope=0.0)
        contact = self.once(key, lambda: contact_of(dropped, self.inputs))
        return Sample(dropped=dropped, contact=contact, sampling=self.params.sampling)

    def seen(self, dropped: Dropped, angle: float) -> Seen:
        """Return the rebounds of a sample at an angle in degrees."""
        sample = self.sample(dropped)
        seen: Seen = self.once((sample, angle), lambda: sample.seen(angle))
        return seen

    def mean(self, quantity: str, dropped: Dropped, angle: float) -> Estimate:
        """Return the mean over the rebounds of a sample; arguments as in `over_half_width`."""
        seen = self.seen(dropped, angle)
        mean = seen.means[quantity]
        return Estimate(mean.value, mean.sd / np.sqrt(max(len(seen.measured), 1)))

    def over_half_width(
        self, quantity: str, first: tuple[Dropped, float], second: tuple[Dropped, float]
    ) -> Estimate:
        """Return a difference of means over the half-width of its interval.

        Parameters
        ----------
        quantity
            ``restitution``, ``impulse_ratio`` or ``energy_loss``.
        first, second
            Of the difference first less second: samples, and their angles in degrees.
        """
        a, b = (self.seen(*end).means[quantity] for end in (first, second))
        apart = self.mean(quantity, *first) - self.mean(quantity, *second)
        return apart / half_width(a, b, self.params.sampling)

    # Tables

    def printed(self, key: str) -> float:
        """Return a printed value."""
        return float(all_printed(self.inputs)[key])

    def table(self, name: str, **where: object) -> pd.DataFrame:
        """Return the rows of a table with these values, of the case if it has a column of cases.

        Raises NotComputable if there is none, or if one of them could not be computed.
        """
        rows = self.inputs[name]
        if self.case and "case" in rows:
            where = {"case": self.case, **where}
        for column, value in where.items():
            rows = rows[rows[column] == value]
        if rows.empty:
            wanted = ", ".join(f"{key} {value}" for key, value in where.items())
            raise NotComputable(f"{name}: no row with {wanted}" if wanted else f"{name}: no row")
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

        Raises NotComputable if the table has no such row, or not all the angles.
        """
        rows = self.table(name, **where)
        series = pd.Series(rows[column].to_numpy(float), index=rows["angle_deg"].to_numpy(float))
        if angles is None:
            return series
        wanted = np.atleast_1d(np.asarray(angles, dtype=np.float64)).tolist()
        if missing := [f"{angle:g}" for angle in wanted if angle not in series.index]:
            raise NotComputable(f"{name}: no row at {', '.join(missing)} deg")
        at: pd.Series = series.loc[wanted]
        return at


def of_share(share: Number, drawn: int) -> Estimate:
    """Return a share of independent draws with its standard error."""
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
