"""Range and errors of the particle trajectory imaging system (Section 2.1)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import Field

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.lab.events import Impacts
from microimpact.lab.ptis.experiment import ImagedEvents, modelled, photographed
from microimpact.lab.ptis.frames import render
from microimpact.lab.ptis.system import (
    ImagingSystem,
    Setup,
    Systematics,
    draw_systematics,
    event_generator,
)
from microimpact.lab.ptis.tracks import Track, measure
from microimpact.model.dynamics.impact import velocity_components
from microimpact.model.rigid_body.algebra import rigid_body_rebound
from microimpact.statistics.distributions import generator
from study.declared.parameters import (
    Count,
    Fraction,
    Must,
    NonNegative,
    ObliqueDegrees,
    Positive,
)
from study.tables import Tables, not_computed, reason, series_frame

LEGS = ("incident", "rebound")

# A speed can be measured, if slowly, with this share of the events observed, and up to this bias.
LEAST_OBSERVED, LARGEST_BIAS = 0.1, 0.02
# Dashes of each leg that are shown, room around them, px, and points of a fitted path.
SHOWN = 5
MARGIN_PX = 12
POINTS = 200
FRAME_PITCH = 25.0  # Between the dashes of the frame, px: several near the impact


@dataclass(frozen=True, slots=True, kw_only=True)
class RigidSpheres:
    """Spheres of one size that rebound by the rigid body rule, so that the truth is simple."""

    diameter_um: Positive  # Of all of them
    # Of the rigid body rule.
    restitution: Fraction
    friction: NonNegative
    # Standard deviations per horizontal axis.
    lateral_speed_m_per_s: NonNegative
    lateral_position_mm: NonNegative


def impacts(
    particles: RigidSpheres, n: int, speed: float, angle: float, rng: np.random.Generator
) -> Impacts:
    """Return n impacts at a speed in m/s and an angle of incidence in degrees."""
    alpha = np.radians(angle)
    v_n, v_t = velocity_components(speed, angle)
    lateral = particles.lateral_speed_m_per_s * rng.standard_normal((n, 2))
    position = 1e-3 * particles.lateral_position_mm * rng.standard_normal((n, 2))
    velocity = np.stack(
        [v_t + lateral[:, 0] * np.sin(alpha), lateral[:, 1], v_n + lateral[:, 0] * np.cos(alpha)],
        axis=1,
    )
    # Steered away from a nearly vertical target, a particle would never arrive.
    velocity[:, 2] = np.minimum(velocity[:, 2], 0.1 * v_n)
    along = np.hypot(velocity[:, 0], velocity[:, 1])
    radius = 0.5e-6 * particles.diameter_um
    rigid = rigid_body_rebound(
        velocity[:, 2], along, 0.0, radius, particles.restitution, particles.friction
    )
    after = velocity * (rigid.V_t / along)[:, None]
    after[:, 2] = rigid.V_n
    return Impacts(
        time=np.arange(n, dtype=float),
        diameter=np.full(n, 2.0 * radius),
        position=position / [np.sin(alpha), 1.0],
        velocity=velocity,
        spin=np.zeros((n, 3)),
        rebound_velocity=after,
        rebound_spin=np.zeros((n, 3)),
        captured=np.zeros(n, dtype=bool),
        contacts=np.ones(n, dtype=np.int64),
    )


def pixels(frame: NDArray[np.uint8], track: Track, setup: Setup) -> pd.DataFrame:
    """Return the grey levels around a track: one series per row, of the row's number."""
    left, top, right, bottom = window(track, setup)
    columns = np.arange(left, right)
    of_row = partial(
        series_frame, "pixels", evidence="virtual experiment", x_unit="px", y_unit="counts"
    )
    frames = [of_row(str(row), columns, frame[row, left:right]) for row in range(top, bottom)]
    return pd.concat(frames, ignore_index=True)


def window(track: Track, setup: Setup) -> tuple[int, int, int, int]:
    """Return the part of the frame around the impact: left, top, right, bottom."""
    near = np.concatenate([track.incident.points[-SHOWN:], track.rebound.points[:SHOWN]])
    contact = track.incident.at(np.array([track.incident.contact]))
    places = _places(np.concatenate([near, contact]), setup)
    low = np.maximum(np.floor(places.min(axis=0)) - MARGIN_PX, 0.0)
    high = np.minimum(np.ceil(places.max(axis=0)) + MARGIN_PX, setup.instrument.frame_px)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def drawn_track(track: Track, setup: Setup) -> pd.DataFrame:
    """Return centroids and fitted paths of both legs and the line of the surface, px."""
    *low, right, bottom = window(track, setup)

    def series(name: str, places: FloatArray, evidence: str = "virtual experiment") -> None:
        shown = places[np.all((places >= low) & (places < (right, bottom)), axis=1)]
        ends = shown[[0, -1]] if name == "surface" else shown
        x, y = ends.T
        frames.append(series_frame("frame", name, x, y, evidence, x_unit="px", y_unit="px"))

    frames: list[pd.DataFrame] = []
    for name, leg in (("incident", track.incident), ("rebound", track.rebound)):
        last = (len(leg.points) - 1) / setup.chop_rate
        contact = float(leg.contact)
        times = np.linspace(min(0.0, contact), max(last, contact), POINTS)
        series(f"{name} centroids", _places(leg.points, setup))
        series(f"{name} path", _places(leg.at(times), setup), "computed")
    # Points of the surface, along and below the horizontal: it is turned by 90 deg - alpha.
    alpha = np.radians(setup.angle)
    along = np.linspace(-1.0, 1.0, 2001) * np.hypot(*setup.instrument.frame_px)
    line = setup.centre + along[:, None] * [np.sin(alpha), np.cos(alpha)]
    series("surface", line, "computed")
    return pd.concat(frames, ignore_index=True)


def _places(points: FloatArray, setup: Setup) -> FloatArray:
    """Columns and rows of points in m from the image of the target's origin."""
    return setup.centre + points * [1.0, -1.0] / setup.pixel


# Places of the parts among the draws of the study.
RANGE, FRAME = 0, 2
FRAMES, STRAIGHT, MODEL = "frames", "straight lines", "model"
# Systematic errors would look like a bias of the reduction.
EXACT = Systematics()


@dataclass(frozen=True, slots=True, kw_only=True)
class Incidence:
    """Speed and angle of incidence."""

    speed_m_per_s: Positive
    angle_deg: ObliqueDegrees


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Ranges of speed, angle and field of view that are searched.

    A field of view covers a speed if at least `LEAST_OBSERVED` of the events show enough dashes in
    both legs and the mean speed is off by at most `LARGEST_BIAS`. The chopper is set to each of
    `dash_pitches_px` and the best is taken. Frames are rendered for the best field of view at
    `drawn_angle_deg`.
    """

    seed: Annotated[int, Field(ge=0)]
    particles: RigidSpheres
    instrument: ImagingSystem
    speeds_m_per_s: tuple[Positive, ...]
    angles_deg: tuple[ObliqueDegrees, ...]
    pixels_um: tuple[Positive, ...]
    dash_pitches_px: tuple[Positive, ...]
    modelled_events: Annotated[int, Field(ge=2)]
    rendered_events: Annotated[int, Field(ge=2)]
    drawn_angle_deg: Annotated[ObliqueDegrees, Must("one of", "angles_deg")]
    events: Count  # Impacts tried for the frame that is shown
    frame: Incidence


def run(params: Params, inputs: Tables) -> Tables:
    """Search the range of the instrument, and compare frames and error model with the truth.

    ``ptis_range``: per speed, angle and field of view, the chopper's setting, share observed, bias
    and scatter. ``ptis_frame``, ``ptis_pixels``: one frame with its track, or why none can be
    measured. ``ptis_accuracy``: errors of the speed against the speed. Raises NotComputable if
    nothing can be measured at the angle drawn.
    """
    searched = pd.DataFrame(search(params))
    rendered = pd.DataFrame(rendered_range(params, searched))
    ranges = pd.concat([searched, rendered], ignore_index=True)
    try:
        frame, track = one_frame(params)
    except NotComputable as error:
        frame = track = not_computed(reason("track_imaging", error))
    return {
        "ptis_range": ranges,
        "ptis_frame": track,
        "ptis_pixels": frame,
        "ptis_accuracy": accuracy(params, ranges),
    }


def search(params: Params) -> Iterator[dict[str, Any]]:
    """Yield a row per angle, speed and field of view: the best setting of the chopper."""
    for angle in params.angles_deg:
        for speed in params.speeds_m_per_s:
            true, rng = _arriving(params, speed, angle, params.modelled_events)
            for pixel in params.pixels_um:
                rows = []
                for pitch in params.dash_pitches_px:
                    setup = _setup(params, speed, angle, pixel, pitch)
                    draws = [event_generator(rng, i) for i in range(len(true))]
                    seen = modelled(true, setup, EXACT, draws)
                    rows.append(_summary(setup, MODEL, seen, true))
                yield max(rows, key=lambda row: float(row["fraction_observed"]))


def _setup(params: Params, speed: float, angle: float, pixel: float, pitch: float) -> Setup:
    instrument = replace(params.instrument, pixel_um=pixel, dash_pitch_mm=pitch * pixel * 1e-3)
    diameter = params.particles.diameter_um * 1e-6
    return Setup(instrument=instrument, angle=angle, speed=speed, diameter=diameter)


def _arriving(
    params: Params, speed: float, angle: float, events: int
) -> tuple[Impacts, np.random.Generator]:
    """Return impacts at a speed and an angle, and the generator by which they are observed."""
    key = [RANGE, params.speeds_m_per_s.index(speed), params.angles_deg.index(angle)]
    true = impacts(params.particles, events, speed, angle, generator(params.seed, *key, 0))
    return true, generator(params.seed, *key, 1)


def _summary(setup: Setup, method: str, observation: ImagedEvents, true: Impacts) -> dict[str, Any]:
    measured = observation.measured
    row: dict[str, Any] = {
        "speed_m_per_s": setup.speed,
        "angle_deg": setup.angle,
        "pixel_um": setup.instrument.pixel_um,
        "view_width_mm": setup.instrument.frame_px[0] * setup.pixel * 1e3,
        "dash_pitch_px": setup.speed / setup.chop_rate / setup.pixel,
        "chop_per_s": setup.chop_rate,
        "disk_rev_per_min": setup.disk_speed,
        "fall_height_mm": setup.speed**2 / (2.0 * np.linalg.norm(setup.gravity)) * 1e3,
        "method": method,
        "events": len(true),
        "fraction_observed": len(measured) / len(true),
    }
    exact = true.in_plane.velocities[measured.event]
    size, true_size = (np.linalg.norm(each, axis=2) for each in (measured.velocities, exact))
    for leg, error in zip(LEGS, (size / true_size - 1.0).T, strict=True):
        row[f"{leg}_speed_error"] = float(np.mean(error)) if error.size else np.nan
        row[f"{leg}_speed_error_sd"] = float(np.std(error, ddof=1)) if error.size > 1 else np.nan
    bias = max(abs(row[f"{leg}_speed_error"]) for leg in LEGS)
    enough = row["fraction_observed"] >= LEAST_OBSERVED
    return {**row, "covered": bool(enough and bias <= LARGEST_BIAS)}


def rendered_range(params: Params, searched: pd.DataFrame) -> list[dict[str, Any]]:
    """Return rows by frames at the angle drawn, at the best field of view of every speed."""
    rows = []
    drawn = searched[searched["angle_deg"] == params.drawn_angle_deg]
    best = drawn.loc[drawn.groupby("speed_m_per_s", sort=False)["fraction_observed"].idxmax()]
    names = ["speed_m_per_s", "angle_deg", "pixel_um", "dash_pitch_px"]
    for chosen in best.loc[best["fraction_observed"] > 0.0, names].to_numpy(float).tolist():
        setup = _setup(params, *chosen)
        true, rng = _arriving(params, setup.speed, setup.angle, params.rendered_events)
        frames = photographed(true, setup, EXACT, rng)
        for method, with_gravity in ((FRAMES, True), (STRAIGHT, False)):
            seen = frames.reduced(setup, with_gravity=with_gravity)
            rows.append(_summary(setup, method, seen, true))
    if not rows:
        raise NotComputable(
            f"drawn_angle_deg: at {params.drawn_angle_deg:g} deg no speed is measurable"
        )
    return rows


def one_frame(params: Params) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the pixels and the track of the first frame that is measured.

    Raises NotComputable if none of an experiment is.
    """
    case, pixel = params.frame, params.instrument.pixel_um
    setup = _setup(params, case.speed_m_per_s, case.angle_deg, pixel, FRAME_PITCH)
    true = impacts(
        params.particles, params.events, setup.speed, setup.angle, generator(params.seed, FRAME, 0)
    )
    rng = generator(params.seed, FRAME, 1)
    errors = draw_systematics(setup.instrument, rng)
    for i in range(len(true)):
        frame = render(true, i, setup, errors, event_generator(rng, i))
        track = measure(frame, setup)
        if track:
            return pixels(frame, track, setup), drawn_track(track, setup)
    where = f"{case.speed_m_per_s:g} m/s and {case.angle_deg:g} deg"
    raise NotComputable(f"frame: none of {len(true)} impacts at {where} can be measured")


def accuracy(params: Params, ranges: pd.DataFrame) -> pd.DataFrame:
    """Return the error of the speed against the speed at one angle, per leg."""
    rows = ranges[ranges["angle_deg"] == params.drawn_angle_deg]
    series = (
        (FRAMES, "path under gravity", "virtual experiment"),
        (STRAIGHT, "straight line", "virtual experiment"),
        (MODEL, "error model", "computed"),
    )
    rendered = rows.loc[rows["method"] == FRAMES, ["speed_m_per_s", "pixel_um"]]
    frames = []
    for leg in LEGS:
        for method, name, evidence in series:
            compared = rows[rows["method"] == method].merge(rendered).sort_values("speed_m_per_s")
            mean, sd = (100.0 * compared[f"{leg}_speed_error{end}"] for end in ("", "_sd"))
            points = compared["speed_m_per_s"], mean, evidence, mean - sd, mean + sd
            frames.append(series_frame(leg, name, *points, x_unit="m_per_s", y_unit="percent"))
    return pd.concat(frames, ignore_index=True)
