"""Tables from which a browser finds any impact's outcome, and the errors of doing so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.declared.parameters import Positive
from microimpact.lab.contacts import calibrated_contact, declared
from microimpact.model.contact import Contact
from microimpact.model.pairs import pair_contact
from microimpact.studies.models.explorer_tables.accuracy import accuracy
from microimpact.studies.models.explorer_tables.coordinates import (
    IMPULSE_EXPONENT,
    THRESHOLD_EXPONENT,
    adhesion_strength,
    chebyshev_nodes,
    impulse_strength_at,
    impulse_unit,
    slow_passage,
    strength_at,
    time_unit,
)
from microimpact.studies.models.explorer_tables.impacts import (
    ScaledImpacts,
    impacts,
    scaled_thresholds,
)

Nodes = Annotated[int, Field(ge=4, le=60)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Range and fineness of the tables, and the points at which they are tried.

    The numbers of nodes belong to the axes damping, share of Hertz damping and, of the latter two
    tables, distance from the threshold.
    """

    largest_damping: Positive
    threshold_nodes: tuple[Nodes, Nodes]
    restitution_nodes: tuple[Nodes, Nodes, Nodes]
    impulse_nodes: tuple[Nodes, Nodes, Nodes]
    seed: Annotated[int, Field(ge=0)]
    trial_points: Annotated[int, Field(ge=100)]
    near_threshold: Positive


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Return the tables of the explorer.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        ``materials``, ``contacts``: all declared rows; ``calibration``: the table of that study.

    Returns
    -------
    mapping
        ``explorer_threshold``, ``explorer_restitution``, ``explorer_impulses``: values at the
        nodes of the axes described in `_explorer_coordinates`, one row per node;
        ``explorer_accuracy``: largest and root mean square errors of interpolation;
        ``explorer_materials``, ``explorer_contacts``: what is declared and calibrated, in SI.
    """
    tables = {
        "explorer_threshold": threshold_table(params),
        "explorer_restitution": restitution_table(params),
        "explorer_impulses": impulse_table(params),
    }
    return tables | {
        "explorer_accuracy": accuracy(
            tables,
            largest_damping=params.largest_damping,
            near=params.near_threshold,
            points=params.trial_points,
            seed=params.seed,
        ),
        "explorer_materials": materials_table(inputs),
        "explorer_contacts": contacts_table(inputs),
    }


def threshold_table(params: Params) -> pd.DataFrame:
    """Return the speed at the threshold, in velocity scales, over the cube root of D."""
    axes = _axes(params.threshold_nodes)
    damping, share = _damped(params, axes, THRESHOLD_EXPONENT)
    scaled = scaled_thresholds(damping, share) / np.cbrt(damping)
    return _frame(("damping_axis", "share_axis"), axes, {"scaled_threshold": scaled})


def restitution_table(params: Params) -> pd.DataFrame:
    """Return e over its axis, and the work of Hertz damping over its share of D."""
    axes = _axes(params.restitution_nodes)
    damping, share = _damped(params, axes, THRESHOLD_EXPONENT)
    critical = adhesion_strength(scaled_thresholds(damping[..., :1], share[..., :1]))
    found = _rebounds("restitution_nodes", damping, share, strength_at(axes[2], critical))
    values = {
        "scaled_restitution": found.restitution / axes[2],
        "scaled_hertz_work": found.hertz_work / share,
    }
    return _frame(("damping_axis", "share_axis", "closeness_axis"), axes, values)


def impulse_table(params: Params) -> pd.DataFrame:
    """Return the impulses that may support friction, and the contact time, in their units."""
    axes = _axes(params.impulse_nodes)
    damping, share = _damped(params, axes, IMPULSE_EXPONENT)
    critical = adhesion_strength(scaled_thresholds(damping[..., :1], share[..., :1]))
    strength = impulse_strength_at(axes[2], critical)
    found = _rebounds("impulse_nodes", damping, share, strength)
    unit = impulse_unit(strength)
    time = found.contact_time / time_unit(strength)
    values = {
        "scaled_compressive_impulse": found.compressive_impulse / unit,
        "scaled_hertz_impulse": found.hertz_impulse / unit,
        "scaled_net_impulse": (found.peak_net_impulse - 1.0) / unit,
        "scaled_contact_time": time + slow_passage(strength, found.restitution),
    }
    return _frame(("damping_axis", "share_axis", "closeness_axis"), axes, values)


def materials_table(inputs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the declared materials in SI units."""
    materials = declared(inputs)[0].values()
    columns = ("youngs_modulus", "poissons_ratio", "density")
    return pd.DataFrame(
        [{"material": m.name} | {name: getattr(m, name) for name in columns} for m in materials]
    )


def contacts_table(inputs: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the calibrated cases and the declared pairs in SI units."""
    materials, pairs = declared(inputs)
    calibration = inputs["calibration"]
    cases = list(dict.fromkeys(calibration["case"]))
    rows = [_row("calibrated", case, calibrated_contact(inputs, case)) for case in cases]
    rows += [
        _row("declared", f"{particle} on {surface}", contact)
        for (particle, surface) in pairs
        for contact in [pair_contact(particle, surface, materials, pairs)]
    ]
    return pd.DataFrame(rows)


def _row(origin: str, name: str, contact: Contact) -> dict[str, object]:
    columns = (
        *("diameter", "work_of_adhesion", "hertz_damping", "adhesion_damping"),
        *("adhesion_rate_exponent", "reference_velocity", "friction"),
    )
    bodies = {"particle": contact.particle.name, "surface": contact.surface.name}
    return {"origin": origin, "contact": name} | bodies | {c: getattr(contact, c) for c in columns}


def _rebounds(
    key: str, damping: FloatArray, share: FloatArray, strength: FloatArray
) -> ScaledImpacts:
    """Return outcomes at nodes, all of which must lie above the threshold, rounding included."""
    found = impacts(damping, share, strength)
    if np.any(found.captured):
        raise ValueError(
            f"explorer_tables.{key}: with {strength.shape[2]} nodes towards the threshold the first"
            " is too close to it for double precision; give fewer"
        )
    return found


def _axes(counts: tuple[int, ...]) -> tuple[FloatArray, ...]:
    return tuple(np.meshgrid(*(chebyshev_nodes(n) for n in counts), indexing="ij"))


def _damped(
    params: Params, axes: tuple[FloatArray, ...], exponent: float
) -> tuple[FloatArray, FloatArray]:
    """Return D and the share of Hertz damping, which is the square of its axis."""
    return params.largest_damping * np.power(axes[0], 1.0 / exponent), np.square(axes[1])


def _frame(
    names: tuple[str, ...], axes: tuple[FloatArray, ...], values: Mapping[str, FloatArray]
) -> pd.DataFrame:
    columns = dict(zip(names, axes, strict=True)) | dict(values)
    return pd.DataFrame({name: np.ravel(column) for name, column in columns.items()})
