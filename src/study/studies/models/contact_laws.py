"""Other laws of contact on the same printed facts of steel on silicon.

The ring force is one law of adhesion. Beside it stand JKR with viscous loss, the elastic-plastic
contact of Thornton and Ning, and rate-independent hysteresis of adhesion. Each has its free
parameters fitted to the same printed restitutions, with and without the printed capture velocity,
and is then asked what the claims ask of the ring force.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Annotated, Literal

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.nearest import nearest
from microimpact.model.contact import Contact, resized
from microimpact.model.contact_laws import JKR, ContactLaw, Hysteresis, ThorntonNing
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import PULL_OFF, simulate
from microimpact.model.dynamics.normal import losses, normal_impact
from study.declared.parameters import (
    CaseName,
    Count,
    Name,
    NonNegative,
    OpenShare,
    Positive,
    PositiveRange,
)
from study.studies.contacts import calibrated_contact
from study.tables import Row, Tables, series_frame

NEEDS = {"calibration": ("calibration",)}

_frame = partial(series_frame, x_unit="m_per_s", y_unit="1")

WORK = "work_of_adhesion_J_per_m2"
# Free parameters of a law besides the work of adhesion, and the unit of each in a table.
FREE = {
    "ring force": {"hertz_damping_s_per_m": "s/m", "adhesion_damping_s_per_m": "s/m"},
    "jkr": {"viscous_time_ns": "ns"},
    "thornton-ning": {"yield_pressure_GPa": "GPa"},
    "hysteresis": {"unloading_over_loading_work": "-"},
}
UNITS = {WORK: "J/m2"} | {name: unit for free in FREE.values() for name, unit in free.items()}
TARGETS = ("with v_c", "without v_c")

# Relative step of elasticities, and steps of a logarithm: of a slope, and to the end of a range.
STEP, SLOPE_STEP, AT_END = 0.01, 1e-5, 0.01
# An interval of the angle in which the impulse ratio is looked at, degrees.
ANGLE_STEP = 0.125

# Ends of the axis, m/s; beyond the printed speeds the laws part.
SLOWEST_DRAWN = 0.05
# m/s
FASTEST_DRAWN = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """A law of contact, and the rate exponent of its damping, if it has one."""

    law: Literal["ring force", "jkr", "thornton-ning", "hysteresis"]
    rate_exponent: NonNegative = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranges:
    """Where each free parameter is sought, from and to."""

    work_of_adhesion_J_per_m2: PositiveRange  # noqa: N815
    hertz_damping_s_per_m: PositiveRange
    adhesion_damping_s_per_m: PositiveRange
    viscous_time_ns: PositiveRange
    yield_pressure_GPa: PositiveRange  # noqa: N815
    unloading_over_loading_work: PositiveRange


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """A printed restitution, at a total speed and an angle of incidence, and its error."""

    restitution: Positive
    error: Positive
    speed_m_per_s: Positive
    angle_deg: Annotated[float, Field(gt=0, le=90)]


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherPair:
    """A pair of which the capture velocity is printed: the work that it needs, by each law."""

    case: CaseName
    capture_velocity_m_per_s: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Criteria:
    """Criteria of the claims on a contact, as numbers."""

    fall_speed_m_per_s: Positive
    about: OpenShare
    negligible_share: OpenShare
    share_speeds_in_v_c: tuple[Positive, ...]
    diameters_um: Annotated[tuple[Positive, ...], Field(min_length=2)]
    compared_diameters_um: tuple[Positive, Positive]
    duration_speeds_m_per_s: tuple[Positive, ...]
    durations_ns: tuple[Positive, Positive]
    plateau_angle_deg: Positive


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The contact, its laws, the facts they are fitted to, and how parameters are sought.

    A grid of ``points`` per parameter spans the ranges; least squares begin at its ``starts`` best.
    """

    case: CaseName
    laws: dict[Name, Law]
    ranges: Ranges
    facts: dict[Name, Fact]
    plateau_speed_m_per_s: Positive
    capture_velocity_m_per_s: Positive
    capture_velocity_error_m_per_s: Positive
    criteria: Criteria
    other_pair: OtherPair
    points: Annotated[int, Field(ge=3)]
    starts: Count
    drawn_points: Annotated[int, Field(ge=10)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """A law fitted to the facts: its contact, parameters, and root mean square of the misfits."""

    law: str
    targets: str
    contact: Contact
    parameters: Mapping[str, float]
    misfit: float
    at_end: tuple[str, ...]


def run(params: Params, inputs: Tables) -> Tables:
    """Fit every law, and apply the criteria of the claims to it.

    ``contact_law_fits``: parameters, misfit and capture velocity of every law, fitted with and
    without the printed capture velocity; works of adhesion of another pair. ``contact_law_facts``:
    what each gives for every printed fact and criterion, and whether that meets it.
    ``contact_law_claims``: by which laws each is met. ``contact_law_curves``: restitution against
    speed in m/s. `inputs`: ``calibration``, table of that study, and ``materials``, declared rows.
    """
    base = calibrated_contact(inputs, params.case)
    fits = [fitted(params, base, law, targets) for targets in TARGETS for law in params.laws]
    facts = pd.concat([facts_of(params, fit) for fit in fits], ignore_index=True)
    rows = [row for fit in fits for row in _fit_rows(fit)] + needed_works(params, inputs)
    return {
        "contact_law_fits": pd.DataFrame(rows),
        "contact_law_facts": facts,
        "contact_law_claims": by_claim(facts),
        "contact_law_curves": curves(params, fits),
    }


def contact_of(base: Contact, law: Law, parameters: Mapping[str, Real]) -> Contact:
    """Return the contact of a law with these parameters, numbers or arrays."""
    work, *free = (parameters[name] for name in (WORK, *FREE[law.law]))
    if law.law == "ring force":
        return base.replace(
            work_of_adhesion=work,
            hertz_damping=free[0],
            adhesion_damping=free[1],
            adhesion_rate_exponent=law.rate_exponent,
        )
    records: dict[str, ContactLaw] = {
        "jkr": JKR(viscous_time=free[0] * 1e-9),
        "thornton-ning": ThorntonNing(yield_pressure=free[0] * 1e9),
        "hysteresis": Hysteresis(unloading_work=work * np.maximum(free[0], 1.0)),
    }
    return base.by_law(records[law.law], work)


def fitted(params: Params, base: Contact, name: str, targets: str) -> Fit:
    """Fit the free parameters of a law: least squares from the best places of a grid."""
    from scipy.optimize import least_squares

    law = params.laws[name]
    names = (WORK, *FREE[law.law])
    low, high = np.log([getattr(params.ranges, name) for name in names]).T

    def off(logs: FloatArray) -> FloatArray:
        values = np.exp(np.clip(logs, low, high)).T[..., None]
        return misfits(
            params, contact_of(base, law, dict(zip(names, values, strict=True))), targets
        )

    # The slopes are asked for where the misfits have just been: one call serves both.
    @lru_cache(maxsize=1)
    def around(*logs: float) -> FloatArray:
        steps = SLOPE_STEP * np.eye(len(names))
        return off(np.array(logs) + np.concatenate([np.zeros((1, len(names))), steps, -steps]))

    def slopes(logs: FloatArray) -> FloatArray:
        ahead, behind = np.split(around(*logs)[1:], 2)
        return np.asarray((ahead - behind).T / (2.0 * SLOPE_STEP))

    axes = np.meshgrid(*np.linspace(low, high, params.points).T, indexing="ij")
    grid = np.stack([axis.ravel() for axis in axes], axis=1)
    starts = grid[np.argsort(np.sum(np.square(off(grid)), axis=1))[: params.starts]]
    inner = 1e-6 * (high - low)

    def alone(logs: FloatArray) -> FloatArray:
        return np.asarray(around(*logs)[0])

    solutions = [
        least_squares(alone, np.clip(start, low + inner, high - inner), slopes, bounds=(low, high))
        for start in starts
    ]
    best = solutions[int(np.argmin([each.cost for each in solutions]))]
    parameters = dict(zip(names, np.exp(best.x).tolist(), strict=True))
    near = np.minimum(best.x - low, high - best.x) < AT_END
    return Fit(
        law=name,
        targets=targets,
        contact=contact_of(base, law, parameters),
        parameters=parameters,
        misfit=float(np.sqrt(np.mean(np.square(best.fun)))),
        at_end=tuple(each for each, reached in zip(names, near, strict=True) if reached),
    )


def law_fit(fits: pd.DataFrame, law: str, targets: str = TARGETS[0]) -> dict[str, float]:
    """Return the fitted parameters of a law, and quantities derived from them.

    Parameters
    ----------
    fits
        The table ``contact_law_fits``.
    law
        Name of the law.
    targets
        One of `TARGETS`: whether the printed capture velocity was fitted, too.

    Raises
    ------
    ValueError
        If there is no such fit.
    """
    rows = fits[(fits["law"] == law) & (fits["targets"] == targets)]
    if rows.empty:
        raise ValueError(f"no law {law!r} was fitted {targets}{nearest(law, set(fits['law']))}")
    return dict(zip(rows["quantity"], rows["value"].astype(float), strict=True))


def misfits(params: Params, contact: Contact, targets: str) -> FloatArray:
    """Misfits (n, facts) of contacts (n, 1) in units of the errors."""
    speed, value, error = printed(params)
    off = (normal_impact(contact, speed).coefficient_of_restitution - value) / error
    if targets == TARGETS[0]:
        limit = np.minimum(np.asarray(capture_velocity(contact)), FASTEST_DRAWN)
        missed = (limit - params.capture_velocity_m_per_s) / params.capture_velocity_error_m_per_s
        off = np.concatenate([off, missed], axis=1)
    return np.asarray(off)


def printed(params: Params) -> FloatArray:
    """Return normal speeds, restitutions and their errors, as printed: shape (3, facts)."""
    return np.array(
        [(_normal_speed(of), of.restitution, of.error) for of in params.facts.values()]
    ).T


def _normal_speed(fact: Fact) -> float:
    return fact.speed_m_per_s * math.sin(math.radians(fact.angle_deg))


def _row(
    law: str, targets: str, quantity: str, value: float, unit: str, *, at_end: bool = False
) -> Row:
    named = {"law": law, "targets": targets, "quantity": quantity, "value": value, "unit": unit}
    return named | {"at_end_of_range": "yes" if at_end else "no"}


def _fit_rows(fit: Fit) -> list[Row]:
    row = partial(_row, fit.law, fit.targets)
    return [
        *(row(n, of, UNITS[n], at_end=n in fit.at_end) for n, of in fit.parameters.items()),
        row("root_mean_square_misfit", fit.misfit, "-"),
        row("capture_velocity", float(capture_velocity(fit.contact)), "m/s"),
        row("exponent_of_the_diameter", _elasticity(fit.contact, "diameter"), "-"),
    ]


def needed_works(params: Params, inputs: Tables) -> list[Row]:
    """Return works of adhesion, J/m2, that give another pair its capture velocity by each law.

    By JKR the bulk is elastic; by hysteresis the contact does not pull while it closes. Both
    capture velocities go with the power 5/6 of the work. Of the ring force it is that of the case.
    """
    case, wanted = params.other_pair.case, params.other_pair.capture_velocity_m_per_s
    base = calibrated_contact(inputs, case)
    alone = {
        "JKR, elastic": base.by_law(JKR(), 1.0),
        "hysteresis": base.by_law(Hysteresis(unloading_work=1.0), 0.0),
    }
    works = {"ring force": np.asarray(base.work_of_adhesion)} | {
        name: (wanted / capture_velocity(contact)) ** 1.2 for name, contact in alone.items()
    }
    return [_row(name, case, WORK, float(work), UNITS[WORK]) for name, work in works.items()]


def facts_of(params: Params, fit: Fit) -> pd.DataFrame:
    """Return the values of a fitted law for every fact and criterion, and which it meets."""
    contact, asked = fit.contact, params.criteria
    limit = float(capture_velocity(contact))
    speed, value, error = printed(params)
    fastest = float(speed.max())
    plateau = np.geomspace(params.plateau_speed_m_per_s, fastest, 20)
    e, flat, slow = (
        normal_impact(contact, v).coefficient_of_restitution
        for v in (speed, plateau, asked.fall_speed_m_per_s)
    )
    fall = 1.0 - slow / flat[-1]
    small, large = (
        capture_velocity(resized(contact, d * 1e-6)) for d in asked.compared_diameters_um
    )
    shares = {f"{ratio:g} v_c": ratio * limit for ratio in asked.share_speeds_in_v_c}
    times, (shortest, longest) = durations(params, contact), asked.durations_ns
    bases = ("compressive",) if contact.law is None else ("compressive", PULL_OFF)
    off, v_c = params.capture_velocity_error_m_per_s, params.capture_velocity_m_per_s
    facts = [
        *(
            (f"restitution, {fact}", "-", "-", *numbers)
            for fact, *numbers in zip(params.facts, e, value - error, value + error, strict=True)
        ),
        ("relative change above the plateau speed", "C05", "-",
         np.max(np.abs(flat / flat[-1] - 1.0)), 0.0, asked.about),
        ("relative fall at a low speed", "C05", "-", fall, asked.about, 1.0),
        ("capture velocity", "C36", "m/s", limit, v_c - off, v_c + off),
        ("capture velocity of large over small", "C07", "-", large / small, 0.0, 0.999),
        ("elasticity of v_c to work of adhesion", "C57", "-",
         _elasticity(contact, "work_of_adhesion"), 0.001, math.inf),
        ("elasticity of v_c to diameter", "C57", "-",
         _elasticity(contact, "diameter"), -math.inf, -0.001),
        *(
            (f"adhesion's share of the loss at {words}", "C27", "-",
             losses(contact, v).adhesion_share, 0.0, asked.negligible_share)
            for words, v in shares.items()
        ),
        ("adhesion's share of the loss at normal incidence", "C70", "-",
         losses(contact, fastest).adhesion_share, 0.5, 1.0),
        ("shortest contact", "C37", "ns", times.min(), shortest, math.inf),
        ("longest contact", "C37", "ns", times.max(), 0.0, longest),
        *(
            (f"rise of the impulse ratio, {basis} force", "C23", "-",
             rise(contact, fastest, asked.plateau_angle_deg, basis), 1.001, math.inf)
            for basis in bases
        ),
    ]  # fmt: skip
    table = pd.DataFrame(facts, columns=["fact", "claim", "unit", "value", "low", "high"])
    table["value"] = table["value"].astype(float)
    met = table["value"].between(table["low"], table["high"])
    table = table.assign(law=fit.law, targets=fit.targets, met=np.where(met, "yes", "no"))
    return table[["law", "targets", "fact", "claim", "value", "unit", "low", "high", "met"]]


def _elasticity(contact: Contact, name: str) -> float:
    """Logarithmic derivative of the capture velocity; works of adhesion change together."""
    ends = []
    for factor in (1.0 - STEP, 1.0 + STEP):
        if name == "diameter":
            changed = resized(contact, contact.diameter * factor)
        else:
            law = contact.law
            if isinstance(law, Hysteresis):
                law = Hysteresis(unloading_work=law.unloading_work * factor)
            changed = contact.replace(work_of_adhesion=contact.work_of_adhesion * factor, law=law)  # type: ignore[operator]
        ends.append(float(capture_velocity(changed)))
    return math.log(ends[1] / ends[0]) / math.log((1.0 + STEP) / (1.0 - STEP))


def durations(params: Params, contact: Contact) -> FloatArray:
    """Contact times in ns of all rebounds over the sizes and speeds of the criterion."""
    asked = params.criteria
    spheres = [resized(contact, diameter * 1e-6) for diameter in asked.diameters_um]
    speed = np.array(asked.duration_speeds_m_per_s)
    times = np.concatenate([normal_impact(of, speed).contact_time for of in spheres]) * 1e9
    return np.asarray(times[np.isfinite(times)])


def rise(contact: Contact, speed: float, plateau_angle: float, basis: str) -> float:
    """Impulse ratio at the shallowest angle of a rebound over that at the plateau's end."""
    angle = np.arange(ANGLE_STEP, plateau_angle + 0.5 * ANGLE_STEP, ANGLE_STEP)
    impact = simulate(contact, speed, angle, friction_basis=basis)
    shallowest = int(np.argmin(impact.captured))
    return float(impact.impulse_ratio[shallowest] / impact.impulse_ratio[-1])


def by_claim(facts: pd.DataFrame) -> pd.DataFrame:
    """Return, per fact and targets, which laws meet it, and whether that hangs on the law."""
    rows = []
    for (targets, claim, fact), part in facts.groupby(["targets", "claim", "fact"], sort=False):
        met, rest = (part.loc[part["met"] == word, "law"].tolist() for word in ("yes", "no"))
        row: Row = {"targets": targets, "claim": claim, "fact": fact}
        row |= {"met_by": "; ".join(met) or "none", "not_met_by": "; ".join(rest) or "none"}
        rows.append(row | {"hangs_on_the_law": "yes" if met and rest else "no"})
    return pd.DataFrame(rows)


def curves(params: Params, fits: list[Fit]) -> pd.DataFrame:
    """Return restitution against normal speed of every fit, and the printed facts."""
    frames = []
    speed = np.geomspace(SLOWEST_DRAWN, FASTEST_DRAWN, params.drawn_points)
    for fit in fits:
        limit = float(capture_velocity(fit.contact))
        grid = np.union1d(speed, [limit]) if math.isfinite(limit) else speed
        e = normal_impact(fit.contact, grid).coefficient_of_restitution
        e = np.where(grid > limit, e, 0.0)
        frames.append(_frame(fit.targets, fit.law, grid, e, "calibrated"))
    speed, value, error = printed(params)
    ends, limit = (value - error, value + error), params.capture_velocity_m_per_s
    for targets in TARGETS:
        frames += [
            _frame(targets, "printed restitution", speed, value, "printed", *ends),
            _frame(targets, "printed capture velocity", limit, 0.0, "printed"),
        ]
    return pd.concat(frames, ignore_index=True)
