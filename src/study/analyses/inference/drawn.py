"""Data of the figures: intervals by scenario, omission, choice and law; e against the speed."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from microimpact.model.choices import INTERVAL
from microimpact.model.contact import resized
from microimpact.model.dynamics.normal import normal_impact
from study.analyses.inference.case import WORK, Case
from study.contacts import ALL_LAWS, posterior_contact, solved_contacts
from study.tables import Tables, series_frame

# A law whose contacts are worth fewer independent ones than this is drawn grey.
FEW = 50.0
GREY, PRINTED = "few contacts", "printed"
# Contacts of a band, at most.
CONTACTS = 200
# The likelihood does not fall towards rest if what is likely begins below this part of its end.
OPEN = 0.1
INTERVALS = {
    "evidence_limits": ("v_c_m_per_s", "capture velocity", "m_per_s"),
    "evidence_works": (WORK, "work of adhesion", "J_per_m2"),
}


def intervals(case: Case, summary: pd.DataFrame) -> Tables:
    """Return intervals of the capture velocity and of the work of adhesion.

    The abscissa counts scenarios, omissions and choices; a series is ``kind; name; law``, and ends
    with `GREY` where few contacts count. Laws that are excluded are left out.
    """
    rows = summary[summary["standing"] != "excluded"]
    number = {row: i + 1 for i, row in enumerate(dict.fromkeys(zip(*_named(rows), strict=True)))}
    tables = {}
    for table, (quantity, panel, unit) in INTERVALS.items():
        frame = partial(series_frame, panel, x_unit="1", y_unit=unit)
        frames = [
            frame(
                "; ".join((row["kind"], row["scenario"], row["law"], *few)),
                number[row["kind"], row["scenario"]],
                row["median"],
                "calibrated",
                row["low"],
                row["high"],
            )
            for _, row in rows[rows["quantity"] == quantity].iterrows()
            for few in [() if row["effective_size"] > FEW else (GREY,)]
        ]
        tables[table] = pd.concat(frames, ignore_index=True)
    printed = [
        series_frame("capture velocity", PRINTED, 0.0, v, PRINTED, x_unit="1", y_unit="m_per_s")
        for v in printed_limits(case)
    ]
    limits = [tables["evidence_limits"], *printed]
    return tables | {
        "evidence_limits": pd.concat(limits, ignore_index=True),
        "capture_velocity_summary": overview(case, rows),
    }


def overview(case: Case, summary: pd.DataFrame) -> pd.DataFrame:
    """Return the capture velocity as printed, then over all laws by scenario.

    A printed value of another size is at that of the case, by the exponent of the first scenario.
    Where the likelihood does not fall towards rest, there is an upper bound and no middle.
    """
    of_all = summary[(summary["law"] == ALL_LAWS) & (summary["kind"] == "scenario")]
    rows = of_all[of_all["quantity"] == "v_c_m_per_s"]
    exponent = float(of_all.loc[of_all["quantity"] == "size_exponent", "median"].iloc[0])
    frame = partial(series_frame, "all", x_unit="1", y_unit="m_per_s")
    frames: list[pd.DataFrame] = []
    for name, statement in case.statements.items():
        if statement.standing == PRINTED and statement.quantity == "capture velocity in m/s":
            diameter = statement.median_diameter_um or case.diameter_um
            low, high = np.array(statement.interval) * (case.diameter_um / diameter) ** exponent
            frames.append(frame(name, len(frames), 0.5 * (low + high), PRINTED, low, high))
    for _, row in rows.iterrows():
        is_bound = row["likely_low"] < OPEN * row["likely_high"]
        low, high = (0.0, row["likely_high"]) if is_bound else (row["low"], row["high"])
        middle = high if is_bound else row["median"]
        frames.append(frame(row["scenario"], len(frames), middle, "calibrated", low, high))
    return pd.concat(frames, ignore_index=True)


def _named(rows: pd.DataFrame) -> tuple[pd.Series, pd.Series]:
    return rows["kind"], rows["scenario"]


def printed_limits(case: Case) -> list[float]:
    """Middles of the stated capture velocities of an open size, m/s."""
    return [
        0.5 * sum(each.interval)
        for each in case.statements.values()
        if each.quantity == "capture velocity in m/s" and each.diameter_um is None
    ]


def bands(
    name: str, case: Case, drawn: pd.DataFrame, inputs: Tables, laws: set[str], points: int
) -> pd.DataFrame:
    """Return e against the normal speed: bands of drawn contacts, single contacts, printed values.

    Parameters
    ----------
    name, case
        The pair; bands are of its diameter.
    drawn
        Rows of ``posterior_contacts``.
    inputs
        ``calibration``, ``materials``.
    laws
        Those that are shown, as ``scenario; law``.
    points
        Speeds.
    """
    speeds = np.geomspace(*case.shown_m_per_s, points)
    frames = []
    for (scenario, law), rows in drawn[drawn["case"] == name].groupby(
        ["scenario", "law"], sort=False
    ):
        if f"{scenario}; {law}" not in laws:
            continue
        few = rows.iloc[:: max(len(rows) // CONTACTS, 1)]
        contact = posterior_contact(inputs, few)
        e = normal_impact(contact, speeds[:, None]).coefficient_of_restitution
        low, middle, high = np.quantile(e, INTERVAL, axis=1)
        panel = partial(series_frame, f"{name}, {scenario}", x_unit="m_per_s", y_unit="1")
        frames.append(panel(str(law), speeds, middle, "calibrated", low, high))
    for scenario in dict.fromkeys(key.partition("; ")[0] for key in sorted(laws)):
        panel = partial(series_frame, f"{name}, {scenario}", x_unit="m_per_s", y_unit="1")
        for compared, contact in solved_contacts(inputs, case.compared).items():
            resized_contact = resized(contact, case.diameter_um * 1e-6)
            e = normal_impact(resized_contact, speeds).coefficient_of_restitution
            frames.append(panel(compared, speeds, e, "calibrated"))
        for statement in case.statements.values():
            if statement.quantity == "restitution" and statement.standing == PRINTED:
                speed = statement.impacts()[:, :, 1].mean(axis=1)
                low, high = statement.interval
                if high < 1.0:
                    at = speed, 0.5 * (low + high), PRINTED, low, high
                    frames.append(panel("printed for oblique impact", *at))
        frames += [panel(PRINTED, v, 0.0, PRINTED) for v in printed_limits(case)]
    return pd.concat(frames, ignore_index=True)
