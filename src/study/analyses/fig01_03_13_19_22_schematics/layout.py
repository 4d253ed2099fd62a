"""Places of the parts of the two experimental set-ups on their drawings, in mm (Section 2.1).

The places are a layout and not measured; the directions, counts and tracks that a set-up has in
reality are handed in. A part is given by two corners of a box, or by points of an outline or line.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from microimpact.core.arrays import FloatArray

Parts = Mapping[str, FloatArray]

# Fig. 1: both views have the same places along the beam.
IMPACT = np.array([132.0, 22.0])
BEAM_SIDE, BEAM_TOP = 27.0, 29.0
LASER, COLLIMATOR, CHOPPER, LENS, FOCUS, SHEET_END = (
    (3.0, 33.0),
    (38.0, 53.0),
    62.5,
    78.0,
    84.0,
    168.0,
)
CELL = (94.0, 172.0)
DISK_RADIUS, SLOTS_FROM, SLOTS_TO, BEAM_ON_DISK = 9.0, 5.8, 9.4, 7.4
DISK_FACE = np.array([CHOPPER, 57.0])
HALF_BEAM = 1.5

# Fig. 2.
PROBE = np.array([94.0, 44.0])
HALF_PAIR = 6.0
SPLITTER, PAIR_LENS = (26.0, 32.0), 62.0
BEYOND = 14.0


def _points(*numbers: float) -> FloatArray:
    return np.reshape(np.array(numbers, dtype=float), (-1, 2))


def _turned(vectors: FloatArray, degrees: float) -> FloatArray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turned: FloatArray = vectors @ np.array([[c, s], [-s, c]])
    return turned


def _outline(left: float, low: float, right: float, high: float) -> FloatArray:
    return _points(left, low, right, low, right, high, left, high)


def tracks(incident: FloatArray, rebound: FloatArray) -> Parts:
    """Return the dashes of both tracks, ends relative to the point of impact, on the drawing."""
    return {"incident track": IMPACT + incident, "rebound track": IMPACT + rebound}


def _along_the_beam(beam: float, disk: float, half_lens: float) -> Parts:
    return {
        "laser": _points(LASER[0], beam - 6, LASER[1], beam + 6),
        "laser beam": _points(LASER[1], beam, CHOPPER, beam),
        "pulsed beam": _points(CHOPPER, beam, LENS, beam),
        "collimator": _points(COLLIMATOR[0], beam - 3.5, COLLIMATOR[1], beam + 3.5),
        "chopper": _points(CHOPPER - 0.5, disk - DISK_RADIUS, CHOPPER + 0.5, disk + DISK_RADIUS),
        "lens": _points(LENS, beam - half_lens, LENS, beam + half_lens),
    }


def imaging_side(slots: int, angle: float) -> Parts:
    """Return the parts of the imaging system (Fig. 1) seen along the camera's axis.

    Parameters
    ----------
    slots
        Slots of the chopper disk.
    angle
        Angle of incidence from the target's surface, degrees; the spheres fall straight down.
    """
    x, y = IMPACT
    spread = HALF_BEAM * (SHEET_END - FOCUS) / (FOCUS - LENS)
    turn = np.radians(-90.0 + 360.0 * np.arange(slots) / slots)
    rim = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    tilt = angle - 90.0
    return {
        "vacuum cell": _points(CELL[0], 2, CELL[1], 72),
        **_along_the_beam(BEAM_SIDE, BEAM_SIDE + BEAM_ON_DISK, 6.0),
        "disk": DISK_FACE + np.array([[-DISK_RADIUS, 0.0], [DISK_RADIUS, 0.0]]),
        "slots": (DISK_FACE + np.stack([SLOTS_FROM * rim, SLOTS_TO * rim], axis=1)).reshape(-1, 2),
        "light sheet": _points(
            LENS, BEAM_SIDE + HALF_BEAM, FOCUS, BEAM_SIDE, SHEET_END, BEAM_SIDE + spread,
            SHEET_END, BEAM_SIDE - spread, FOCUS, BEAM_SIDE, LENS, BEAM_SIDE - HALF_BEAM,
        ),
        "dispenser": _points(x - 13, 60, x + 13, 69),
        "plate": _points(x - 13, 60, x + 13, 60),
        "rotor": _points(x + 8, 58.3),
        "needle": _points(x, 60, x, 50),
        "target": IMPACT + _turned(_points(-12, 0, 12, 0), tilt),
        "normal": IMPACT + _turned(_points(0, 0, 0, 13), tilt),
        "drop height": _points(x - 22, 60, x - 22, y),
    }  # fmt: skip


def imaging_top(camera_angle: float) -> Parts:
    """Return the parts of the imaging system seen from above.

    Parameters
    ----------
    camera_angle
        Angle between the camera's axis and the light sheet, degrees.
    """
    x = IMPACT[0]
    centre, turn = np.array([x, BEAM_TOP]), camera_angle - 90.0
    return {
        "vacuum cell": _points(CELL[0], 17, CELL[1], 39),
        **_along_the_beam(BEAM_TOP, BEAM_TOP, 4.0),
        "light sheet": _points(LENS, BEAM_TOP, SHEET_END, BEAM_TOP),
        "sphere": centre[None],
        "porthole": centre + _turned(_points(-7, -12, 7, -12), turn),
        "camera axis": centre + _turned(_points(0, 0, 0, -18), turn),
        "camera": centre + _turned(_outline(-10, -26, 10, -18), turn),
        "recorder": _points(86, 3, 109, 11),
        "video signal": _points(122, 7, 109, 7),
    }


def analyser_top(receiver_angle: float, detectors: int) -> tuple[Parts, Parts]:
    """Return the parts of the phase Doppler analyser (Fig. 2) seen from above.

    Parts that the article names or implies, and usual parts that it leaves out.

    Parameters
    ----------
    receiver_angle
        Angle between the beams' axis and that of the receiver, degrees.
    detectors
        Number of detectors.
    """
    x, y = PROBE
    turn = receiver_angle - 90.0
    slope = HALF_PAIR / (x - PAIR_LENS)
    offsets = 4.6 * (np.arange(detectors) - (detectors - 1) / 2)
    places = np.stack([offsets, np.full(detectors, -35.0)], axis=-1)
    lens, end = np.array([PAIR_LENS, HALF_PAIR]), np.array([x + BEYOND, -slope * BEYOND])
    on_axis = np.array([0.0, y])
    upper = np.stack([[SPLITTER[1], HALF_PAIR], lens, end])
    named = {
        "vacuum cell": _points(x - 17, y - 16, x + 17, y + 16),
        "target": _points(x - 10, y - 10, x + 10, y + 10),
        "laser": _points(2, y - 7, 20, y + 7),
        "laser beam": _points(20, y, SPLITTER[0], y),
        "horizontal pair, upper": on_axis + upper,
        "horizontal pair, lower": on_axis + upper * [1.0, -1.0],
        "vertical pair": _points(SPLITTER[1], y, x + BEYOND, y),
        "frequency shifter": _points(38, y - 9, 54, y + 9),
        "probe volume": PROBE[None],
        "receiver axis": PROBE + _turned(_points(0, 0, 0, -30), turn),
        "receiver": PROBE + _turned(_outline(-9, -40, 9, -30), turn),
        "detectors": PROBE + _turned(places, turn),
        "data file": _points(38, 4, 62, 14),
        "signal": _points(x - 9, 9, 62, 9),
    }
    usual = {
        "beam splitter": _points(SPLITTER[0], y - 9, SPLITTER[1], y + 9),
        "transmitting lens": _points(PAIR_LENS, y - 9, PAIR_LENS, y + 9),
        "receiving lens": PROBE + _turned(_points(-7, -22, 7, -22), turn),
    }
    return named, usual


def analyser_side() -> Parts:
    """Return the parts around the probe volume, seen from the receiver."""
    x, low, probe = 23.0, 11.0, 33.0
    return {
        "target": _points(x - 18, low, x + 18, low),
        "vertical pair": _points(x - 20, probe + 5, x + 16, probe - 4),
        "vertical pair, lower": _points(x - 20, probe - 5, x + 16, probe + 4),
        "probe volume": _points(x, probe),
        "needle": _points(x, 66, x, 56),
        "incident": _points(x, 54, x, probe + 3),
        "rebound": _points(x + 2.5, low + 2, x + 2.5, probe - 3),
        "probe height": _points(x - 9, low, x - 9, probe),
    }
