"""Settings of the numbers behind the claims; intervals of angles run from steep to shallow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from microimpact.declared.parameters import (
    AngleDegrees,
    CaseName,
    Count,
    Finite,
    Fraction,
    Name,
    NonNegative,
    Positive,
    PrintedName,
)
from microimpact.lab.experiment import SpeedClass
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.pdpa.pairing import Form
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.lab.samples import Dropped, Sampling
from microimpact.model.choices import FrictionBasis
from microimpact.statistics.distributions import Distribution

FacingDegrees = Annotated[float, Field(gt=-90, lt=90)]
Angles = Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
AngleRange = tuple[AngleDegrees, AngleDegrees]
Ascending = tuple[Positive, Positive]
Points = Annotated[int, Field(ge=5)]
AboveOne = Annotated[float, Field(gt=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Steel on silicon, and the impact that a claim means unless it says otherwise.

    Attributes
    ----------
    cases
        Calibrated cases of the pair, between which the published facts leave the choice open.
    diameter_um, speed_m_per_s, restitution, friction, spin_ratio
        Spin as r omega over v; restitution as printed.
    friction_basis
        Force that supports friction.
    angles_deg
        Declared angles of incidence.
    angle_step_deg
        Of sweeps over all angles.
    """

    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    diameter_um: Positive
    speed_m_per_s: Positive
    restitution: Fraction
    friction: Fraction
    spin_ratio: Finite
    friction_basis: FrictionBasis
    angles_deg: Angles
    angle_step_deg: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Fall:
    """Section 2.1: free fall to the surface, and between probe and surface.

    Attributes
    ----------
    heights_m, exit_speed_m_per_s
        Shortest and longest fall, and the speed at their start.
    probe_height_mm
        Of the probe above the surface.
    pile_up_speed_m_per_s
        Of the impacts whose height of fall, and whose rebounds, are looked at.
    correction
        How speeds are carried from the probe to the surface.
    speeds_m_per_s, restitutions, points
        Impacts over which the correction is tried: ends, and points between.
    """

    heights_m: Ascending
    exit_speed_m_per_s: NonNegative
    probe_height_mm: Positive
    pile_up_speed_m_per_s: Positive
    correction: Form
    speeds_m_per_s: Ascending
    restitutions: tuple[Fraction, Fraction]
    points: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruments:
    """Section 2.1: what is read from the tables on imaging, pairs and piles."""

    most_pulses_per_s: Positive
    pair_speeds_m_per_s: tuple[Positive, ...]
    pile_radius_mm: Positive
    pile_slope_deg: NonNegative
    pile_shares: tuple[Fraction, Fraction]
    strong_capture_m_per_s: Positive
    weak_capture_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Sieves:
    """Section 2.3: two sieve classes at normal incidence.

    Attributes
    ----------
    smaller_um, larger_um
        Their diameters.
    sizes, plateau_sizes
        Spheres of each, at equal steps of the distribution: of curves, and of the plateau.
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
    plateau_sizes: Annotated[int, Field(ge=10)]
    named_diameter_um: Positive
    captured_shares: tuple[Fraction, Fraction]
    speeds_m_per_s: Ascending
    points: Points
    plateau_share: Fraction
    experiments: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Sections 2.3 and 3.2: speeds and diameters of single normal impacts; ends of intervals.

    Attributes
    ----------
    work_size_exponent
        Of the diameter in the work of adhesion, which is a constant of the materials: 0.
    exponent_step
        Relative step of logarithmic derivatives of the capture velocity.
    above_capture
        How far above the capture velocity impacts begin, relatively.
    """

    flat_from_m_per_s: Positive
    slow_speed_m_per_s: Positive
    rest_speed_m_per_s: Positive
    above_capture: Positive
    capture_velocities: tuple[Positive, Positive, Positive]
    compared_diameters_um: tuple[Positive, Positive]
    work_size_exponent: Finite
    exponent_step: Annotated[float, Field(gt=0, lt=0.5)]
    plateau_share: Annotated[Fraction, Field(gt=0)]
    lasting_diameters_um: dict[Name, Positive]
    lasting_speeds_m_per_s: tuple[Positive, Positive]
    points: Points


@dataclass(frozen=True, slots=True, kw_only=True)
class Oblique:
    """Sections 2.4 and 3.1.4: angles and speeds of single oblique impacts.

    Attributes
    ----------
    loss_speed_m_per_s, level_loss_deg, falling_loss_deg
        Where the translational loss is level, and where it falls.
    plateau_deg, spin_angle_deg, normal_spin_ratio
        End of the plateau of the impulse ratio; where final spin is looked at; spin at 90 deg.
    captured_at_deg, facet_slope_deg
        Angles at which capture is sought, on a facet that faces the sphere.
    rough_angles_deg, points
        Over which measured restitution is sought on facets up to the angle.
    plateau_angles_deg, grazing_angle_deg
        Between which restitution is to be level, and where it has fallen.
    level_angles_deg, rise_angles_deg
        At which impulse ratios are compared, the first over the second.
    share_without_adhesion, limit_angle_deg
        Of the work of adhesion that is left in impacts without adhesion, and where they go.
    slow_angles_deg, friction_speed_exponent
        Of the slow class, the first angle less the second; exponent of the normal speed, over the
        speed, in the coefficient of friction, which is constant: 0.
    rise_share, from_angle_deg
        By how much the impulse ratio rises over that at an angle.
    """

    loss_speed_m_per_s: Positive
    level_loss_deg: AngleRange
    falling_loss_deg: AngleRange
    plateau_deg: AngleDegrees
    spin_angle_deg: AngleDegrees
    normal_spin_ratio: Finite
    captured_at_deg: AngleRange
    facet_slope_deg: Finite
    rough_angles_deg: AngleRange
    points: Points
    plateau_angles_deg: AngleRange
    grazing_angle_deg: AngleDegrees
    level_angles_deg: AngleRange
    rise_angles_deg: AngleRange
    share_without_adhesion: Fraction
    limit_angle_deg: AngleDegrees
    slow_angles_deg: AngleRange
    friction_speed_exponent: NonNegative
    rise_share: Positive
    from_angle_deg: AngleDegrees


@dataclass(frozen=True, slots=True, kw_only=True)
class Slow:
    """Section 2.4.2: slower oblique impacts, of the mean sphere and of samples.

    Attributes
    ----------
    speeds_m_per_s
        Fastest, middle and slowest.
    trend_deg
        Steep and shallow angle between which restitution falls.
    spin_deg, spin_ratio
        Angle, and spin r omega/v, of a sphere that has rolled on the wall of the dispenser.
    limit_spin_ratio
        Spin against rolling at the slower speeds, with which the limit of rolling may shift.
    seen_shift_deg, tried_spins
        Least shift of that limit that is seen, and how many spins are tried for it.
    dropped, classes
        Sample, and its speed classes from the fastest.
    mean_spin, spin_spreads
        Of samples with initial spin, r omega/v: mean, if they have a sense, and spreads.
    normal_speed_below_m_per_s
        Below which captured impacts are looked for.
    """

    speeds_m_per_s: tuple[Positive, Positive, Positive]
    trend_deg: AngleRange
    spin_deg: AngleDegrees
    spin_ratio: Finite
    limit_spin_ratio: Finite
    seen_shift_deg: Positive
    tried_spins: Points
    dropped: Dropped
    classes: dict[Name, SpeedClass]
    mean_spin: Finite
    spin_spreads: tuple[Positive, ...]
    normal_speed_below_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Regions:
    """Section 2.4: angles over which regions of the impulse ratio are sought, and spins."""

    angles_deg: Angles
    constant_within: Fraction
    least_transition_deg: Positive
    spin_sd: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Section 2.4: repeated experiments with and without spin before impact."""

    dropped: Dropped
    angle_deg: Annotated[float, Field(gt=0, lt=90)]
    experiments: Count
    most_dropped: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Mechanisms:
    """Section 2.4: rows and angles read from the tables of mechanisms."""

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
class Formica:
    """Sections 2.4.4 and 4.2: steel and spores on Formica.

    Attributes
    ----------
    steel, spore
        Samples.
    trend_deg
        Steep and shallow angle between which the coefficients are followed.
    spore_angles_deg
        Of the two printed normal speeds of the spores (Section 2.4.3).
    least_spore_friction
        In place of the friction of steel.
    seen_events, seen_dropped
        Events and particles of the sample seen by the camera.
    """

    steel: Dropped
    spore: Dropped
    trend_deg: AngleRange
    spore_angles_deg: AngleRange
    least_spore_friction: Fraction
    seen_events: Count
    seen_dropped: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Algebra:
    """Sections 3.1 and 4.1: numbers at which identities are tried."""

    restitutions: tuple[Fraction, ...]
    adhesion_coefficients: tuple[Fraction, ...]
    slopes_deg: tuple[Finite, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Losses:
    """Sections 3.1 and 3.2: losses and damping of normal impacts.

    Attributes
    ----------
    attachment_damped
        Whether adhesion damping acts on approach as well.
    speeds_m_per_s
        At which works and losses are compared.
    held_out_speeds_m_per_s
        Speeds that were not fitted.
    open_speed_m_per_s, flat_within
        Speed at which members of the family are compared, and how flat they must be.
    normalised_speeds_m_per_s, other_speed_m_per_s
        Range over which damping may follow each impact's own speed, and another nominal speed.
    """

    attachment_damped: bool
    speeds_m_per_s: tuple[Positive, ...]
    held_out_speeds_m_per_s: tuple[Positive, ...]
    open_speed_m_per_s: Positive
    flat_within: Positive
    normalised_speeds_m_per_s: Ascending
    other_speed_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Fluorescein:
    """Section 3.2: ammonium fluorescein on molybdenum, and on mica.

    Attributes
    ----------
    case, diameter_um
        On molybdenum: nominal end of the admissible set, and size.
    sizes_um
        Over which the local exponent of the capture velocity is taken.
    on_mica
        Case on mica.
    """

    diameter_um: Positive
    case: CaseName
    sizes_um: Annotated[tuple[Positive, ...], Field(min_length=2)]
    on_mica: CaseName


@dataclass(frozen=True, slots=True, kw_only=True)
class Fits:
    """Section 3.3: rebounds to which Eq. (34) is fitted.

    Attributes
    ----------
    fitted_from, late_from, fitted_to
        Range of their speeds in capture velocities, from close above capture or from later on.
    rebounds, data_sets
        Rebounds in a set, and sets of which the median interval is taken.
    """

    fitted_from: AboveOne
    late_from: AboveOne
    fitted_to: AboveOne
    rebounds: Annotated[int, Field(ge=8)]
    data_sets: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """Section 4.1: impacts of the rigid body model on one slope.

    Attributes
    ----------
    form
        Which form of Eqs. (35) to (41) is held against the exact rotation.
    angle_deg
        Of incidence, where it is shallow.
    steep_slope_deg, facing_slope_deg, small_slope_deg
        As steep as the angle of incidence; of the signs; of expansions at normal incidence.
    restitutions
        At which coefficients of expansions are compared.
    biasing_spin_ratio
        r omega / v of impacts with spin.
    printed_angle_error_deg
        Uncertainty of a printed angle of the target.
    """

    form: Literal["corrected", "printed"]
    angle_deg: AngleDegrees
    steep_slope_deg: FacingDegrees
    facing_slope_deg: FacingDegrees
    small_slope_deg: FacingDegrees
    restitutions: tuple[Fraction, ...]
    biasing_spin_ratio: Finite
    printed_angle_error_deg: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Roughness:
    """Sections 4.2 and 6: samples on smooth and rough surfaces.

    Attributes
    ----------
    silicon_back
        What is dropped on the rough silicon.
    smooth_slope
        Standard deviation of slopes of the smooth surfaces.
    reference_angle_deg, alike_angles_deg, differ_angle_deg
        From which relative restitution counts, where it is alike, and where it differs.
    relative_angles_deg
        Between which two smooth materials are compared.
    explained_angles_deg
        At which the departure from the smooth surface is shared out.
    pair
        Which sources are to suffice.
    spin_sd
        Standard deviation of r omega / v per axis where spin varies.
    """

    silicon_back: Dropped
    smooth_slope: NonNegative
    reference_angle_deg: AngleDegrees
    alike_angles_deg: Angles
    differ_angle_deg: AngleDegrees
    relative_angles_deg: AngleRange
    explained_angles_deg: AngleRange
    pair: tuple[Literal["slope", "diameter", "speed", "spin"], ...]
    spin_sd: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Capture:
    """Section 6: what becomes of captured spheres, and capture on slopes.

    Attributes
    ----------
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
    yield_strengths_MPa
        Of the spheres, by their state.
    """

    shifts_nm: tuple[Positive, Positive]
    kept_share: Fraction
    spot_mm: Positive
    decoupled_angles_deg: Angles
    slope_sd: NonNegative
    oblique_angle_deg: AngleDegrees
    spheres: Count
    yield_strengths_MPa: dict[Name, Positive]  # noqa: N815 (the unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Claims that are computed for admissible contacts as well.

    Attributes
    ----------
    case
        Of the admissible contacts.
    variants
        How many draws are taken of each; the first decides.
    claims
        Those whose numbers follow from the contact alone, by single impacts.
    """

    case: Name
    variants: dict[Name, Count]
    claims: tuple[Name, ...]

    def __post_init__(self) -> None:
        """Refuse a case without variants."""
        if not self.variants:
            raise ValueError("variants: at least one is needed")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """All settings, in the order of the article.

    Attributes
    ----------
    sampling, series_impacts
        How samples are drawn, and how many impacts each has where there are many samples.
    analyser, camera
        Instruments that see events.
    smooth
        What is dropped on the smooth front of silicon.
    anchors
        Printed values that are read.
    """

    steel: Steel
    sampling: Sampling
    series_impacts: Count
    analyser: Analyser
    camera: ImagingSystem
    fall: Fall
    instruments: Instruments
    sieves: Sieves
    normal: Normal
    oblique: Oblique
    smooth: Dropped
    slow: Slow
    regions: Regions
    spread: Spread
    mechanisms: Mechanisms
    formica: Formica
    algebra: Algebra
    losses: Losses
    fluorescein: Fluorescein
    fits: Fits
    slopes: Slopes
    roughness: Roughness
    capture: Capture
    draws: Draws
    anchors: tuple[PrintedName, ...]
