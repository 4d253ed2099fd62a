"""What the particle trajectory imaging system can measure, and how well (Section 2.1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.declared.parameters import Count, Fraction, Keyed, Positive
from microimpact.lab.ptis.frames import render
from microimpact.lab.ptis.observation import Observation, modelled, observe
from microimpact.lab.ptis.system import (
    Instrument,
    Setup,
    Systematics,
    draw_systematics,
    event_generator,
)
from microimpact.lab.ptis.tracks import Rejection, measure
from microimpact.statistics.distributions import generator
from microimpact.studies.experiments.track_imaging.agreement import (
    Tolerances,
    compared,
    residual_rows,
    verdicts,
)
from microimpact.studies.experiments.track_imaging.frame import drawn_track, pixels
from microimpact.studies.experiments.track_imaging.impacts import (
    LEGS,
    Particles,
    impacts,
    speed_and_angle_errors,
    true_velocities,
    velocities,
)

Angle = Annotated[float, Field(gt=0, lt=90)]
RANGE, ERRORS, FRAME = range(3)
FRAMES, MODEL = "frames", "model"


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Speed and angle of incidence."""

    speed_m_per_s: Positive
    angle_deg: Angle


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Ranges that are searched, and what counts as measurable.

    A field of view covers a speed if at least `least_observed` of the events show enough dashes in
    both legs and the mean speed is off by at most `largest_bias`. The chopper is set to each of
    `dash_pitches_px` and the best is taken. Frames are rendered for the best field of view at
    `drawn_angle_deg`.
    """

    seed: Annotated[int, Field(ge=0)]
    particles: Particles
    instrument: Instrument
    speeds_m_per_s: tuple[Positive, ...]
    angles_deg: tuple[Angle, ...]
    pixels_um: tuple[Positive, ...]
    dash_pitches_px: tuple[Positive, ...]
    modelled_events: Annotated[int, Field(ge=2)]
    rendered_events: Annotated[int, Field(ge=2)]
    least_observed: Fraction
    largest_bias: Fraction
    drawn_angle_deg: Angle
    error_cases: Annotated[tuple[Case, ...], Keyed()]
    experiments: Count
    events: Annotated[int, Field(ge=2)]
    tolerances: Tolerances
    frame: Case
    frame_dash_pitch_px: Positive

    def __post_init__(self) -> None:
        """Refuse an angle of the figure that is not computed."""
        if self.drawn_angle_deg not in self.angles_deg:
            raise ValueError(
                f"drawn_angle_deg {self.drawn_angle_deg:g} must be one of angles_deg "
                f"{', '.join(f'{angle:g}' for angle in self.angles_deg)}"
            )


def run(params: Params, inputs: Mapping[str, pd.DataFrame]) -> Mapping[str, pd.DataFrame]:
    """Search the range of the instrument, and compare frames, error model and truth.

    Parameters
    ----------
    params
        Parameters of the study.
    inputs
        Not used.

    Returns
    -------
    mapping
        ``ptis_range``: per speed, angle and field of view, the chopper's setting, share observed,
        bias and scatter. ``ptis_views``: which speeds each field of view covers. ``ptis_errors``:
        residuals of frames in units of the error model. ``ptis_agreement``: whether the error model
        agrees with the frames. ``ptis_losses``: fates of events.
        ``ptis_frame``, ``ptis_pixels``: one frame with its track. ``ptis_accuracy``: errors of the
        speed against the speed.

    Raises
    ------
    ValueError
        If nothing can be measured at the angle drawn, or in the frame.
    """
    searched = pd.DataFrame(search(params))
    rendered, lost = rendered_range(params, searched)
    ranges = pd.concat([searched, rendered], ignore_index=True)
    errors, agreement, fates = error_cases(params)
    frame, track = one_frame(params)
    return {
        "ptis_range": ranges,
        "ptis_views": views(params, searched),
        "ptis_errors": errors,
        "ptis_agreement": agreement,
        "ptis_losses": pd.concat([lost, fates], ignore_index=True),
        "ptis_frame": track,
        "ptis_pixels": frame,
        "ptis_accuracy": accuracy(params, ranges),
    }


def search(params: Params) -> Iterator[dict[str, Any]]:
    """Yield a row per angle, speed and field of view: the best setting of the chopper."""
    for angle in params.angles_deg:
        for speed in params.speeds_m_per_s:
            for pixel in params.pixels_um:
                settings = [_setup(params, speed, angle, pixel, p) for p in params.dash_pitches_px]
                rows = [_row(params, setup, MODEL, params.modelled_events) for setup in settings]
                yield max(rows, key=lambda row: float(row["fraction_observed"]))


def _setup(params: Params, speed: float, angle: float, pixel: float, pitch: float) -> Setup:
    instrument = replace(params.instrument, pixel_um=pixel, dash_pitch_mm=pitch * pixel * 1e-3)
    diameter = params.particles.diameter_um * 1e-6
    return Setup(instrument=instrument, angle=angle, speed=speed, diameter=diameter)


def _row(
    params: Params, setup: Setup, method: str, events: int, *, with_gravity: bool = True
) -> dict[str, Any]:
    return _summary(params, setup, method, *_observed(params, setup, method, events, with_gravity))


def _observed(
    params: Params, setup: Setup, method: str, events: int, with_gravity: bool = True
) -> tuple[Observation, FloatArray]:
    """Observe without systematic errors, which would look like a bias of the reduction."""
    speed, angle = setup.speed, setup.angle
    key = [RANGE, params.speeds_m_per_s.index(speed), params.angles_deg.index(angle)]
    true = impacts(params.particles, events, speed, angle, generator(params.seed, *key, 0))
    rng = generator(params.seed, *key, 1)
    if method == MODEL:
        return modelled(true, setup, rng, errors=Systematics()), true_velocities(true)
    seen = observe(true, setup, rng, errors=Systematics(), with_gravity=with_gravity)
    return seen, true_velocities(true)


def _summary(
    params: Params, setup: Setup, method: str, observation: Observation, true: FloatArray
) -> dict[str, Any]:
    measured = observation.measured
    width, height = setup.instrument.frame_px
    row: dict[str, Any] = {
        "speed_m_per_s": setup.speed,
        "angle_deg": setup.angle,
        "pixel_um": setup.instrument.pixel_um,
        "view_width_mm": width * setup.pixel * 1e3,
        "view_height_mm": height * setup.pixel * 1e3,
        "dash_pitch_px": setup.speed / setup.chop_rate / setup.pixel,
        "chop_per_s": setup.chop_rate,
        "disk_rev_per_min": setup.disk_speed,
        "pulses_per_field": setup.chop_rate / setup.instrument.fields_per_s,
        "fall_height_mm": setup.speed**2 / (2.0 * np.linalg.norm(setup.gravity)) * 1e3,
        "method": method,
        "events": len(true),
        "fraction_observed": len(measured) / len(true),
    }
    errors = speed_and_angle_errors(velocities(measured), true[measured.event])
    for k, leg in enumerate(LEGS):
        for error, name in zip(errors, ("speed_error", "direction_error_deg"), strict=True):
            of = error[:, k]
            row[f"{leg}_{name}"] = float(np.mean(of)) if of.size else np.nan
            row[f"{leg}_{name}_sd"] = float(np.std(of, ddof=1)) if of.size > 1 else np.nan
    bias = max(abs(row[f"{leg}_speed_error"]) for leg in LEGS)
    enough = row["fraction_observed"] >= params.least_observed
    return {**row, "covered": bool(enough and bias <= params.largest_bias)}


def rendered_range(params: Params, searched: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return rows by frames at the angle drawn, at the best field of view of every speed.

    And the losses.
    """
    rows, lost = [], []
    drawn = searched[searched["angle_deg"] == params.drawn_angle_deg]
    for _, group in drawn.groupby("speed_m_per_s", sort=False):
        best = group.sort_values("fraction_observed", ascending=False, kind="stable").iloc[0]
        if best["fraction_observed"] == 0.0:
            continue
        names = ["speed_m_per_s", "angle_deg", "pixel_um", "dash_pitch_px"]
        setup = _setup(params, *(float(best[name]) for name in names))
        seen = _observed(params, setup, FRAMES, params.rendered_events)
        rows.append(_summary(params, setup, FRAMES, *seen))
        lost.append(_fates(setup, FRAMES, seen[0].fates))
        straight = _row(params, setup, FRAMES, params.rendered_events, with_gravity=False)
        rows.append({**straight, "method": "straight lines"})
    if not rows:
        raise ValueError(
            f"drawn_angle_deg: at {params.drawn_angle_deg:g} deg no speed is measurable"
        )
    return pd.DataFrame(rows), pd.concat(lost, ignore_index=True)


def _fates(setup: Setup, method: str, fates: tuple[str, ...]) -> pd.DataFrame:
    found = pd.Series(fates).value_counts().sort_index()
    return pd.DataFrame(
        {
            "speed_m_per_s": setup.speed,
            "angle_deg": setup.angle,
            "pixel_um": setup.instrument.pixel_um,
            "method": method,
            "fate": found.index,
            "events": found.to_numpy(),
            "fraction": found.to_numpy() / len(fates),
        }
    )


def views(params: Params, searched: pd.DataFrame) -> pd.DataFrame:
    """Return which of the speeds each field of view covers, and whether one covers them all."""
    rows = []
    for (pixel, angle), group in searched.groupby(["pixel_um", "angle_deg"]):
        covered = group.loc[group["covered"], "speed_m_per_s"]
        rows.append(
            {
                "pixel_um": pixel,
                "view_width_mm": group["view_width_mm"].iloc[0],
                "view_height_mm": group["view_height_mm"].iloc[0],
                "angle_deg": angle,
                "speeds_covered": len(covered),
                "lowest_m_per_s": covered.min(),
                "highest_m_per_s": covered.max(),
                "covers_range": len(covered) == len(params.speeds_m_per_s),
            }
        )
    return pd.DataFrame(rows)


def error_cases(params: Params) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """Compare frames with the error model, event by event, over whole experiments.

    Returns
    -------
    tuple
        Residuals per case, verdicts over all, and fates of the events.
    """
    cases, lost = [], []
    for number, case in enumerate(params.error_cases):
        setup = Setup(
            instrument=params.instrument,
            angle=case.angle_deg,
            speed=case.speed_m_per_s,
            diameter=params.particles.diameter_um * 1e-6,
        )
        experiments = []
        for experiment in range(params.experiments):
            key = ERRORS, number, experiment
            drawn = generator(params.seed, *key, 0)
            true = impacts(params.particles, params.events, setup.speed, setup.angle, drawn)
            experiments.append(compared(true, setup, generator(params.seed, *key, 1)))
        cases.append((setup, experiments))
        for method in (FRAMES, MODEL):
            fates = [fate for one in experiments for fate in getattr(one, method).fates]
            lost.append(_fates(setup, method, tuple(fates)))
    return (
        pd.DataFrame([row for case in cases for row in residual_rows(*case)]),
        pd.DataFrame(verdicts(cases, params.tolerances)),
        pd.concat(lost, ignore_index=True),
    )


def one_frame(params: Params) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the pixels and the track of the first frame that is measured.

    Raises
    ------
    ValueError
        If none of an experiment is.
    """
    case, pixel = params.frame, params.instrument.pixel_um
    pitch = params.frame_dash_pitch_px
    setup = _setup(params, case.speed_m_per_s, case.angle_deg, pixel, pitch)
    true = impacts(
        params.particles, params.events, setup.speed, setup.angle, generator(params.seed, FRAME, 0)
    )
    rng = generator(params.seed, FRAME, 1)
    errors = draw_systematics(setup.instrument, rng)
    for i in range(len(true)):
        frame = render(true, i, setup, errors, event_generator(rng, i))
        track = measure(frame, setup)
        if not isinstance(track, Rejection):
            return pixels(frame, track, setup), drawn_track(track, setup)
    raise ValueError(f"frame: none of {len(true)} frames at {case} could be measured")


def accuracy(params: Params, ranges: pd.DataFrame) -> pd.DataFrame:
    """Return the error of the speed against the speed at one angle, per leg."""
    rows = ranges[ranges["angle_deg"] == params.drawn_angle_deg]
    series = (
        (FRAMES, "path under gravity", "virtual experiment"),
        ("straight lines", "straight line", "virtual experiment"),
        (MODEL, "error model", "computed"),
    )
    rendered = rows.loc[rows["method"] == FRAMES, ["speed_m_per_s", "pixel_um"]]
    frames = []
    for leg in LEGS:
        for method, name, evidence in series:
            own = rows[rows["method"] == method].merge(rendered).sort_values("speed_m_per_s")
            mean, sd = (100.0 * own[f"{leg}_speed_error{end}"] for end in ("", "_sd"))
            frames.append(
                series_frame(
                    panel=leg,
                    series=name,
                    evidence=evidence,
                    x=own["speed_m_per_s"],
                    y=mean,
                    y_low=(mean - sd).to_numpy(),
                    y_high=(mean + sd).to_numpy(),
                    x_unit="m_per_s",
                    y_unit="percent",
                )
            )
    return pd.concat(frames, ignore_index=True)
