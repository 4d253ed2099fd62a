"""Effect of slopes of the surface on restitution, impulse ratio and energy loss."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from study.declared.parameters import AngleDegrees, CaseName, Name, NonNegative
from study.samples import (
    Dropped,
    Sample,
    Sampling,
    difference_columns,
    half_width,
    mean_columns,
)
from study.tables import Tables


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A smooth and a rough surface of one material, each with its own contact."""

    smooth: Dropped
    rough: Dropped
    adhesion_factor: NonNegative


@dataclass(frozen=True, slots=True, kw_only=True)
class Slope:
    """Surfaces compared, and slopes swept."""

    # Of surfaces; the work of adhesion of the rough one is multiplied by ``adhesion_factor``.
    pairs: dict[Name, Pair]
    angles_deg: tuple[AngleDegrees, ...]  # Of incidence
    swept: Dropped  # Spheres and smooth surface whose slope is swept
    cases: tuple[CaseName, ...]  # Calibrated contacts of these
    slope_sds: tuple[NonNegative, ...]  # Swept
    # Steel and spores on one rough surface.
    formica_steel: Dropped
    formica_spore: Dropped


def slope_tables(params: Slope, sampling: Sampling, inputs: Tables) -> dict[str, pd.DataFrame]:
    """Return the tables of the slope mechanism, by name."""
    return {
        "slope_mechanism": pd.DataFrame(sweep_rows(params, sampling, inputs)),
        "surface_pairs": pd.DataFrame(pair_rows(params, sampling, inputs)),
        "formica_mechanism": pd.DataFrame(formica_comparison(params, sampling, inputs)),
    }


def sweep_rows(params: Slope, sampling: Sampling, inputs: Tables) -> Iterator[dict[str, Any]]:
    """Means over slopes and angles, and their differences from the smooth surface."""
    for case in params.cases:
        sample = Sample.of(replace(params.swept, case=case), sampling, inputs)
        for angle in params.angles_deg:
            smooth = sample.with_changes(surface_slope=0.0).seen(angle)
            for slope in params.slope_sds:
                sloped = sample.with_changes(surface_slope=slope).seen(angle)
                yield (
                    {"case": case, "slope_sd": slope, "angle_deg": angle}
                    | mean_columns(sloped)
                    | difference_columns(sloped, smooth, sampling)
                    | {"evidence": "virtual experiment"}
                )


def pair_rows(params: Slope, sampling: Sampling, inputs: Tables) -> Iterator[dict[str, Any]]:
    """Rough less smooth surface at every angle, and the loss that squared restitutions predict."""
    for name, pair in params.pairs.items():
        flat, sloped = (Sample.of(of, sampling, inputs) for of in (pair.smooth, pair.rough))
        work = sloped.contact.work_of_adhesion
        assert work is not None
        sloped = sloped.with_contact(
            sloped.contact.replace(work_of_adhesion=work * pair.adhesion_factor)
        )
        for angle in params.angles_deg:
            smooth, rough = flat.seen(angle), sloped.seen(angle)
            e, e_rough = (one.means["restitution"].value for one in (smooth, rough))
            predicted = e**2 - e_rough**2
            width = half_width(rough.means["energy_loss"], smooth.means["energy_loss"], sampling)
            columns = difference_columns(rough, smooth, sampling)
            error = columns["energy_loss_difference"] - predicted
            yield {
                "pair": name,
                "case": pair.rough.case,
                "angle_deg": angle,
                **mean_columns(rough),
                **columns,
                "loss_less_squares_over_half_width": error / width,
                "evidence": "virtual experiment",
            }


def formica_comparison(
    params: Slope, sampling: Sampling, inputs: Tables
) -> Iterator[dict[str, Any]]:
    """Yield steel and spores on one rough surface: means, differences, captured and biased."""
    both = (params.formica_steel, params.formica_spore)
    steel, spore = (Sample.of(dropped, sampling, inputs) for dropped in both)
    for angle in params.angles_deg:
        steel_seen, spore_seen = steel.seen(angle), spore.seen(angle)
        free = spore_seen.means["restitution"].value
        yield (
            {"angle_deg": angle}
            | {f"steel_{name}": value for name, value in mean_columns(steel_seen).items()}
            | {f"spore_{name}": value for name, value in mean_columns(spore_seen).items()}
            | difference_columns(steel_seen, spore_seen, sampling)
            | {
                # Captured particles have a restitution of zero.
                "spore_bias_of_conditional_mean": free * spore_seen.captured_share,
                "evidence": "virtual experiment",
            }
        )
