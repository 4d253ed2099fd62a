"""Stated errors of tracks that the virtual laboratory renders, which are reduced and fitted.

    python -m benchmarks.reduction [--impacts 200] [--sets 100] > docs/reduction.csv
    python -m benchmarks.reduction --tracks > docs/examples/tracks.csv

A camera takes a frame of each pulse of light; the place of the sphere is the centroid of its spot.
In each cell impacts of one size, angle and noise have a known e, and each a wall of its own tilt
(quantiles of the normal distribution in any order: chance moves the bias of 200 by 0.02 sigma then,
and the shares by 0.03).
In the last row each set has 24 impacts of 0.2 to 1.6 m/s by the ring force, and goes through
`reduce_tracks`, `read_rebounds` and `compare_models`: the share of intervals of 95 % that hold the
capture velocity.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import scipy
from numpy.random import Generator

from microimpact import capture_velocity, compare_models, contacts, read_rebounds, simulate
from microimpact.core.arrays import FloatArray
from microimpact.lab.events import Impacts
from microimpact.lab.ptis.exposure import LATER, LEGS, exposures
from microimpact.lab.ptis.frames import light_of, photograph
from microimpact.lab.ptis.system import ImagingSystem, Setup, Systematics
from microimpact.lab.ptis.tracks import find_spots
from microimpact.lab.records import Reduced, reduce_tracks

CAMERA = ImagingSystem(
    frame_px=(640, 480),
    pixel_um=10.0,
    fields_per_s=4.0,  # of time enough for both legs
    sheet_thickness_mm=1.0,
    slots=10,
    duty=0.5,
    largest_chop_kHz=10.0,
    dash_pitch_mm=0.3,
    jitter=0.002,
    blur_px=1.0,
    background_counts=20.0,
    least_peak_counts=120.0,
    largest_peak_counts=250.0,
    read_noise_counts=4.0,
    electrons_per_count=100.0,
    rate_error=0.0,
    scale_error=0.0,
    angle_error_deg=0.25,
    least_dashes=3,
)
SIZES_UM, ANGLES, NOISES = (30.0, 62.0, 150.0), (50.0, 80.0), (4.0, 16.0)
SPEED, RESTITUTION, KEPT = 1.0, 0.6, 0.8
CHAIN_ANGLE, CHAIN_IMPACTS, SLOWEST, FASTEST = 80.0, 24, 0.2, 1.6
SEED = 20430
MADE = """\
# Made by the virtual laboratory: python -m benchmarks.reduction --tracks > docs/examples/tracks.csv
# 24 spheres of stainless steel, 62 um, 0.2 to 1.6 m/s, on silicon at 80 degrees (the ring force of
# config/contacts.csv); a frame per pulse of light, 10 um per pixel; the wall at -10 degrees in the
# picture, with a tilt of its own for each sphere, of 0.25 degrees standard deviation.
"""
HEADER = ("diameter_um", "angle_deg", "noise_counts", "impacts", "left_out", "e_bias_over_sigma",
          "e_within_sigma", "v_bias_over_sigma", "v_within_sigma", "v_c_held", "sets")  # fmt: skip


def impact(d: float, v: FloatArray, angle: float, e: FloatArray, rng: Generator) -> Impacts:
    """Vertical falls of spheres on a wall, without spin."""
    n, alpha = v.size, np.radians(angle)
    before = v[:, None] * np.array([np.cos(alpha), 0.0, -np.sin(alpha)])
    after = np.stack([KEPT * before[:, 0], 0.0 * v, -e * before[:, 2]], axis=-1)
    return Impacts(
        time=np.zeros(n),
        diameter=np.full(n, d),
        position=np.stack([1e-3 * rng.uniform(-0.5, 0.5, n), np.zeros(n)], axis=-1),
        velocity=before,
        spin=np.zeros((n, 3)),
        rebound_velocity=after,
        rebound_spin=np.zeros((n, 3)),
        captured=e == 0.0,
        contacts=np.ones(n, dtype=np.int64),
    )


def filmed(
    impacts: Impacts, i: int, setup: Setup, errors: Systematics, rng: Generator
) -> FloatArray:
    """Frame number, column and row of the sphere in each frame that shows it whole, (m, 3)."""
    exposure = exposures(impacts.select(slice(i, i + 1)), setup, errors, [rng])
    pulse = exposure.start * setup.chop_rate
    # Pulses open at one phase, up to their jitter; a piece after the impact begins within one.
    phase = np.median(np.mod(pulse[exposure.whole] + 0.5 - pulse[exposure.whole][0], 1.0)) - 0.5
    frame = np.floor(pulse - pulse[exposure.whole][0] - phase + 0.1).astype(int)
    flying = exposure.in_view & (exposure.leg % LEGS < LATER)
    places = []
    for number in np.unique(frame[flying]).tolist():
        shown = (frame == number) & (exposure.end > exposure.start)
        parts = "leg", "start", "end", "whole", "in_sheet", "in_view", "in_field"
        alone = replace(exposure, **{name: getattr(exposure, name)[shown] for name in parts})
        picture = photograph(light_of(alone, setup, errors), setup.instrument, rng)
        spots = find_spots(picture, setup)
        if len(spots.light) == 1 and spots.clear[0] and not spots.saturated[0]:
            places.append((number, *spots.centroid[0]))
    return np.array(places).reshape(-1, 3)


def film(
    d: float, v: FloatArray, angle: float, e: FloatArray, camera: ImagingSystem, rng: Generator
) -> Iterator[tuple[int, FloatArray]]:
    """Points of each impact: time, s, and horizontal and vertical place, m, (m, 3)."""
    impacts = impact(d, v, angle, e, rng)
    tilts = rng.permutation(scipy.special.ndtri((np.arange(v.size) + 0.5) / v.size))
    for i in range(v.size):
        setup = Setup(instrument=camera, angle=angle, speed=float(v[i]), diameter=d)
        tilted = Systematics(angle_deg=camera.angle_error_deg * float(tilts[i]))
        frame, column, row = filmed(impacts, i, setup, tilted, rng).T
        yield i, np.stack([frame / setup.chop_rate, column * setup.pixel, -row * setup.pixel], -1)


def reduced(
    d: float, v: FloatArray, angle: float, e: FloatArray, camera: ImagingSystem, rng: Generator
) -> Reduced:
    """Rebounds of impacts that are filmed."""
    films = dict(film(d, v, angle, e, camera, rng))
    track = [i for i, points in films.items() for _ in points]
    points = np.concatenate([*films.values()])
    return reduce_tracks(
        *points.T, track, wall=angle - 90.0, diameter=d, tilt=camera.angle_error_deg
    )


def cell(d: float, angle: float, noise: float, number: int, rng: Generator) -> tuple[object, ...]:
    """A row: bias over the mean sigma, and coverage of one sigma, of e and of v."""
    camera = replace(CAMERA, read_noise_counts=noise)
    v = SPEED * rng.uniform(0.9, 1.1, number)
    found = reduced(d, v, angle, np.full(number, RESTITUTION), camera, rng)
    good = found.select(found.used)
    sine = np.sin(np.radians(good.angle))
    which = np.array([int(str(name)) for name in good.track])
    off = good.e - RESTITUTION, good.v * sine - v[which] * np.sin(np.radians(angle))
    row: list[object] = [round(1e6 * d), angle, noise, len(good), int(np.sum(~found.used))]
    for each, sigma in zip(off, (good.sigma, good.sigma_v * sine), strict=True):
        row += [f"{each.mean() / sigma.mean():.3f}", f"{np.mean(np.abs(each) < sigma):.3f}"]
    return (*row, "", "")


def chain(sets: int, rng: Generator) -> tuple[object, ...]:
    """The row of capture velocities."""
    contact = contacts["stainless-steel-316 on silicon"]
    d, v_c = float(contact.diameter), float(capture_velocity(contact))
    held = lost = used = 0
    for _ in range(sets):
        v = np.geomspace(SLOWEST, FASTEST, CHAIN_IMPACTS)
        e = simulate(contact, v, CHAIN_ANGLE).coefficient_of_restitution
        found = reduced(d, v, CHAIN_ANGLE, np.asarray(e), CAMERA, rng)
        low, high = compare_models(**read_rebounds(found.columns)).v_c_interval
        held += low <= v_c <= high
        lost, used = lost + int(np.sum(~found.used)), used + int(np.sum(found.used))
        print(f"{low:.4f} {v_c:.4f} {high:.4f}", file=sys.stderr)
    size = round(1e6 * d)
    return (size, CHAIN_ANGLE, CAMERA.read_noise_counts, used, lost, *([""] * 4), held, sets)


def tracks(rng: Generator) -> Iterator[tuple[object, ...]]:
    """Rows of a file of tracks, as of a set of the chain."""
    contact = contacts["stainless-steel-316 on silicon"]
    v = np.geomspace(SLOWEST, FASTEST, CHAIN_IMPACTS)
    e = np.asarray(simulate(contact, v, CHAIN_ANGLE).coefficient_of_restitution)
    yield "track", "t (ms)", "x (px)", "y (px)"
    pixel = 1e-6 * CAMERA.pixel_um
    for i, points in film(float(contact.diameter), v, CHAIN_ANGLE, e, CAMERA, rng):
        for t, x, y in points:
            yield i + 1, f"{1e3 * t:.4f}", f"{x / pixel:.3f}", f"{-y / pixel:.3f}"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.reduction", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--impacts", type=int, default=200, help="of a cell")
    parser.add_argument("--sets", type=int, default=100, help="that are fitted")
    parser.add_argument("--tracks", action="store_true", help="write a file of tracks instead")
    options = parser.parse_args(arguments)
    table = csv.writer(sys.stdout, lineterminator="\n")
    if options.tracks:
        sys.stdout.write(MADE)
        table.writerows(tracks(np.random.default_rng(SEED)))
        return
    table.writerow(HEADER)
    seeds = np.random.SeedSequence(SEED).spawn(1 + len(SIZES_UM) * len(ANGLES) * len(NOISES))
    for seed, (size, angle, noise) in zip(seeds, product(SIZES_UM, ANGLES, NOISES), strict=False):
        if not options.impacts:
            break
        rng = np.random.default_rng(seed)
        table.writerow(cell(1e-6 * size, angle, noise, options.impacts, rng))
        sys.stdout.flush()
    if options.sets:
        table.writerow(chain(options.sets, np.random.default_rng(seeds[-1])))


if __name__ == "__main__":
    main()
