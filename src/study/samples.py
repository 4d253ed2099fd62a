"""Large samples of virtual impacts and their means, compared as experiments of few events would."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, Any

import numpy as np

from microimpact.core.arrays import BoolArray
from microimpact.core.solve import root
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.events import Impacts, Measured
from microimpact.lab.experiment import Drop, Target, in_range
from microimpact.lab.ptis.experiment import turned
from microimpact.lab.reduction import QUANTITIES, Mean, interval_columns, reduced
from microimpact.lab.surface import LABORATORY, rough
from microimpact.model.contact import Contact, resized
from microimpact.statistics.distributions import Distribution, generator, mean
from microimpact.statistics.intervals import student_half_width
from study.contacts import calibrated_contact
from study.declared.parameters import (
    CaseName,
    Count,
    Fraction,
    Must,
    NonNegative,
    Positive,
    PositiveRange,
)
from study.tables import Tables

# Below this number of rebounds there is no mean.
FEWEST_REBOUNDS = 20
# Samples kept in memory.
KEPT_SAMPLES = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropped:
    """Contact, sizes, slopes, speed class and spin of a drop."""

    case: CaseName
    friction: Fraction
    diameter_um: Distribution
    surface_slope: NonNegative
    particle_slope: NonNegative
    speed_range_m_per_s: PositiveRange
    speed_m_per_s: Annotated[Positive, Must("within", "speed_range_m_per_s")]
    spin: InitialSpin

    @property
    def slope_sd(self) -> float:
        """Slope between surface and particle, each with its own independent slopes."""
        return float(np.hypot(self.surface_slope, self.particle_slope))

    def drop(self, contact: Contact, angle: float, dispenser: Dispenser) -> Drop:
        """Return the drop on a contact at an angle of incidence in degrees."""
        return Drop(
            target=Target(contact=contact, surface=rough(self.slope_sd)),
            diameter_um=self.diameter_um,
            angle=angle,
            speed=self.speed_m_per_s,
            speed_range=self.speed_range_m_per_s,
            dispenser=dispenser,
            spin=self.spin,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """Sizes of the samples, and of the experiments that they stand for."""

    seed: int  # Root of all draws; all samples share them (common random numbers)
    impacts: Count  # Particles dropped per sample
    events: Count  # Events behind a mean of the article's experiments, for the half-widths
    # Standard uncertainty of a target's angle, shared by the events of an experiment.
    angle_error_deg: NonNegative
    dispenser: Dispenser  # Spreads of release
    # Whether normal impacts come from a table per contact, which pays where many samples have the
    # same.
    tabulated: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """Rebounds of one sample in the plane of measurement, within the speed class."""

    measured: Measured  # The rebounds
    # Share of those that arrived that is not among them: captured, or unseen by an instrument.
    captured_share: float
    means: Mapping[str, Mean]  # Of every quantity


def contact_of(dropped: Dropped, inputs: Tables) -> Contact:
    """Return the calibrated contact, at the mean diameter."""
    contact = calibrated_contact(inputs, dropped.case).replace(friction=dropped.friction)
    return resized(contact, mean(dropped.diameter_um) * 1e-6)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """Particles dropped on a contact, at any angle; all settings share the random numbers."""

    dropped: Dropped
    contact: Contact  # At the mean diameter
    sampling: Sampling

    @classmethod
    def of(cls, dropped: Dropped, sampling: Sampling, inputs: Tables) -> Sample:
        """Return a sample on the calibrated contact of its case."""
        return cls(dropped=dropped, contact=contact_of(dropped, inputs), sampling=sampling)

    def with_changes(self, **changes: Any) -> Sample:
        """Return the sample with other fields of its drop; the contact stays."""
        return replace(self, dropped=replace(self.dropped, **changes))

    def with_contact(self, contact: Contact) -> Sample:
        """Return the same on another contact."""
        return replace(self, contact=contact)

    def impacts(self, angle: float) -> Impacts:
        """Return the true impacts at an angle of incidence in degrees.

        Not to be changed: the last ones are kept, for several mechanisms look at the same.
        """
        return _impacts(self, angle)

    def seen(self, angle: float, most_contacts: int = LABORATORY.most_contacts) -> Seen:
        """Average the rebounds; after more contacts than the most a particle is captured."""
        impacts = self.impacts(angle)
        inside = in_class(self.dropped, impacts)
        free = ~impacts.captured & (impacts.contacts <= most_contacts)
        measured = impacts.in_plane.select(np.flatnonzero(inside & free))
        return reduce_to(measured, int(np.sum(inside)), self.sampling)

    def mean(self, quantity: str, angle: float) -> float:
        """Return the mean of a quantity over the rebounds; nan with too few."""
        return self.seen(angle).means[quantity].value


def setting_for(
    sample: Callable[[float], Sample], quantity: str, angle: float, aim: float, *ends: float
) -> float:
    """Return the setting, between two ends, of the sample whose mean at an angle is as sought."""
    return root(lambda setting: sample(setting).mean(quantity, angle) - aim, *ends, absolute=1e-4)


@lru_cache(maxsize=KEPT_SAMPLES)
def _impacts(sample: Sample, angle: float) -> Impacts:
    sampling = sample.sampling
    drop = sample.dropped.drop(sample.contact, angle, sampling.dispenser)
    drop = drop.tabulated() if sampling.tabulated else drop
    return drop.impacts(sampling.impacts, generator(sampling.seed, 0))


def in_class(dropped: Dropped, impacts: Impacts) -> BoolArray:
    """Tell which particles arrive with a speed of the class."""
    return in_range(impacts.in_plane.speed, dropped.speed_range_m_per_s)


def reduce_to(measured: Measured, arrived: int, sampling: Sampling) -> Seen:
    """Return the statistics of the rebounds, of the particles that arrived."""
    return Seen(
        measured=measured,
        captured_share=1.0 - len(measured) / max(1, arrived),
        means=reduced(measured, turned, sampling.angle_error_deg, FEWEST_REBOUNDS),
    )


def mean_columns(seen: Seen) -> dict[str, Any]:
    """Return the means of a sample as columns of a table."""
    means = interval_columns(seen.means, *QUANTITIES, ends=("sd",))
    return {"rebounds": len(seen.measured), "captured_share": seen.captured_share, **means}


def half_width(first: Mean, second: Mean, sampling: Sampling) -> float:
    """Return the half-width of the 95 % interval of a difference of means.

    Of two experiments of ``sampling.events`` events each, either with its own setting of the
    target.
    """
    sd, systematic = np.hypot(first.sd, second.sd), np.hypot(first.systematic, second.systematic)
    freedom = 2 * (sampling.events - 1)
    return float(student_half_width(sd, sampling.events, systematic, freedom=freedom))


def difference_columns(first: Seen, second: Seen, sampling: Sampling) -> dict[str, float]:
    """Return the differences of means, one less other, alone and over their half-widths."""
    columns = {}
    for name in QUANTITIES:
        a, b = first.means[name], second.means[name]
        columns[f"{name}_difference"] = apart = a.value - b.value
        columns[f"{name}_difference_over_half_width"] = apart / half_width(a, b, sampling)
    return columns
