"""The article's campaign: 187 virtual experiments of about 40 events each (Section 2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import pandas as pd

from microimpact.core.materials import find_material, materials_from_rows
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
    ExperimentSeed,
    Fraction,
    MaterialName,
    Name,
    NonNegative,
)
from study.laboratory import DeclaredSurface
from study.samples import Dropped, contact_of
from study.tables import Tables, series_frame

NEEDS = {"calibration": ("calibration",)}

ALL, FEW = "all", "too few events"
# What became of the particles, in the words of either instrument.
FATES = {
    "missed": (OFF_SHEET, OFF_VIEW, UNREACHED, "incident missed probe", "rebound missed probe"),
    "captured": (CAPTURED,),
    "too_slow": (TOO_SLOW, "incident below probe", "rebound below probe"),
    "not_recorded": (SPLIT, "overlap", "drop-out"),
    "not_measurable": (UNMEASURABLE, "not paired"),
    "measured": (MEASURED, "paired"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """One class of particles on some surfaces, at all combinations of speeds and angles.

    The contact has the work of adhesion and the damping of a calibrated `case`, whatever its
    materials are. Without angles of its own it has those of the campaign.
    """

    particles: Name
    particle: MaterialName
    diameter_um: Distribution
    particle_slope: NonNegative
    spin: InitialSpin
    surfaces: dict[Name, DeclaredSurface]
    case: CaseName
    speeds: tuple[SpeedClass, ...]
    angles_deg: tuple[AngleDegrees, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Particles, targets and instruments of the campaign, in blocks.

    Normal impacts are seen by the analyser, the others by trajectory imaging.
    """

    seed: ExperimentSeed
    angles_deg: tuple[AngleDegrees, ...]
    blocks: dict[Name, Block]
    friction: Fraction
    stop: StopRule
    dispenser: Dispenser
    pdpa: Analyser
    ptis: ImagingSystem


def run(params: Params, inputs: Tables) -> Tables:
    """Run all experiments of the campaign.

    ``campaign``: one row per experiment: what, how many dropped, lost and measured, means with
    intervals, and the ground truth. ``campaign_map``: angle and speed of all experiments, and of
    those with too few events.
    """
    rows = pd.DataFrame(
        row for block in params.blocks.values() for row in experiments(params, block, inputs)
    )
    return {"campaign": rows, "campaign_map": mapped(rows, params.stop.fewest_events)}


def experiments(params: Params, block: Block, inputs: Tables) -> Iterator[dict[str, Any]]:
    """Yield the experiments of a block, each a row that does not depend on the others.

    Of conditions, losses, measured means, and truth.
    """
    for (name, surface), speed in product(block.surfaces.items(), block.speeds):
        dropped = Dropped(
            case=block.case,
            friction=params.friction,
            diameter_um=block.diameter_um,
            surface_slope=surface.surface_slope,
            particle_slope=block.particle_slope,
            speed_m_per_s=speed.speed_m_per_s,
            speed_range_m_per_s=speed.speed_range_m_per_s,
            spin=block.spin,
        )
        pair = block.particle, surface.surface
        contact = of_materials(contact_of(dropped, inputs), *pair, inputs)
        is_calibrated = pair_of(inputs, block.case) == pair
        labels = {
            "particles": block.particles,
            "surface": name,
            "slope_sd": dropped.slope_sd,
            "contact_case": block.case,
            "contact_evidence": "calibrated" if is_calibrated else "assumed",
        }
        for angle in block.angles_deg or params.angles_deg:
            yield labels | conducted(params, dropped, contact, angle)


def of_materials(contact: Contact, particle: str, surface: str, inputs: Tables) -> Contact:
    """Return a contact with its work of adhesion and damping, but of other materials."""
    rows: Any = inputs["materials"].to_dict("records")
    known = materials_from_rows(rows)
    return contact.replace(
        particle=find_material(particle, known),
        surface=find_material(surface, known),
        work_of_adhesion=contact.work_of_adhesion,
    )


def conducted(params: Params, dropped: Dropped, contact: Contact, angle: float) -> dict[str, Any]:
    """Return one experiment: how many were dropped, lost and measured, means, and truth."""
    drop = dropped.drop(contact, angle, params.dispenser).tabulated()
    rng = generator(params.seed, *drop.key)
    outcome: Outcome
    if angle == NORMAL:
        outcome = doppler.collect(drop, params.pdpa, params.stop, rng)
    else:
        outcome = imaging.collect(drop, params.ptis, params.stop, rng)
    row: dict[str, Any] = {
        "angle_deg": angle,
        "nominal_speed_m_per_s": dropped.speed_m_per_s,
        "instrument": "PDPA" if angle == NORMAL else "PTIS",
        "dropped": outcome.dropped,
        **fates_of(outcome.fates),
        "events": len(outcome.measured),
        "captured_share": mean_and_error(outcome.first_impacts.captured)[0],
    }
    for name, truth in quantities(outcome.true).items():
        row |= interval_columns(outcome.means, name)
        row[f"true_{name}"] = mean_and_error(truth)[0]
    return {**row, "evidence": "virtual experiment"}


def fates_of(counted: Mapping[str, int]) -> dict[str, int]:
    """Return the number of particles by `FATES`; they add up to all dropped."""
    return {kind: sum(counted.get(word, 0) for word in words) for kind, words in FATES.items()}


def mapped(rows: pd.DataFrame, fewest: int) -> pd.DataFrame:
    """Return where the experiments lie, by particles and surface: angle and nominal speed."""
    frame = partial(series_frame, evidence="virtual experiment", x_unit="deg", y_unit="m_per_s")
    frames = [
        frame(panel, f"{particles} on {surface}", own["angle_deg"], own["nominal_speed_m_per_s"])
        for panel, shown in ((ALL, rows), (FEW, rows[rows["events"] < fewest]))
        for (particles, surface), own in shown.groupby(["particles", "surface"], sort=False)
    ]
    return pd.concat(frames, ignore_index=True)
