"""Declared settings of the numbers behind the claims on the analyses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

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
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.pdpa.analyser import Instrument as Analyser
from microimpact.lab.ptis.system import Instrument as Camera
from microimpact.lab.samples import Dropped, Sampling
from microimpact.statistics.distributions import Distribution

FacingDegrees = Annotated[float, Field(gt=-90, lt=90)]
Angles = Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A calibrated case and its materials."""

    case: Name
    particle: Name
    surface: Name


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """Impacts of the rigid body model on slopes (C45 to C50).

    Attributes
    ----------
    form
        Which form of Eqs. (35) to (41) is held against the exact rotation.
    angle_deg
        Of incidence, where it is shallow.
    steep_slope_deg, facing_slope_deg, small_slope_deg
        As steep as the angle of incidence; of the signs; of expansions at normal incidence.
    restitution, friction
        Of the impacts.
    restitutions
        At which coefficients of expansions are compared.
    spin_ratio
        r omega / v of the impacts that the article takes to come without spin.
    biasing_spin_ratio
        r omega / v of those with spin.
    """

    form: Literal["corrected", "printed"]
    angle_deg: AngleDegrees
    steep_slope_deg: FacingDegrees
    facing_slope_deg: FacingDegrees
    small_slope_deg: FacingDegrees
    restitution: Fraction
    friction: Fraction
    restitutions: tuple[Fraction, ...]
    spin_ratio: Finite
    biasing_spin_ratio: Finite


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Large samples of virtual impacts (C51, C52, C60, C94, C96).

    Attributes
    ----------
    impacts, events, angle_error_deg, dispenser
        As in `_dropped.Sampling`.
    formica, silicon_back
        What is dropped on the rough surfaces.
    smooth_slope
        Standard deviation of slopes of the smooth surfaces.
    fall_angles_deg
        From which to which angle the coefficients are followed.
    reference_angle_deg, alike_angles_deg, differ_angle_deg
        From which relative restitution counts, where it is alike, and where it differs.
    declared_angles_deg
        At which slopes are to disturb the mean restitution.
    explained_angles_deg
        At which the departure from the smooth surface is shared out.
    pair
        Which sources are to suffice.
    spin_sd
        Standard deviation of r omega / v per axis where spin varies.
    """

    impacts: Count
    events: Annotated[int, Field(ge=2)]
    angle_error_deg: NonNegative
    dispenser: Dispenser
    formica: Dropped
    silicon_back: Dropped
    smooth_slope: NonNegative
    fall_angles_deg: tuple[AngleDegrees, AngleDegrees]
    reference_angle_deg: AngleDegrees
    alike_angles_deg: Angles
    differ_angle_deg: AngleDegrees
    declared_angles_deg: Angles
    explained_angles_deg: tuple[AngleDegrees, AngleDegrees]
    pair: tuple[Literal["slope", "diameter", "speed", "spin"], ...]
    spin_sd: NonNegative

    def sampling(self, seed: int) -> Sampling:
        """Return how samples are drawn."""
        return Sampling(
            seed=seed,
            impacts=self.impacts,
            events=self.events,
            angle_error_deg=self.angle_error_deg,
            dispenser=self.dispenser,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Repeated experiments with and without spin before impact (C109)."""

    dropped: Dropped
    instrument: Camera
    angle_deg: Annotated[float, Field(gt=0, lt=90)]
    experiments: Count
    most_dropped: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Sieve:
    """Conditional mean restitution of a sieve class at normal incidence (C105)."""

    diameter_um: Distribution
    sizes: Annotated[int, Field(ge=10)]
    lowest_speed_m_per_s: Positive
    highest_speed_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Capture:
    """Capture, its sizes, and what becomes of captured spheres (C08, C57, C97, C98, C107).

    Attributes
    ----------
    mean_diameter_um
        Of the smaller sieve class.
    sizes_um
        Over which the local exponent of the capture velocity is taken.
    work_size_exponent
        Of the diameter in the work of adhesion, which is a constant of the materials: 0.
    exponent_step
        Relative step of logarithmic derivatives.
    speed_m_per_s
        Of the spheres that are captured on a tilted target.
    shifts_nm
        Both ends of how far adhesion lags behind rolling.
    kept_share
        Tangential velocity after capture over that before.
    spot_mm
        Half-width of the spot that is hit.
    decoupled_angles_deg
        At which the normal speed of capture is sought.
    slope_sd, oblique_angle_deg, spheres
        Slopes, angle and number of the impacts whose apparent capture is sought.
    """

    mean_diameter_um: Positive
    sizes_um: Annotated[tuple[Positive, ...], Field(min_length=2)]
    work_size_exponent: Finite
    exponent_step: Annotated[float, Field(gt=0, lt=0.5)]
    speed_m_per_s: Positive
    shifts_nm: tuple[Positive, Positive]
    kept_share: Fraction
    spot_mm: Positive
    decoupled_angles_deg: Angles
    slope_sd: NonNegative
    oblique_angle_deg: AngleDegrees
    spheres: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Impacts:
    """Simulated oblique impacts (C68, C69, C93, C95, C106, C110).

    Attributes
    ----------
    speed_m_per_s
        Nominal speed.
    friction_basis
        Force that friction follows.
    plateau
        Restitution that is compared with.
    plateau_angles_deg, grazing_angle_deg
        Between which restitution is to be level, and where it has fallen.
    level_angles_deg, rise_angles_deg
        At which impulse ratios are compared, the first over the second.
    share_without_adhesion
        Of the work of adhesion that is left in impacts without adhesion.
    limit_angle_deg
        Towards which these impacts go.
    relative_angles_deg, reference_angle_deg
        Between which two smooth materials are compared, and from which restitution counts.
    slow_speed_m_per_s, slow_angles_deg
        Of the slow class, the first angle less the second.
    friction_speed_exponent
        Of the normal speed, over the speed, in the coefficient of friction: constant, 0.
    rise_share, from_angle_deg
        By how much the impulse ratio rises over that at an angle.
    """

    speed_m_per_s: Positive
    friction_basis: Literal["compressive", "hertz", "net"]
    plateau: Fraction
    plateau_angles_deg: tuple[AngleDegrees, AngleDegrees]
    grazing_angle_deg: AngleDegrees
    level_angles_deg: tuple[AngleDegrees, AngleDegrees]
    rise_angles_deg: tuple[AngleDegrees, AngleDegrees]
    share_without_adhesion: Fraction
    limit_angle_deg: AngleDegrees
    relative_angles_deg: tuple[AngleDegrees, AngleDegrees]
    reference_angle_deg: AngleDegrees
    slow_speed_m_per_s: Positive
    slow_angles_deg: tuple[AngleDegrees, AngleDegrees]
    friction_speed_exponent: NonNegative
    rise_share: Positive
    from_angle_deg: AngleDegrees


@dataclass(frozen=True, slots=True, kw_only=True)
class Losses:
    """Normal impacts: losses and damping (C70, C99 to C104, C108).

    Attributes
    ----------
    speed_m_per_s
        Nominal speed.
    attachment_damped
        Whether adhesive damping acts on approach as well.
    speeds_m_per_s
        At which works and losses are compared.
    held_out_speeds_m_per_s, plateau
        Speeds that were not fitted, and restitution there.
    open_speed_m_per_s, flat_within
        Speed at which members of the family are compared, and how flat they must be.
    normalised_speeds_m_per_s, other_speed_m_per_s
        Range over which damping may follow each impact's own speed, and another nominal speed.
    instrument
        Whose noise the rebounds have that Eq. (34) is fitted to.
    fitted_from, fitted_to
        Range of their speeds in capture velocities.
    rebounds, data_sets
        Rebounds in a set, and sets of which the median interval is taken.
    """

    speed_m_per_s: Positive
    attachment_damped: bool
    speeds_m_per_s: tuple[Positive, ...]
    held_out_speeds_m_per_s: tuple[Positive, ...]
    plateau: Fraction
    open_speed_m_per_s: Positive
    flat_within: Positive
    normalised_speeds_m_per_s: tuple[Positive, Positive]
    other_speed_m_per_s: Positive
    instrument: Analyser
    fitted_from: Annotated[float, Field(gt=1)]
    fitted_to: Annotated[float, Field(gt=1)]
    rebounds: Annotated[int, Field(ge=8)]
    data_sets: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """All settings; ``ridge`` are the cases that the published facts leave open."""

    seed: Annotated[int, Field(ge=0)]
    ridge: Annotated[tuple[Pair, ...], Field(min_length=2)]
    formica: Pair
    molybdenum: Pair
    slopes: Slopes
    samples: Samples
    spread: Spread
    sieve: Sieve
    capture: Capture
    impacts: Impacts
    losses: Losses
