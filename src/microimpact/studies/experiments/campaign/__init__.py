"""The article's campaign: 187 virtual experiments of about 40 events each (Section 2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.materials import find_material, materials_from_rows
from microimpact.core.tables import series_frame
from microimpact.declared.parameters import ExperimentSeed, Fraction, Keyed, PrintedName
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.experiment import Outcome, SpeedClass, StopRule
from microimpact.lab.pdpa import experiment as doppler
from microimpact.lab.pdpa.analyser import Instrument as Analyser
from microimpact.lab.ptis import experiment as imaging
from microimpact.lab.ptis.system import Instrument as Camera
from microimpact.model.contact import Contact, resized
from microimpact.statistics.distributions import generator, mean
from microimpact.studies.experiments.campaign.plan import (
    COUNTED,
    Block,
    Experiment,
    Particles,
    Surface,
    check_counts,
    counts,
    expand,
)
from microimpact.studies.experiments.campaign.rows import NORMAL, experiment_row

NEEDS = {"calibration": ("calibration",)}

ALL, FEW = "all", "too few events"


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """What is dropped on what, in blocks, and how it is observed.

    Normal impacts are seen by the analyser, the others by trajectory imaging.
    """

    seed: ExperimentSeed
    particles: Annotated[tuple[Particles, ...], Keyed("name")]
    surfaces: Annotated[tuple[Surface, ...], Keyed("name")]
    speed_classes: Annotated[tuple[SpeedClass, ...], Keyed()]
    blocks: Annotated[tuple[Block, ...], Keyed()]
    speed_ranges_within: Annotated[int, Field(ge=0)]
    friction: Fraction
    stop: StopRule
    dispenser: Dispenser
    pdpa: Analyser
    ptis: Camera
    anchors: tuple[PrintedName, ...]

    @property
    def experiments(self) -> list[Experiment]:
        """All experiments that the blocks declare."""
        return expand(self.blocks, self.particles, self.surfaces, self.speed_classes)


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Run all experiments of the campaign.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``calibration``: calibrated contacts; ``materials``: declared rows; ``anchors``: printed
        values.

    Returns
    -------
    mapping
        ``campaign``: one row per experiment: what, how many dropped, lost and measured, means with
        intervals, and the ground truth. ``campaign_summary``: counts against the printed ones.
        ``campaign_map``: angle and speed of all experiments, and of those with too few events.

    Raises
    ------
    ValueError
        If the blocks do not give as many experiments and levels as the article counts.
    """
    return gather(params, inputs, [part(params, inputs, 0, 1)])


def part(
    params: Params, inputs: Mapping[str, pd.DataFrame], index: int, count: int
) -> list[tuple[int, dict[str, Any]]]:
    """Return the rows of every ``count``-th experiment, from ``index`` on, with their numbers."""
    experiments = params.experiments
    check_counts(experiments, _printed(inputs), params.speed_ranges_within)
    pairs = {one.pair: one for one in experiments}
    contacts = {pair: contact(params, one, inputs) for pair, one in pairs.items()}
    return [
        (number, conducted(params, one, *contacts[one.pair]))
        for number, one in enumerate(experiments)
        if number % count == index
    ]


def gather(
    params: Params,
    inputs: Mapping[str, pd.DataFrame],
    parts: Sequence[list[tuple[int, dict[str, Any]]]],
) -> Mapping[str, pd.DataFrame]:
    """Return the tables, from the rows of all parts."""
    rows = pd.DataFrame([row for _, row in sorted(chain(*parts), key=itemgetter(0))])
    return {
        "campaign": rows,
        "campaign_summary": summary(params, rows, counts(params.experiments), _printed(inputs)),
        "campaign_map": mapped(rows, params.stop.fewest_events),
    }


def _printed(inputs: Mapping[str, pd.DataFrame]) -> pd.Series:
    return inputs["anchors"].set_index("key")["value"].astype(float)


def conducted(params: Params, one: Experiment, of: Contact, evidence: str) -> dict[str, Any]:
    """Return one experiment as a row of the table; it does not depend on the others.

    Parameters
    ----------
    params, one
        Settings, and which experiment.
    of, evidence
        As from `contact`.
    """
    drop = one.drop(of, params.dispenser)
    rng = generator(params.seed, *drop.key)
    if one.angle == NORMAL:
        outcome: Outcome = doppler.collect(drop.tabulated(), params.pdpa, params.stop, rng)
    else:
        outcome = imaging.collect(drop, params.ptis, params.stop, rng)
    return experiment_row(one, evidence, outcome)


def contact(
    params: Params, one: Experiment, inputs: Mapping[str, pd.DataFrame]
) -> tuple[Contact, str]:
    """Return the contact of an experiment: adhesion and damping of its case, its own materials.

    And whether it was calibrated for these materials, or is assumed to be as for others.
    """
    rows: Any = inputs["materials"].to_dict("records")
    materials = materials_from_rows(rows)
    case = calibrated_contact(inputs, one.case)
    own = case.replace(
        particle=find_material(one.particles.particle, materials),
        surface=find_material(one.surface.surface, materials),
        work_of_adhesion=case.work_of_adhesion,
        friction=params.friction,
    )
    table = inputs["calibration"]
    calibrated = tuple(table.loc[table["case"] == one.case, ["particle", "surface"]].iloc[0])
    same = calibrated == (one.particles.particle, one.surface.surface)
    diameter = mean(one.particles.diameter_um) * 1e-6
    return resized(own, diameter), "calibrated" if same else "assumed"


def summary(
    params: Params, rows: pd.DataFrame, counted: Mapping[str, int], printed: pd.Series
) -> pd.DataFrame:
    """Return the counts of the campaign beside the printed ones, and what came of it."""
    events = rows["events"]
    facts: dict[str, float] = {
        **counted,
        "events": int(events.sum()),
        "events per experiment": float(events.mean()),
        "particles dropped": int(rows["dropped"].sum()),
        "by PDPA": int((rows["instrument"] == "PDPA").sum()),
        "with a calibrated contact": int((rows["contact_evidence"] == "calibrated").sum()),
        f"fewer than {params.stop.fewest_events} events": int(
            (events < params.stop.fewest_events).sum()
        ),
        f"fewer than {params.stop.events} events": int((events < params.stop.events).sum()),
    }
    wanted = {name: printed[key] for name, key in COUNTED.items()}
    wanted["events per experiment"] = printed["campaign_events_per_experiment"]
    return pd.DataFrame(
        [
            {
                "quantity": name,
                "value": value,
                "printed": wanted.get(name, np.nan),
                "evidence": "chosen" if name in counted else "virtual experiment",
            }
            for name, value in facts.items()
        ]
    )


def mapped(rows: pd.DataFrame, fewest: int) -> pd.DataFrame:
    """Return where the experiments lie, by particles and surface: angle and nominal speed."""
    frames = []
    few = rows["events"] < fewest
    for panel, shown in ((ALL, rows), (FEW, rows[few])):
        for (particles, surface), own in shown.groupby(["particles", "surface"], sort=False):
            frames.append(
                series_frame(
                    panel=panel,
                    series=f"{particles} on {surface}",
                    evidence="virtual experiment",
                    x=own["angle_deg"],
                    y=own["nominal_speed_m_per_s"],
                    x_unit="deg",
                    y_unit="m_per_s",
                )
            )
    return pd.concat(frames, ignore_index=True)
