"""Facts of other papers beside the model's values for the contacts of this study.

Of Wall, Arffman, Brach and Li only the abstracts are known. A fact that comes as words bounds a
number from one side; what the words leave open is a declared criterion.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, Any, NamedTuple

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.choices import TANGENTIAL_LAWS
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from study.contacts import calibrated_contact
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    ExternalName,
    NonNegative,
    Positive,
)
from study.tables import Tables

NEEDS = {
    "calibration": ("calibration",),
    "fig24_25_doe": ("doe_levels", "doe_effects"),
    "fig23_monte_carlo": ("monte_carlo",),
    "oblique_data": ("oblique_residuals",),
}

# Effects of factors that act as one, as radius and surface energy may, differ by rounding.
TIED = 1e-9
# Diameters or speeds over a range, even in the logarithm.
POINTS = 9

AGREES, DISAGREES = "agrees with independent data", "disagrees with independent data"


class Compared(NamedTuple):
    """One fact beside the number that the model gives; every quantity is a pure number."""

    fact: str
    source: str
    quantity: str
    contact: str
    unit: str = "-"
    measured: float = np.nan
    low: float = np.nan
    high: float = np.nan
    computed: float = np.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Spin:
    """A sphere that rolls off the surface, and how much of its speed its rim has before."""

    case: CaseName
    speed_m_per_s: Positive
    angle_deg: AngleDegrees
    ratio: Positive
    significant: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The sources, the contacts that are compared with them, and numbers for their words.

    `external`: sources of the facts; `fluorescein`, `mica`, `silver`: contacts of fluorescein on
    molybdenum, the one on mica, and those that stand for silver; `molybdenum`: the contact whose
    rebound is compared with that on mica; `rate_exponents`: n of the adhesion damping; each contact
    keeps its capture velocity at its own diameter;
    `same_restitution_within`: difference of e that would not be seen; `exponent_within`: half a
    unit of the last digit of an exponent; by more than this one power exceeds another; `spin`: an
    impact with and without spin.
    """

    external: tuple[ExternalName, ...]
    fluorescein: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    molybdenum: CaseName
    mica: CaseName
    silver: tuple[CaseName, ...]
    rate_exponents: tuple[NonNegative, ...]
    same_restitution_within: Positive
    exponent_within: Positive
    spin: Spin


def fact(facts: pd.DataFrame, name: str, quantity: str) -> dict[str, Any]:
    """Return one row of the declared external evidence; its numbers are floats."""
    rows = facts[(facts["name"] == name) & (facts["quantity"] == quantity)]
    if len(rows) != 1:
        raise NotComputable(f"external evidence {name}.{quantity}: {len(rows)} rows, must be 1")
    return {str(column): value for column, value in rows.iloc[0].items()}


def run(params: Params, inputs: Tables) -> Tables:
    """Put every fact beside the number that the model gives.

    ``external_evidence``: fact, source, quantity, contact, what was measured or its bounds, what
    the model gives and whether it lies within them.

    Parameters
    ----------
    inputs
        ``external``: the facts; ``materials`` and ``calibration``: the contacts; ``doe_levels``,
        ``doe_effects``, ``monte_carlo``, ``oblique_residuals``: tables of those studies.
    """
    facts = inputs["external"]
    rows = [
        *_oblique(inputs["oblique_residuals"]),
        *_fast_rebounds(params, inputs, facts),
        *_sizes(params, inputs, facts),
        *_factors(inputs, facts),
        *_spin_and_roughness(params.spin, inputs, facts),
    ]
    table = pd.DataFrame(rows, columns=Compared._fields)
    # Rows of one fact together.
    table = table.iloc[np.argsort(pd.factorize(table["fact"])[0], kind="stable")]
    table["agreement"] = _agreement(table)
    return {"external_evidence": table}


def _agreement(table: pd.DataFrame) -> Any:
    value = table["computed"]
    outside = (value < table["low"]) | (value > table["high"])
    return np.where(np.isfinite(value), np.where(outside, DISAGREES, AGREES), "not computed")


def _oblique(residuals: pd.DataFrame) -> Iterator[Compared]:
    """Yield the relative rms of each law, within the errors of reading, of friction and of e.

    The spin and the velocity that were measured contradict each other by more than that; the spin
    is taken to be known no better.
    """
    is_law = residuals["law"].isin(TANGENTIAL_LAWS)
    rigid = residuals[~is_law].set_index(["quantity", "branch"])
    rows: list[dict[Any, Any]] = residuals[is_law].to_dict("records")
    for row in rows:
        quantity, branch = row["quantity"], row["branch"]
        if quantity in {"tangential_restitution", "spin"}:
            known = rigid["relative_rms"].get((quantity, branch), 0.0)
            yield Compared(
                f"{quantity.replace('_', ' ')} where a rigid sphere would be {branch}",
                "Kharaz, Gorham and Salman 2001, Powder Technology 120:281",
                "relative rms of all points",
                f"aluminium oxide on glass, {row['law']}",
                high=float(np.hypot(max(row["reading_error"], known), row["input_error"])),
                computed=row["relative_rms"],
            )


def _fast_rebounds(params: Params, inputs: Tables, facts: pd.DataFrame) -> Iterator[Compared]:
    """Yield the energy lost at the highest speed, and the difference that the target makes."""
    lost = fact(facts, "wall1990", "greatest_energy_loss")
    for case in params.fluorescein:
        e = simulate(calibrated_contact(inputs, case), float(lost["at"])).coefficient_of_restitution
        yield Compared(
            "up to half the energy is lost at the highest speeds",
            lost["source"],
            f"energy lost at {lost['at']:g} m/s",
            case,
            high=lost["value"],
            computed=float(1.0 - e**2),
        )
    free = fact(facts, "wall1990", "speed_without_influence_of_target")
    fastest = fact(facts, "wall1990", "greatest_speed")["value"]
    speed = np.geomspace(free["value"], fastest, POINTS)
    on_molybdenum, on_mica = (
        simulate(calibrated_contact(inputs, case), speed).coefficient_of_restitution
        for case in (params.molybdenum, params.mica)
    )
    yield Compared(
        f"no influence of the target above {free['value']:g} m/s",
        free["source"],
        "largest difference of e",
        f"{params.molybdenum}; {params.mica}",
        high=params.same_restitution_within,
        computed=float(np.max(np.abs(on_molybdenum - on_mica))),
    )


def fall(contact: Contact, exponent: float, diameter: FloatArray) -> float:
    """Return the power with which the capture velocity falls over some diameters (m).

    The damping that a contact has at its own capture velocity is kept. Not a number where no speed
    rebounds.
    """
    limit = capture_velocity(contact.replace(adhesion_rate_exponent=0.0, reference_velocity=None))
    rated = contact.replace(adhesion_rate_exponent=exponent, reference_velocity=float(limit))
    limits = np.log(capture_velocity(resized(rated, diameter)))
    slope = -np.polyfit(np.log(diameter), limits, 1)[0] if np.isfinite(limits).all() else np.nan
    return float(slope)


def _sizes(params: Params, inputs: Tables, facts: pd.DataFrame) -> Iterator[Compared]:
    """Yield the power of the diameter with which the capture velocity falls.

    The damping of silver is not known, and that of a contact of this study would hold every sphere
    of 20 nm; so it is asked over as wide a range, about the contact's own diameter.
    """
    least = fact(facts, "wall1990", "least_fall_of_capture_velocity")
    power = fact(facts, "arffman2015", "fall_of_capture_velocity")
    span, silver = (fact(facts, name, "diameter") for name in ("wall1990", "arffman2015"))
    ends = facts[(facts["name"] == "arffman2015") & (facts["quantity"] == "capture_velocity")]
    change = np.ptp(np.log(ends[["value", "at"]].to_numpy(float)), axis=0)
    bounds = [
        *(power["value"] + params.exponent_within * np.array([-1.0, 1.0])),
        change[0] / change[1],
    ]
    microns = 1e-6 * np.geomspace(span["low"], span["high"], POINTS)
    wide = np.geomspace(1.0, silver["high"] / silver["low"], POINTS)
    wide = wide / np.sqrt(wide[-1])
    for name in dict.fromkeys((*params.fluorescein, *params.silver)):
        contact = calibrated_contact(inputs, name)
        for exponent in params.rate_exponents:
            words = f"{name.partition(', n =')[0]}, n = {exponent:g}"
            if name in params.fluorescein:
                yield Compared(
                    "capture velocity falls with size by more than the classical power",
                    least["source"],
                    f"power from {span['low']:g} to {span['high']:g} um",
                    words,
                    low=least["value"] + params.exponent_within,
                    computed=fall(contact, exponent, microns),
                )
            if name in params.silver:
                yield Compared(
                    "capture velocity of silver falls with size by this power",
                    power["source"],
                    f"power over a range of 1 to {silver['high'] / silver['low']:g}",
                    words,
                    measured=power["value"],
                    low=min(bounds),
                    high=max(bounds),
                    computed=fall(contact, exponent, contact.diameter * wide),
                )


def _factors(inputs: Tables, facts: pd.DataFrame) -> Iterator[Compared]:
    """Yield the lead of surface energy and radius, and the rank of one interaction, by design."""
    lead = fact(facts, "brach2000", "lead_of_surface_energy_and_radius")
    rank = fact(facts, "brach2000", "rank_of_their_interaction")
    levels, effects = inputs["doe_levels"], inputs["doe_effects"]
    letters = dict(zip(levels["name"], levels["factor"], strict=True))
    first = {letters["work_of_adhesion"], letters["radius"]}
    both = "".join(sorted(letters[n] for n in ("work_of_adhesion", "adhesion_dissipation")))
    full = effects[(effects["design"] == "full") & (effects["response"] == "v_c")]
    for (case, variation), part in full.groupby(["case", "variation"], sort=False):
        size = part.set_index("effect")["effect_percent"].abs()
        others = sorted(set(letters.values()) - first)
        pairs = ["".join(pair) for pair in combinations(sorted(letters.values()), 2)]
        # factors without which a contact does without, as c_H = 0, have no effect
        pairs = [pair for pair in pairs if pair in size]
        contact = f"{case}; {variation} levels"
        yield Compared(
            "surface energy and radius play by far the greatest part",
            lead["source"],
            "lesser effect of the two over the greatest other",
            contact,
            low=lead["value"],
            computed=float(size[sorted(first)].min() / size[others].max()),
        )
        yield Compared(
            "one interaction plays a small part: surface energy with adhesion damping",
            rank["source"],
            "its rank among the interactions of two",
            contact,
            measured=rank["value"],
            high=rank["value"],
            computed=float(1 + (size[pairs] > (1.0 + TIED) * size[both]).sum()),
        )


def _spin_and_roughness(spin: Spin, inputs: Tables, facts: pd.DataFrame) -> Iterator[Compared]:
    """Yield the change that spin makes, and the apparent restitution of a rough surface."""
    above = fact(facts, "li1996", "apparent_restitution")
    contact = calibrated_contact(inputs, spin.case)
    omega = spin.ratio * spin.speed_m_per_s / contact.radius
    still, spun = (
        simulate(contact, spin.speed_m_per_s, spin.angle_deg, w).impulse_ratio for w in (0.0, omega)
    )
    table = inputs["monte_carlo"]
    shallow = table[table["angle_deg"] == table["angle_deg"].min()]
    least = shallow.loc[shallow["restitution"].idxmin()]
    yield Compared(
        "spin before impact matters significantly",
        above["source"].rpartition(": ")[0],
        f"change of the impulse ratio at {spin.angle_deg:g} deg, over friction",
        f"{spin.case}, rim at {spin.ratio:g} of the speed",
        low=spin.significant,
        computed=float(np.abs(spun - still) / contact.friction),
    )
    yield Compared(
        "roughness gives an apparent restitution above one at shallow angles",
        above["source"],
        f"mean apparent restitution at {least['angle_deg']:g} deg",
        f"Monte Carlo, {least['variant']}",
        low=above["value"],
        computed=float(least["restitution"]),
    )
