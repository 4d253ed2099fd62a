"""Settings of the numbers behind the claims; intervals of angles run from steep to shallow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from microimpact.lab.experiment import SpeedClass
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.pdpa.pairing import Form
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.model.choices import FrictionBasis
from microimpact.statistics.distributions import Distribution
from study.declared.parameters import (
    AboveOne,
    AngleDegrees,
    CaseName,
    Count,
    Finite,
    Fraction,
    Name,
    NonNegative,
    ObliqueDegrees,
    Positive,
    PositiveRange,
)
from study.studies.samples import Dropped, Sampling

FacingDegrees = Annotated[float, Field(gt=-90, lt=90)]
Angles = Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
AngleRange = tuple[AngleDegrees, AngleDegrees]
Points = Annotated[int, Field(ge=5)]


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
class Fall:
    """Section 2.1: free fall to the surface, and between probe and surface."""

    # Shortest and longest fall, and the speed at their start.
    heights_m: PositiveRange
    exit_speed_m_per_s: NonNegative
    probe_height_mm: Positive  # Of the probe above the surface
    # Of the impacts whose height of fall, and whose rebounds, are looked at.
    pile_up_speed_m_per_s: Positive
    correction: Form  # How speeds are carried from the probe to the surface
    # Impacts over which the correction is tried: ends, and points between.
    speeds_m_per_s: PositiveRange
    restitutions: tuple[Fraction, Fraction]
    points: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruments:
    """Section 2.1: readings from the tables on imaging, pairs and piles."""

    most_pulses_per_s: Positive
    pair_speeds_m_per_s: tuple[Positive, ...]
    pile_radius_mm: Positive
    pile_slope_deg: NonNegative
    pile_shares: tuple[Fraction, Fraction]
    strong_capture_m_per_s: Positive
    weak_capture_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Sieves:
    """Section 2.3: two sieve classes at normal incidence."""

    # Their diameters.
    smaller_um: Distribution
    larger_um: Distribution
    # Spheres of each, at equal steps of the distribution: of curves, and of the plateau.
    sizes: Count
    plateau_sizes: Annotated[int, Field(ge=10)]
    # Sphere whose capture velocity is the measure, and shares between which capture is taken.
    named_diameter_um: Positive
    captured_shares: tuple[Fraction, Fraction]
    # Ends and points of the curve; the plateau is at the upper end.
    speeds_m_per_s: PositiveRange
    points: Points
    plateau_share: Fraction  # Of the plateau, to which restitution has fallen
    experiments: Count  # Repeated for the interval


@dataclass(frozen=True, slots=True, kw_only=True)
class Normal:
    """Sections 2.3 and 3.2: speeds and diameters of single normal impacts; ends of intervals."""

    flat_from_m_per_s: Positive
    slow_speed_m_per_s: Positive
    rest_speed_m_per_s: Positive
    above_capture: Positive  # How far above the capture velocity impacts begin, relatively
    capture_velocities: tuple[Positive, Positive, Positive]
    compared_diameters_um: tuple[Positive, Positive]
    # Of the diameter in the work of adhesion, which is a constant of the materials: 0.
    work_size_exponent: Finite
    # Relative step of logarithmic derivatives of the capture velocity.
    exponent_step: Annotated[float, Field(gt=0, lt=0.5)]
    plateau_share: Annotated[Fraction, Field(gt=0)]
    lasting_diameters_um: dict[Name, Positive]
    lasting_speeds_m_per_s: PositiveRange
    points: Points


@dataclass(frozen=True, slots=True, kw_only=True)
class Oblique:
    """Sections 2.4 and 3.1.4: angles and speeds of single oblique impacts."""

    # Where the translational loss is level, and where it falls.
    loss_speed_m_per_s: Positive
    level_loss_deg: AngleRange
    falling_loss_deg: AngleRange
    # End of the plateau of the impulse ratio; where final spin is looked at; spin at 90 deg.
    plateau_deg: AngleDegrees
    spin_angle_deg: AngleDegrees
    normal_spin_ratio: Finite
    # Angles at which capture is sought, on a facet that faces the sphere.
    captured_at_deg: AngleRange
    facet_slope_deg: Finite
    # Over which measured restitution is sought on facets up to the angle.
    rough_angles_deg: AngleRange
    points: Points
    # Between which restitution is to be level, and where it has fallen.
    plateau_angles_deg: AngleRange
    grazing_angle_deg: AngleDegrees
    # At which impulse ratios are compared, the first over the second.
    level_angles_deg: AngleRange
    rise_angles_deg: AngleRange
    # Of the work of adhesion that is left in impacts without adhesion, and where they go.
    share_without_adhesion: Fraction
    limit_angle_deg: AngleDegrees
    # Of the slow class, the first angle less the second; exponent of the normal speed, over the
    # speed, in the coefficient of friction, which is constant: 0.
    slow_angles_deg: AngleRange
    friction_speed_exponent: NonNegative
    # By how much the impulse ratio rises over that at an angle.
    rise_share: Positive
    from_angle_deg: AngleDegrees

    def __post_init__(self) -> None:
        """Refuse losses that are not followed from a steep angle to a shallow one."""
        for name in ("level_loss_deg", "falling_loss_deg"):
            steep, shallow = getattr(self, name)
            if steep <= shallow:
                raise ValueError(f"{name}: [{steep:g}, {shallow:g}] must descend")


@dataclass(frozen=True, slots=True, kw_only=True)
class Slow:
    """Section 2.4.2: slower oblique impacts, of the mean sphere and of samples."""

    speeds_m_per_s: tuple[Positive, Positive, Positive]  # Fastest, middle and slowest
    trend_deg: AngleRange  # Steep and shallow angle between which restitution falls
    # Angle, and spin r omega/v, of a sphere that has rolled on the wall of the dispenser.
    spin_deg: AngleDegrees
    spin_ratio: Finite
    # Spin against rolling at the slower speeds, with which the limit of rolling may shift.
    limit_spin_ratio: Finite
    # Least shift of that limit that is seen, and how many spins are tried for it.
    seen_shift_deg: Positive
    tried_spins: Points
    # Sample, and its speed classes from the fastest.
    dropped: Dropped
    classes: dict[Name, SpeedClass]
    # Of samples with initial spin, r omega/v: mean, if they have a sense, and spreads.
    mean_spin: Finite
    spin_spreads: tuple[Positive, ...]
    normal_speed_below_m_per_s: Positive  # Below which captured impacts are looked for


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
    angle_deg: ObliqueDegrees
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
    """Sections 2.4.4 and 4.2: steel and spores on Formica."""

    # Samples.
    steel: Dropped
    spore: Dropped
    trend_deg: AngleRange  # Steep and shallow angle between which the coefficients are followed
    spore_angles_deg: AngleRange  # Of the two printed normal speeds of the spores (Section 2.4.3)
    least_spore_friction: Fraction  # In place of the friction of steel
    # Events and particles of the sample seen by the camera.
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
    """Sections 3.1 and 3.2: losses and damping of normal impacts."""

    attachment_damped: bool  # Whether adhesion damping acts on approach as well
    speeds_m_per_s: tuple[Positive, ...]  # At which works and losses are compared
    held_out_speeds_m_per_s: tuple[Positive, ...]  # Speeds that were not fitted
    # Speed at which members of the family are compared, and how flat they must be.
    open_speed_m_per_s: Positive
    flat_within: Positive
    # Range over which damping may follow each impact's own speed, and another nominal speed.
    normalised_speeds_m_per_s: PositiveRange
    other_speed_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Fluorescein:
    """Section 3.2: ammonium fluorescein on molybdenum, and on mica."""

    diameter_um: Positive
    # case, diameter_um: on molybdenum: nominal end of the admissible set, and size.
    case: CaseName
    # Over which the local exponent of the capture velocity is taken.
    sizes_um: Annotated[tuple[Positive, ...], Field(min_length=2)]
    on_mica: CaseName  # Case on mica


@dataclass(frozen=True, slots=True, kw_only=True)
class Fits:
    """Section 3.3: rebounds to which Eq. (34) is fitted."""

    # Range of their speeds in capture velocities, from close above capture or from later on.
    fitted_from: AboveOne
    late_from: AboveOne
    fitted_to: AboveOne
    # Rebounds in a set, and sets of which the median interval is taken.
    rebounds: Annotated[int, Field(ge=8)]
    data_sets: Count


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """Section 4.1: impacts of the rigid body model on one slope."""

    # Which form of Eqs. (35) to (41) is held against the exact rotation.
    form: Literal["corrected", "printed"]
    angle_deg: AngleDegrees  # Of incidence, where it is shallow
    # As steep as the angle of incidence; of the signs; of expansions at normal incidence.
    steep_slope_deg: FacingDegrees
    facing_slope_deg: FacingDegrees
    small_slope_deg: FacingDegrees
    restitutions: tuple[Fraction, ...]  # At which coefficients of expansions are compared
    biasing_spin_ratio: Finite  # r omega / v of impacts with spin
    printed_angle_error_deg: Positive  # Uncertainty of a printed angle of the target


@dataclass(frozen=True, slots=True, kw_only=True)
class Roughness:
    """Sections 4.2 and 6: samples on smooth and rough surfaces."""

    silicon_back: Dropped  # What is dropped on the rough silicon
    smooth_slope: NonNegative  # Standard deviation of slopes of the smooth surfaces
    # From which relative restitution counts, where it is alike, and where it differs.
    reference_angle_deg: AngleDegrees
    alike_angles_deg: Angles
    differ_angle_deg: AngleDegrees
    relative_angles_deg: AngleRange  # Between which two smooth materials are compared
    explained_angles_deg: AngleRange  # At which the departure from the smooth surface is shared out
    pair: tuple[Literal["slope", "diameter", "speed", "spin"], ...]  # Which sources are to suffice
    spin_sd: NonNegative  # Standard deviation of r omega / v per axis where spin varies


@dataclass(frozen=True, slots=True, kw_only=True)
class Capture:
    """Section 6: motion of captured spheres, and capture on slopes."""

    shifts_nm: PositiveRange  # Both ends of how far adhesion lags behind rolling
    kept_share: Fraction  # Tangential velocity after capture over that before
    spot_mm: Positive  # Half-width of the spot that is hit
    decoupled_angles_deg: Angles  # At which the normal speed of capture is sought
    # Slopes, angle and number of the impacts whose apparent capture is sought.
    slope_sd: NonNegative
    oblique_angle_deg: AngleDegrees
    spheres: Count
    # Of the spheres, by their state.
    yield_strengths_MPa: dict[Name, Positive]  # noqa: N815 (the unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Claims that are computed for admissible contacts as well."""

    case: Name  # Of the admissible contacts
    variants: dict[Name, Count]  # How many draws are taken of each; the first decides
    claims: tuple[Name, ...]  # Those whose numbers follow from the contact alone, by single impacts

    def __post_init__(self) -> None:
        """Refuse a case without variants."""
        if not self.variants:
            raise ValueError("variants: at least one is needed")


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """All settings, in the order of the article."""

    steel: Steel
    # How samples are drawn, and how many impacts each has where there are many samples.
    sampling: Sampling
    series_impacts: Count
    # Instruments that see events.
    analyser: Analyser
    camera: ImagingSystem
    fall: Fall
    instruments: Instruments
    sieves: Sieves
    normal: Normal
    oblique: Oblique
    smooth: Dropped  # What is dropped on the smooth front of silicon
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
