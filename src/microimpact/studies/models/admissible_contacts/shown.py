"""Data of the figures: marginals and pairs of the draws, and what they have for e."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Tables, series_frame
from microimpact.lab.contacts import BAND, admissible_contact, calibrated_contact
from microimpact.model.contact import resized
from microimpact.model.dynamics.normal import normal_impact
from microimpact.studies.models.admissible_contacts.case import Case, Variant

# Densities are shown this factor beyond the outermost draws.
BESIDE = 1.2
# Series of other things than a variant.
PRINTED, TWO_STAGE = "printed", "two-stage"


def density(values: FloatArray, at: FloatArray) -> FloatArray:
    """Return the density of draws at some places, its highest value 1 (Gaussian kernels)."""
    from scipy.stats import gaussian_kde

    found = gaussian_kde(values)(at)
    return np.asarray(found / np.max(found))


def marginals(
    case: Case, variants: Iterable[Variant], draws: pd.DataFrame, summary: pd.DataFrame, points: int
) -> dict[str, pd.DataFrame]:
    """Return densities and pairs of the draws of one case, beside the two-stage estimates."""
    shares = np.linspace(0.0, 1.0, points)
    limits, others, works = [], [], []
    limit = partial(series_frame, "limit", x_unit="m_per_s", y_unit="1")
    share = partial(series_frame, "share", x_unit="1", y_unit="1")
    rate = partial(series_frame, "rate", x_unit="1", y_unit="1")
    work = partial(series_frame, "work", x_unit="J_per_m2", y_unit="m_per_s")
    for variant in variants:
        rows = draws[(draws["case"] == case.case) & (draws["variant"] == variant.variant)]
        v_c, part = rows["v_c_derived_m_per_s"].to_numpy(), rows["adhesion_share"].to_numpy()
        n, w = rows["rate_exponent"], rows["work_of_adhesion_J_per_m2"]
        name, kind = variant.variant, "calibrated"
        speeds = np.geomspace(v_c.min() / BESIDE, v_c.max() * BESIDE, points)
        limits.append(limit(name, speeds, density(np.log(v_c), np.log(speeds)), kind))
        others += [share(name, shares, density(part, shares), kind), rate(name, n, part, kind)]
        works.append(work(name, w, v_c, kind))
    table = summary[summary["case"] == case.case].pivot(
        index="estimate", columns="quantity", values="median"
    )
    v_c_name = f"v_c_at_{case.diameter_um:g}_um_m_per_s"
    for other in case.compared:
        row = table.loc[f"{TWO_STAGE}, {other}"]
        name, kind = f"{TWO_STAGE}, {other}", "calibrated"
        others.append(share(name, row["adhesion_share"], 0.0, kind))
        others.append(rate(name, row["rate_exponent"], row["adhesion_share"], kind))
        works.append(work(name, row["work_of_adhesion_J_per_m2"], row[v_c_name], kind))
    limits += [limit(PRINTED, value, 0.0, PRINTED) for value in case.printed_limits()]
    return {
        "admissible_limits": pd.concat(limits, ignore_index=True),
        "admissible_shares": pd.concat(others, ignore_index=True),
        "admissible_works": pd.concat(works, ignore_index=True),
    }


def bands(case: Case, variants: Iterable[Variant], inputs: Tables, points: int) -> pd.DataFrame:
    """Return e against the normal speed: bands of the draws, single contacts, printed facts.

    `case`: the pair; bands are of its diameter; `inputs`: ``admissible_contacts``, ``calibration``,
    ``materials``.
    """
    frame = partial(series_frame, case.case, x_unit="m_per_s", y_unit="1")
    speeds = np.geomspace(*case.shown_m_per_s, points)
    frames = []
    for variant in variants:
        contact = resized(
            admissible_contact(inputs, case.case, variant.variant), case.diameter_um * 1e-6
        )
        e = normal_impact(contact, speeds[:, None]).coefficient_of_restitution
        low, high = np.quantile(e, BAND[::2], axis=1)
        table = inputs["admissible_contacts"]
        rows = table[(table["case"] == case.case) & (table["variant"] == variant.variant)]
        single = e[:, int(np.argmax(rows["most_central"]))]
        frames.append(frame(variant.variant, speeds, single, "calibrated", low, high))
    for other in case.compared:
        contact = resized(calibrated_contact(inputs, other), case.diameter_um * 1e-6)
        e = normal_impact(contact, speeds).coefficient_of_restitution
        frames.append(frame(f"{TWO_STAGE}, {other}", speeds, e, "calibrated"))
    for size, speed, (low, high) in case.printed_restitutions():
        name = f"{PRINTED}, {size:g} um"
        frames.append(frame(name, speed, 0.5 * (low + high), PRINTED, low, high))
    frames += [frame(PRINTED, value, 0.0, PRINTED) for value in case.printed_limits()]
    return pd.concat(frames, ignore_index=True)
