"""What the numbers behind the claims on measurements share: settings, contacts, tables."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import pandas as pd
from pydantic import Field

from microimpact.declared.parameters import (
    AngleDegrees,
    Count,
    Finite,
    Fraction,
    Name,
    NonNegative,
    Positive,
)
from microimpact.lab.pdpa.pairing import Form
from microimpact.lab.ptis.system import Instrument
from microimpact.lab.samples import Dropped, Sampling, Seen, contact_of, half_width, seen
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Distribution
from microimpact.studies import claim_numbers
from microimpact.studies.claim_numbers import CaseContext

Ascending = tuple[Positive, Positive]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Steel on silicon, and the sphere that a claim means unless it says otherwise."""

    particle: Name
    surface: Name
    cases: Annotated[tuple[Name, ...], Field(min_length=1)]
    diameter_um: Positive
    friction: Fraction


@dataclass(frozen=True, slots=True, kw_only=True)
class Fall:
    """Free fall to the surface, and between probe and surface.

    Attributes
    ----------
    heights_m, exit_speed_m_per_s
        Shortest and longest fall, and the speed at their start.
    probe_height_mm
        Of the probe above the surface.
    pile_up_speed_m_per_s, rebound_speed_m_per_s
        Of the impacts whose height of fall, and of those whose rebounds, are looked at.
    correction
        How speeds are carried from the probe to the surface.
    speeds_m_per_s, restitutions, points
        Impacts over which the correction is tried: ends, and points between.
    """

    heights_m: Ascending
    exit_speed_m_per_s: NonNegative
    probe_height_mm: Positive
    pile_up_speed_m_per_s: Positive
    rebound_speed_m_per_s: Positive
    correction: Form
    speeds_m_per_s: Ascending
    restitutions: tuple[Fraction, Fraction]
    points: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Sieves:
    """Two sieve classes at normal incidence.

    Attributes
    ----------
    smaller_um, larger_um
        Their diameters.
    sizes
        Spheres of each, at equal steps of the distribution.
    named_diameter_um, captured_shares
        Sphere whose capture velocity is the measure, and shares between which capture is taken.
    speeds_m_per_s, points
        Ends and points of the curve; the plateau is at the upper end.
    plateau_share
        Of the plateau, to which restitution has fallen.
    experiments
        Repeated for the interval.
    """

    smaller_um: Distribution
    larger_um: Distribution
    sizes: Count
    named_diameter_um: Positive
    captured_shares: tuple[Fraction, Fraction]
    speeds_m_per_s: Ascending
    points: Annotated[int, Field(ge=5)]
    plateau_share: Fraction
    experiments: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruments:
    """What is read from the tables on imaging, pairs and piles."""

    most_pulses_per_s: Positive
    pair_speeds_m_per_s: tuple[Positive, ...]
    pile_radius_mm: Positive
    pile_slope_deg: NonNegative
    pile_share: Fraction
    strong_capture_m_per_s: Positive
    weak_capture_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Slow:
    """Slow oblique impacts, of the mean sphere and of samples.

    Attributes
    ----------
    speeds_m_per_s
        Fastest, middle and slowest.
    trend_deg
        Steep and shallow angle between which restitution falls.
    spin_deg, spin_ratio
        Angle, and spin r omega/v, of a sphere that has rolled on the wall of the dispenser.
    limit_spin_ratio
        Spin at the slowest speed for the limit of rolling.
    dropped
        Sample; its own spin is not used.
    mean_spin, spin_spreads
        Of samples with initial spin, r omega/v.
    """

    speeds_m_per_s: tuple[Positive, Positive, Positive]
    trend_deg: tuple[AngleDegrees, AngleDegrees]
    spin_deg: AngleDegrees
    spin_ratio: Finite
    limit_spin_ratio: Finite
    dropped: Dropped
    mean_spin: Finite
    spin_spreads: tuple[Positive, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Regions:
    """Sample and angles over which regions of the impulse ratio are sought."""

    dropped: Dropped
    angles_deg: tuple[AngleDegrees, ...]
    constant_within: Fraction
    least_transition_deg: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Formica:
    """Steel and spores on Formica, and the imaging system that watches them.

    Attributes
    ----------
    steel, spore
        Samples.
    trend_deg
        Steep and shallow angle between which restitution rises.
    seen_events, seen_dropped
        Events and particles of the sample seen by the camera.
    """

    steel: Dropped
    spore: Dropped
    trend_deg: tuple[AngleDegrees, AngleDegrees]
    instrument: Instrument
    seen_events: Count
    seen_dropped: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Mechanisms:
    """Rows and angles read from the tables of mechanisms."""

    slopes_alone: Name
    half_adhesion: Name
    mirror: Name
    restitution_deg: tuple[AngleDegrees, ...]
    adhesion_deg: tuple[AngleDegrees, ...]
    mirror_deg: tuple[AngleDegrees, ...]
    compared_deg: tuple[AngleDegrees, ...]
    spore_slopes: Name
    spore_second_contacts: Name
    spore_off_centre: Name
    spore_seen: Name
    formica_from_deg: AngleDegrees


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Which claims are computed, and with what."""

    claims: Annotated[tuple[Name, ...], Field(min_length=1)]
    steel: Steel
    fall: Fall
    sieves: Sieves
    instruments: Instruments
    slow: Slow
    regions: Regions
    mechanisms: Mechanisms
    formica: Formica
    sampling: Sampling
    anchors: tuple[Name, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Context(CaseContext):
    """A case with the settings of these claims."""

    params: Params

    def table(self, name: str, **where: object) -> pd.DataFrame:
        """Return the rows of a table with these values, of the case if it tells cases apart.

        Raises
        ------
        ValueError
            If there is none.
        """
        rows = self.inputs[name]
        for column, value in where.items():
            rows = rows[rows[column] == value]
        if self.case and "case" in rows:
            rows = rows[rows["case"] == self.case]
        if rows.empty:
            wanted = ", ".join(f"{key} {value}" for key, value in where.items())
            raise ValueError(f"{name}: no row with {wanted or 'the case'} {self.case}".rstrip())
        return rows

    def column(self, name: str, column: str, **where: object) -> pd.Series:
        """Return a column of a table, by angle (degrees)."""
        rows = self.table(name, **where)
        return pd.Series(rows[column].to_numpy(float), index=rows["angle_deg"].to_numpy(float))

    def seen(self, dropped: Dropped, angle: float) -> Seen:
        """Return a sample; of the case, if there is one."""
        own = replace(dropped, case=self.case or dropped.case)
        return seen(own, self.contact(own), angle, self.params.sampling)

    def contact(self, dropped: Dropped) -> Contact:
        """Return the contact of a sample at its mean diameter."""
        return contact_of(dropped, self.inputs)

    def rise_over_half_width(self, dropped: Dropped, quantity: str) -> float:
        """Return the rise of a mean from the steep to the shallow angle on Formica."""
        steep, shallow = (
            self.seen(dropped, angle).statistics[quantity]
            for angle in self.params.formica.trend_deg
        )
        width = half_width(shallow, steep, self.params.sampling)
        return (shallow.mean - steep.mean) / width


@dataclass(frozen=True, slots=True, kw_only=True)
class Numbers(claim_numbers.Numbers):
    """Numbers that are measured in the virtual laboratory, unless they say otherwise."""

    evidence: str = "virtual experiment"
