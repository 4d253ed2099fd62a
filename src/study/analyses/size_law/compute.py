"""How the capture velocity goes with the size, by law of contact, and impacts that decide on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import AboveOne, Positive
from microimpact.model.choices import INTERVAL
from microimpact.model.contact import Contact, resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from study.contacts import (
    calibrated_contact,
    posterior_contact,
    posterior_rows,
)
from study.declared.parameters import Ascending, CaseName, InferredName, LawName, ScenarioName
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration",), "inference": ("posterior_contacts",)}

PUBLISHED = "published power"
# Draws of each law, speeds of an experiment, sizes of a curve.
DRAWS, SPEEDS, SIZES = 60, 60, 15
# Relative step of a slope over the logarithm of the speed.
STEP = 1e-3
Sizes = Annotated[tuple[Positive, ...], Field(min_length=2), Ascending]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Laws that are compared, and rebounds from spheres of two sieves."""

    case: InferredName
    scenario: ScenarioName
    laws: Annotated[tuple[LawName, ...], Field(min_length=2)]
    compared: tuple[CaseName, ...]  # Single contacts shown beside them
    published_exponent: Positive  # Power of one over the diameter
    smaller_um: Positive
    larger_um: Sizes
    shown_um: Annotated[tuple[Positive, Positive], Ascending]
    lowest_speeds_in_v_c: Annotated[tuple[AboveOne, ...], Field(min_length=1)]
    highest_speed_in_v_c: AboveOne
    noise_of_e: Positive  # Of one rebound
    scatter_of_size: Positive  # Relative standard deviation within a sieve
    standard_errors: Positive  # By which two exponents are to differ


def run(params: Params, inputs: Tables) -> Tables:
    """Compare exponents of the diameter, and count the rebounds that tell them apart.

    ``size_law_exponents``: by law, with the published one. ``size_law_design``: rebounds per sieve
    for every pair of laws, larger sieve and lowest speed. ``size_law_curves`` and
    ``size_law_impacts``: data of the figure.

    Parameters
    ----------
    inputs
        ``calibration``, ``posterior_contacts``; ``materials``, declared rows.
    """
    contacts = {law: drawn(params, inputs, law) for law in params.laws}
    design = pd.DataFrame(
        [row for pair in combinations(contacts, 2) for row in impacts(params, contacts, pair)]
    )
    sizes = np.geomspace(*params.shown_um, SIZES)
    frame = partial(series_frame, "size", x_unit="um", y_unit="m_per_s")
    curves, rows = [], []
    for law, contact in contacts.items():
        limits = capture_velocity(resized(contact, sizes[:, None] * 1e-6))
        low, middle, high = np.quantile(limits, INTERVAL, axis=1)
        curves.append(frame(law, sizes, middle, "calibrated", low, high))
        each = exponents(contact, params.smaller_um, params.larger_um[-1])
        low, middle, high = -np.quantile(-each, INTERVAL[::-1])
        ends = {"low": low, "median": middle, "high": high}
        rows.append({"law": law, **ends, "evidence": "calibrated"})
    for case in params.compared:
        contact = calibrated_contact(inputs, case)
        limits = capture_velocity(resized(contact, sizes * 1e-6))
        curves.append(frame(case, sizes, limits, "calibrated"))
    at = float(np.interp(params.smaller_um, sizes, curves[0]["y_m_per_s"]))
    power = at * (sizes / params.smaller_um) ** -params.published_exponent
    curves.append(frame(PUBLISHED, sizes, power, "computed"))
    rows.append({"law": PUBLISHED, "median": -params.published_exponent, "evidence": "printed"})
    return {
        "size_law_exponents": pd.DataFrame(rows),
        "size_law_design": design,
        "size_law_curves": pd.concat(curves, ignore_index=True),
        "size_law_impacts": drawn_impacts(design),
    }


def drawn(params: Params, inputs: Tables, law: str) -> Contact:
    """Return some contacts of a law's posterior (draws,), at the size of the smaller sieve."""
    rows = posterior_rows(inputs, params.case, params.scenario, law)
    rows = rows.iloc[:: max(len(rows) // DRAWS, 1)]
    return resized(posterior_contact(inputs, rows), params.smaller_um * 1e-6)


def exponents(contact: Contact, smaller_um: float, larger_um: float) -> FloatArray:
    """Powers of the diameter with which the capture velocity goes between two sizes (draws,)."""
    low, high = (capture_velocity(resized(contact, d * 1e-6)) for d in (smaller_um, larger_um))
    return np.asarray(np.log(high / low) / np.log(larger_um / smaller_um))


def error_of_one(params: Params, contact: Contact, lowest: float, exponent: float) -> float:
    """Standard error of ln v_c from one rebound; from n it is the root of n smaller.

    The speeds are spread evenly over their logarithm. The shape of e(v) is known, its level and
    its capture velocity are not (Fisher information); sizes within a sieve scatter the latter.
    """
    speed = np.geomspace(lowest, params.highest_speed_in_v_c, SPEEDS) * capture_velocity(contact)
    ahead, e, behind = (
        np.asarray(normal_impact(contact, speed * np.exp(step)).coefficient_of_restitution)
        for step in (STEP, 0.0, -STEP)
    )
    slope = (ahead - behind) / (2.0 * STEP)
    gradient = np.stack([-slope, e])
    noise = np.hypot(params.noise_of_e, slope * exponent * params.scatter_of_size)
    information = (gradient / noise) @ (gradient / noise).T / SPEEDS
    return float(np.sqrt(np.linalg.inv(information)[0, 0]))


def impacts(params: Params, contacts: dict[str, Contact], pair: tuple[str, str]) -> Iterator[Row]:
    """Yield the rebounds per sieve after which two laws differ by enough standard errors.

    Parameters
    ----------
    contacts
        By law; each is taken at its median power of the diameter.
    pair
        Names of two laws; the one that needs more rebounds is the true one.
    """
    middles = {}
    for law in pair:
        each = exponents(contacts[law], params.smaller_um, params.larger_um[-1])
        middles[law] = contacts[law].at((int(np.argsort(each)[len(each) // 2]),))
    for larger in params.larger_um:
        powers = {law: float(exponents(middles[law], params.smaller_um, larger)) for law in pair}
        apart = abs(powers[pair[0]] - powers[pair[1]]) * np.log(larger / params.smaller_um)
        for lowest in params.lowest_speeds_in_v_c:
            variances = [
                error_of_one(params, middles[law], lowest, powers[law]) ** 2
                + error_of_one(params, resized(middles[law], larger * 1e-6), lowest, powers[law])
                ** 2
                for law in pair
            ]
            yield {
                "laws": " against ".join(pair),
                "smaller_um": params.smaller_um,
                "larger_um": larger,
                "lowest_speed_in_v_c": lowest,
                "rebounds_per_sieve": np.ceil(
                    max(variances) * (params.standard_errors / apart) ** 2
                ),
                "evidence": "computed",
            }


def drawn_impacts(design: pd.DataFrame) -> pd.DataFrame:
    """Return rebounds per sieve against the larger diameter, by pair of laws, from least speeds."""
    frame = partial(series_frame, "impacts", x_unit="um", y_unit="1")
    lowest = design["lowest_speed_in_v_c"] == design["lowest_speed_in_v_c"].min()
    return pd.concat(
        [
            frame(laws, rows["larger_um"], rows["rebounds_per_sieve"])
            for laws, rows in design[lowest].groupby("laws", sort=False)
        ],
        ignore_index=True,
    )
