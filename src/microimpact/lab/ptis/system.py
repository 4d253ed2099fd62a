"""Particle trajectory imaging system: its settings, its geometry and its errors.

A chopped laser sheet, vertical and through the normal of the target, lights a falling sphere in
pulses; a camera across the sheet records a row of dashes towards the surface and one away from it
(Section 2.1). Its image axes are horizontal and vertical in the laboratory. `exposure` says what is
lit; `frames` draw it and `tracks` measure them; `errors` tell what is measured without frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le
from numpy.random import Generator

from microimpact.core.arrays import FloatArray
from microimpact.core.bounds import Count, NonNegative, OpenShare, Positive
from microimpact.core.constants import gravity
from microimpact.statistics.distributions import child

# Where in the frame the impacts lie: as a share of its width, and of its height from the bottom
# for tracks that turn down and for a track straight up.
AIM_ACROSS, AIM_MIDDLE, AIM_BOTTOM = 0.35, 0.5, 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class ImagingSystem:
    """Settings of chopper, light sheet and camera; noise as standard deviations.

    Attributes
    ----------
    frame_px
        Columns and rows of the camera.
    pixel_um
        Size of a pixel at the target; with `frame_px` the field of view.
    fields_per_s
        A field is exposed for the whole of its time.
    sheet_thickness_mm
        Of the light sheet; a sphere whose centre is outside it is dark.
    slots, duty
        Slots of the chopper disk, and share of a period in which light passes.
    largest_chop_kHz, dash_pitch_mm
        The chopper gives dashes at this pitch on the incident track, as far as its largest rate
        allows.
    jitter
        Of the time of each pulse, as a share of the period.
    blur_px
        Standard deviation of the Gaussian with which the image of a sphere is blurred.
    background_counts, least_peak_counts, largest_peak_counts
        Grey levels: of the dark frame, and range of the brightest dash of a track.
    read_noise_counts, electrons_per_count
        Noise of a pixel without light, and the scale that sets the shot noise.
    rate_error, scale_error, angle_error_deg
        Errors of the chopper's rate and of the magnification, relative, and of the angle between
        target and camera, each drawn once per experiment.
    least_dashes
        Whole dashes that a leg of a track must have.
    """

    frame_px: tuple[Count, Count]
    pixel_um: Positive
    fields_per_s: Positive
    sheet_thickness_mm: Positive
    slots: Count
    duty: OpenShare
    largest_chop_kHz: Positive  # noqa: N815 (the unit)
    dash_pitch_mm: Positive
    jitter: NonNegative
    blur_px: Positive
    background_counts: NonNegative
    least_peak_counts: Annotated[float, Gt(0), Le(255)]
    largest_peak_counts: Annotated[float, Gt(0), Le(255)]
    read_noise_counts: NonNegative
    electrons_per_count: Positive
    rate_error: NonNegative
    scale_error: NonNegative
    angle_error_deg: NonNegative
    least_dashes: Annotated[int, Ge(3)]

    def __post_init__(self) -> None:
        """Refuse grey levels that are not in order."""
        levels = self.background_counts, self.least_peak_counts, self.largest_peak_counts
        if not levels[0] < levels[1] <= levels[2]:
            raise ValueError(
                "background_counts, least_peak_counts, largest_peak_counts must ascend, got "
                + ", ".join(f"{level:g}" for level in levels)
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """The instrument as set for one experiment; the only input of its reduction.

    Attributes
    ----------
    instrument
        Settings.
    angle
        Nominal angle of incidence from the surface, degrees, in (0, 90).
    speed
        Nominal speed of the particles at the target, m/s; it sets the chopper.
    diameter
        Nominal diameter, m: the centre of a sphere meets the surface at half of it.
    """

    instrument: ImagingSystem
    angle: float
    speed: float
    diameter: float

    def __post_init__(self) -> None:
        """Refuse settings that cannot be imaged."""
        if self.angle == 90.0:
            raise ValueError(
                "angle: at 90 deg incident and rebound tracks lie on each other and cannot be "
                "imaged; measure normal impacts by phase Doppler (lab.pdpa)"
            )
        if not 0.0 < self.angle < 90.0:
            raise ValueError(f"angle must be in (0, 90) deg, got {self.angle:g}")
        for name in ("speed", "diameter"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be finite and > 0, got {value:g}")

    @property
    def chop_rate(self) -> float:
        """Nominal rate of the pulses, 1/s."""
        wanted = self.speed / (self.instrument.dash_pitch_mm * 1e-3)
        return min(self.instrument.largest_chop_kHz * 1e3, wanted)

    @property
    def disk_speed(self) -> float:
        """Of the chopper, revolutions per minute."""
        return 60.0 * self.chop_rate / self.instrument.slots

    @property
    def pixel(self) -> float:
        """Nominal size of a pixel at the target, m."""
        return self.instrument.pixel_um * 1e-6

    @property
    def centre(self) -> FloatArray:
        """Where the origin of the target's frame is imaged: column and row.

        The camera is aimed to give both legs room: lower in the frame the more steeply a sphere
        would leave by reflection, ``-cos(2 alpha)`` upwards.
        """
        width, height = self.instrument.frame_px
        upwards = max(0.0, -np.cos(2.0 * np.radians(self.angle)))
        from_bottom = AIM_MIDDLE + (AIM_BOTTOM - AIM_MIDDLE) * upwards
        return np.array([AIM_ACROSS * width, (1.0 - from_bottom) * height])

    @property
    def gravity(self) -> FloatArray:
        """In the frame of the target, m/s2, shape (3,)."""
        alpha = np.radians(self.angle)
        return gravity * np.array([np.cos(alpha), 0.0, -np.sin(alpha)])

    def imaging(self, errors: Systematics) -> tuple[float, ...]:
        """Return where the origin is imaged, sine and cosine of the angle, and the pixel, m."""
        alpha = np.radians(self.angle - errors.angle_deg)
        pixel = self.pixel * (1.0 + errors.scale)
        return *self.centre.tolist(), float(np.sin(alpha)), float(np.cos(alpha)), pixel

    def columns_rows(self, position: FloatArray, errors: Systematics) -> FloatArray:
        """Return where points (..., 3) of the target's frame are imaged: (..., 2), pixels."""
        column, row, sine, cosine, pixel = self.imaging(errors)
        x, z = position[..., 0], position[..., 2]
        pixel_position = np.empty((*x.shape, 2))
        pixel_position[..., 0] = column + (x * sine + z * cosine) / pixel
        pixel_position[..., 1] = row + (x * cosine - z * sine) / pixel
        return pixel_position

    def height(self, pixel_position: FloatArray) -> FloatArray:
        """Return the height above the nominal surface line, px, of columns and rows (..., 2)."""
        alpha = np.radians(self.angle)
        away = pixel_position - self.centre
        height: FloatArray = away[..., 0] * np.cos(alpha) - away[..., 1] * np.sin(alpha)
        return height


@dataclass(frozen=True, slots=True, kw_only=True)
class Systematics:
    """Errors that all events of an experiment share.

    Attributes
    ----------
    rate, scale
        Relative errors: true over nominal rate of the chopper and size of a pixel, minus 1.
    angle_deg
        Nominal minus true angle between the target and the camera's axes, degrees.
    """

    rate: float = 0.0
    scale: float = 0.0
    angle_deg: float = 0.0


def draw_systematics(instrument: ImagingSystem, rng: Generator) -> Systematics:
    """Draw the errors of one experiment."""
    rate, scale, angle = child(rng, 0).standard_normal(3).tolist()
    return Systematics(
        rate=rate * instrument.rate_error,
        scale=scale * instrument.scale_error,
        angle_deg=angle * instrument.angle_error_deg,
    )


def event_generator(rng: Generator, event: int) -> Generator:
    """Return the generator of one event, by its number in the experiment."""
    return child(rng, 1, event)
