"""Bias of the correction to the surface at given restitution: from records, and in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.constants import gravity
from microimpact.core.tables import series_frame
from microimpact.declared.parameters import Count, Positive
from microimpact.lab.bounces import with_later_impacts
from microimpact.lab.events import IntArray
from microimpact.lab.pdpa.observation import at_surface, observe
from microimpact.lab.pdpa.pairing import Form, correct
from microimpact.lab.surface import Rebound
from microimpact.statistics.distributions import generator
from microimpact.statistics.intervals import mean_and_error
from microimpact.studies.experiments.pair_search.doppler import Setup, dropped

_frame = partial(series_frame, "correction", x_unit="m_per_s", y_unit="1")

FORMS: tuple[Form, ...] = ("printed", "exact")


@dataclass(frozen=True, slots=True, kw_only=True)
class Correction:
    """Impacts at exact speeds with given restitution, so many of each."""

    speeds_m_per_s: tuple[Positive, ...]
    restitutions: tuple[Annotated[float, Field(gt=0, le=1)], ...]
    particles: Count
    curve_points: Annotated[int, Field(ge=20)]


def surface_correction(setup: Setup, params: Correction, key: int) -> pd.DataFrame:
    """Return the bias of both corrections on the speeds v and V, m/s, and on e.

    ``closed_form`` is that of the printed correction. ``printed`` and ``exact`` come from the
    analyser's records and the height found from them, each with its standard error. Where the
    rebound does not reach the probe volume there is none.
    """
    rows: list[dict[str, object]] = []
    for i, speed in enumerate(params.speeds_m_per_s):
        for j, e in enumerate(params.restitutions):
            expected = closed_form(speed, e, 1e-3 * setup.instrument.probe_height_mm)
            found = _measured(setup, params.particles, speed, e, (key, i, j))
            for quantity, true in {"v": speed, "V": e * speed, "e": e}.items():
                row = {
                    "speed_m_per_s": speed,
                    "restitution": e,
                    "probe_height_mm": setup.instrument.probe_height_mm,
                    "quantity": quantity,
                    "true": true,
                    "events": len(found["exact"][quantity]),
                    "closed_form": expected[quantity],
                }
                for form in FORMS:
                    mean, error = mean_and_error(found[form][quantity] - true)
                    row |= {form: mean, f"{form}_standard_error": error}
                rows.append(row)
    return pd.DataFrame(rows)


def closed_form(speed: float, e: float, height: float) -> dict[str, float]:
    """Return the bias of the printed correction on v, V and e; nan where V does not reach h."""
    gained = 2.0 * gravity * height
    if (e * speed) ** 2 <= gained:
        return dict.fromkeys(("v", "V", "e"), float("nan"))
    at_probe = np.sqrt(np.square([speed, e * speed]) - gained)
    v, V = (float(x) for x in np.asarray(correct(at_probe, height, "printed")))
    return {"v": v - speed, "V": V - e * speed, "e": V / v - e}


def correction_curves(table: pd.DataFrame, params: Correction) -> pd.DataFrame:
    """Return the bias of e against speed: closed forms, and what the records give."""
    (height,) = 1e-3 * table["probe_height_mm"].unique()
    ends = min(params.speeds_m_per_s), max(params.speeds_m_per_s)
    frames = []
    for e in params.restitutions:
        # From the slowest impact whose rebound reaches the probe volume.
        slowest = max(ends[0], (1.0 + 1e-9) * float(np.sqrt(2.0 * gravity * height)) / e)
        if slowest < ends[1]:
            speed = np.geomspace(slowest, ends[1], params.curve_points)
            bias = np.array([closed_form(v, e, height)["e"] for v in speed])
            frames.append(_frame(f"closed form, e = {e:g}", speed, bias))
        rows = table[(table["quantity"] == "e") & (table["restitution"] == e)]
        rows = rows[rows["exact_standard_error"].notna()]
        speed = rows["speed_m_per_s"].to_numpy(float)
        for form in FORMS:
            bias, error = (rows[name].to_numpy(float) for name in (form, f"{form}_standard_error"))
            frames.append(
                _frame(
                    f"{form}, e = {e:g}",
                    speed,
                    bias,
                    "virtual experiment",
                    bias - 1.96 * error,
                    bias + 1.96 * error,
                )
            )
    return pd.concat(frames, ignore_index=True)


def _measured(
    setup: Setup, particles: int, speed: float, e: float, key: tuple[int, ...]
) -> dict[Form, dict[str, FloatArray]]:
    """Return v, V and e of the first impacts that were identified, by correction."""

    def bounce(velocity: FloatArray, spin: FloatArray, sphere: IntArray) -> Rebound:
        kept = np.zeros(len(sphere), dtype=np.bool_)
        after = velocity * [1.0, 1.0, -e]
        return Rebound(velocity=after, spin=spin, kept=kept, contacts=np.ones_like(sphere))

    impacts = dropped(setup, speed, particles, (*key, 0))
    first = bounce(impacts.velocity, impacts.spin, np.arange(particles))
    impacts = replace(
        impacts,
        rebound_velocity=first.velocity,
        rebound_spin=first.spin,
        captured=first.captured,
    )
    duration, rng = float(np.max(impacts.time)), generator(setup.seed, *key, 1)
    followed = with_later_impacts(impacts, bounce, setup.instrument.later_impacts)
    found = observe(followed, particles, duration, setup.instrument, rng)
    chosen = (found.measured.event >= 0) & (found.measured.event < particles)
    reduced: dict[Form, dict[str, FloatArray]] = {}
    for form in FORMS:
        events = at_surface(found.stream, found.pairing, found.truth, form)
        reduced[form] = {
            "v": -events.incident_normal[chosen],
            "V": events.rebound_normal[chosen],
            "e": events.coefficient_of_restitution[chosen],
        }
    return reduced
