"""The article's campaign: 187 virtual experiments of about 40 events each (Section 2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any

import pandas as pd

from microimpact.core.materials import find_material, materials_from_rows
from microimpact.core.nearest import nearest
from microimpact.lab.dispenser import Dispenser, InitialSpin
from microimpact.lab.experiment import NORMAL, Outcome, SpeedClass, StopRule
from microimpact.lab.pdpa import experiment as doppler
from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.pdpa.experiment import UNREACHED
from microimpact.lab.ptis import experiment as imaging
from microimpact.lab.ptis.exposure import (
    CAPTURED,
    MEASURED,
    OFF_SHEET,
    OFF_VIEW,
    SPLIT,
    TOO_SLOW,
    UNMEASURABLE,
)
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.lab.reduction import interval_columns, quantities
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import Distribution, generator
from microimpact.statistics.intervals import mean_and_error
from study.contacts import pair_of
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Count,
    ExperimentSeed,
    Fraction,
    MaterialName,
    Name,
    NonNegative,
)
from study.laboratory import DeclaredSurface
from study.samples import Dropped, contact_of
from study.tables import Tables, series_frame


@dataclass(frozen=True, slots=True, kw_only=True)
class SizeRange:
    """One range of sizes of one material, and its spin."""

    particle: MaterialName
    diameter_um: Distribution
    particle_slope: NonNegative
    spin_sd: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """All combinations of some particles, surfaces, speeds and angles, with one contact.

    The contact has the work of adhesion and the damping of a calibrated `case`, whatever its
    materials are. Without angles of its own it has those of the campaign.
    """

    particles: tuple[Name, ...]
    surfaces: tuple[Name, ...]
    case: CaseName
    speeds: tuple[Name, ...]
    angles_deg: tuple[AngleDegrees, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Counts:
    """How many experiments and different levels there are, as the article counts them."""

    experiments: Count
    diameter_ranges: Count
    surfaces: Count
    angles: Count
    speed_ranges: Count

    def in_words(self) -> dict[str, int]:
        """Return the counts by their names."""
        return {key.replace("_", " "): number for key, number in asdict(self).items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """One experiment of a campaign."""

    names: tuple[str, str, str]  # Of particles, surface and speed
    particles: SizeRange
    surface: DeclaredSurface
    case: str
    speed_class: SpeedClass
    angle: float

    @property
    def title(self) -> str:
        """Name in words; no two experiments share it."""
        speed = self.speed_class.speed_m_per_s
        return f"{self.names[0]} on {self.names[1]}, {speed:g} m/s, {self.angle:g} deg"

    @property
    def pair(self) -> tuple[str, str, str]:
        """Particles, surface and case, which decide its contact."""
        return *self.names[:2], self.case

    def dropped(self, friction: float) -> Dropped:
        """Return the particles dropped, with a coefficient of friction."""
        return Dropped(
            case=self.case,
            friction=friction,
            diameter_um=self.particles.diameter_um,
            surface_slope=self.surface.surface_slope,
            particle_slope=self.particles.particle_slope,
            speed_m_per_s=self.speed_class.speed_m_per_s,
            speed_range_m_per_s=self.speed_class.speed_range_m_per_s,
            spin=InitialSpin(sd=self.particles.spin_sd, mean=0.0),
        )


def expand(
    blocks: Mapping[str, Block],
    particles: Mapping[str, SizeRange],
    surfaces: Mapping[str, DeclaredSurface],
    speed_classes: Mapping[str, SpeedClass],
    angles_deg: tuple[float, ...],
) -> list[Experiment]:
    """Return the experiments that blocks declare.

    Raises ValueError if a block names what is not declared, or an experiment is declared twice.
    """
    known = {"particles": particles, "surfaces": surfaces, "speeds": speed_classes}
    experiments: dict[str, Experiment] = {}
    for block_name, block in blocks.items():
        for key, declared in known.items():
            for name in (name for name in getattr(block, key) if name not in declared):
                complaint = f"{name!r} must be one of those declared{nearest(name, declared)}"
                raise ValueError(f"blocks.{block_name}.{key}: {complaint}")
        chosen = block.particles, block.surfaces, block.speeds, block.angles_deg or angles_deg
        for *names, angle in product(*chosen):
            experiment = Experiment(
                names=(names[0], names[1], names[2]),
                particles=particles[names[0]],
                surface=surfaces[names[1]],
                speed_class=speed_classes[names[2]],
                case=block.case,
                angle=angle,
            )
            if experiment.title in experiments:
                raise ValueError(f"blocks.{block_name}: {experiment.title}: declared twice")
            experiments[experiment.title] = experiment
    return list(experiments.values())


def counts(experiments: Iterable[Experiment]) -> Counts:
    """Count experiments and different levels."""
    all_of = list(experiments)
    return Counts(
        experiments=len(all_of),
        diameter_ranges=len({one.particles.diameter_um for one in all_of}),
        surfaces=len({one.names[1] for one in all_of}),
        angles=len({one.angle for one in all_of}),
        speed_ranges=len({one.names[2] for one in all_of}),
    )


def check_counts(experiments: Iterable[Experiment], wanted: Counts) -> None:
    """Check experiments against counts; raises ValueError, naming all that do not agree."""
    pairs = zip(counts(experiments).in_words().items(), wanted.in_words().values(), strict=True)
    wrong = [f"{own} {name}, not {other}" for (name, own), other in pairs if own != other]
    if wrong:
        raise ValueError(f"blocks: give {'; '.join(wrong)}, as counted: change counted, too")


# What became of the particles, in the words of either instrument.
FATES = {
    "missed": (OFF_SHEET, OFF_VIEW, UNREACHED, "incident missed probe", "rebound missed probe"),
    "captured": (CAPTURED,),
    "too_slow": (TOO_SLOW, "incident below probe", "rebound below probe"),
    "not_recorded": (SPLIT, "overlap", "drop-out"),
    "not_measurable": (UNMEASURABLE, "not paired"),
    "measured": (MEASURED, "paired"),
}


def fates_of(counted: Mapping[str, int]) -> dict[str, int]:
    """Return the number of particles by `FATES`; they add up to all dropped."""
    return {kind: sum(counted.get(word, 0) for word in words) for kind, words in FATES.items()}


NEEDS = {"calibration": ("calibration",)}

ALL, FEW = "all", "too few events"


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Particles, targets and instruments of the campaign, in blocks.

    Normal impacts are seen by the analyser, the others by trajectory imaging.
    """

    seed: ExperimentSeed
    particles: Mapping[str, SizeRange]
    surfaces: Mapping[str, DeclaredSurface]
    speed_classes: Mapping[str, SpeedClass]
    angles_deg: tuple[AngleDegrees, ...]
    blocks: dict[Name, Block]
    friction: Fraction
    stop: StopRule
    dispenser: Dispenser
    pdpa: Analyser
    ptis: ImagingSystem
    counted: Counts

    def __post_init__(self) -> None:
        """Refuse blocks with undeclared names or other counts."""
        check_counts(self.experiments, self.counted)

    @property
    def experiments(self) -> list[Experiment]:
        """All experiments that the blocks declare."""
        levels = self.particles, self.surfaces, self.speed_classes, self.angles_deg
        return expand(self.blocks, *levels)


def run(params: Params, inputs: Tables) -> Tables:
    """Run all experiments of the campaign.

    ``campaign``: one row per experiment: what, how many dropped, lost and measured, means with
    intervals, and the ground truth. ``campaign_map``: angle and speed of all experiments, and of
    those with too few events.
    """
    experiments = params.experiments
    pairs = {experiment.pair: experiment for experiment in experiments}
    contacts = {pair: contact(params, experiment, inputs) for pair, experiment in pairs.items()}
    rows = pd.DataFrame(
        [conducted(params, experiment, *contacts[experiment.pair]) for experiment in experiments]
    )
    return {
        "campaign": rows,
        "campaign_map": mapped(rows, params.stop.fewest_events),
    }


def conducted(
    params: Params, experiment: Experiment, contact: Contact, evidence: str
) -> dict[str, Any]:
    """Return the row of one experiment: conditions, losses, measured means, and truth.

    It does not depend on the others.

    Parameters
    ----------
    params, experiment
        Settings of the campaign, and the experiment.
    contact, evidence
        Both as from the function `contact`.
    """
    dropped = experiment.dropped(params.friction)
    drop = dropped.drop(contact, experiment.angle, params.dispenser).tabulated()
    rng = generator(params.seed, *drop.key)
    if experiment.angle == NORMAL:
        outcome: Outcome = doppler.collect(drop, params.pdpa, params.stop, rng)
    else:
        outcome = imaging.collect(drop, params.ptis, params.stop, rng)
    row: dict[str, Any] = {
        "particles": experiment.names[0],
        "surface": experiment.names[1],
        "slope_sd": dropped.slope_sd,
        "contact_case": experiment.case,
        "contact_evidence": evidence,
        "angle_deg": experiment.angle,
        "nominal_speed_m_per_s": dropped.speed_m_per_s,
        "instrument": "PDPA" if experiment.angle == NORMAL else "PTIS",
        "dropped": outcome.dropped,
        **fates_of(outcome.fates),
        "events": len(outcome.measured),
        "captured_share": mean_and_error(outcome.first_impacts.captured)[0],
    }
    for name, truth in quantities(outcome.true).items():
        row |= interval_columns(outcome.means, name)
        row[f"true_{name}"] = mean_and_error(truth)[0]
    return {**row, "evidence": "virtual experiment"}


def contact(params: Params, experiment: Experiment, inputs: Tables) -> tuple[Contact, str]:
    """Return the contact of an experiment: adhesion and damping of its case, its own materials.

    And whether it was calibrated for these materials, or is assumed to be as for others.
    """
    rows: Any = inputs["materials"].to_dict("records")
    particle, surface = names = experiment.particles.particle, experiment.surface.surface
    case = contact_of(experiment.dropped(params.friction), inputs)
    adapted = case.replace(
        particle=find_material(particle, materials_from_rows(rows)),
        surface=find_material(surface, materials_from_rows(rows)),
        work_of_adhesion=case.work_of_adhesion,
    )
    return adapted, "calibrated" if pair_of(inputs, experiment.case) == names else "assumed"


def mapped(rows: pd.DataFrame, fewest: int) -> pd.DataFrame:
    """Return where the experiments lie, by particles and surface: angle and nominal speed."""
    frame = partial(series_frame, evidence="virtual experiment", x_unit="deg", y_unit="m_per_s")
    frames = [
        frame(panel, f"{particles} on {surface}", own["angle_deg"], own["nominal_speed_m_per_s"])
        for panel, shown in ((ALL, rows), (FEW, rows[rows["events"] < fewest]))
        for (particles, surface), own in shown.groupby(["particles", "surface"], sort=False)
    ]
    return pd.concat(frames, ignore_index=True)
