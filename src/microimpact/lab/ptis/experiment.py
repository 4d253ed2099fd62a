"""Experiments at oblique incidence: particles dropped on a tilted target, seen by the PTIS.

What the PTIS makes of an impact is told by the error model of its frames (`observation.modelled`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import Generator

from microimpact.core.arrays import BoolArray, FloatArray, Real
from microimpact.lab.dispenser import Dispenser, InitialSpin, drop_height, release
from microimpact.lab.events import Impacts, IntArray, Measured
from microimpact.lab.experiment import Target, hit
from microimpact.lab.ptis.exposure import MEASURED, OFF_SHEET
from microimpact.lab.ptis.observation import modelled
from microimpact.lab.ptis.system import Instrument, Setup, child, draw_systematics
from microimpact.lab.reduction import Mean, mean_interval
from microimpact.statistics.distributions import Distribution, mean

OUTSIDE_CLASS = "outside the class"

# Particles dropped at first; while events are wanting, as many again as so far.
DROPPED_AT_FIRST = 200
# Impacts looked at together.
LOOKED_AT_ONCE = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """What an oblique experiment is made of, but for its angle.

    Attributes
    ----------
    target
        Contact and roughness.
    diameter_um
        Sizes of the particles.
    speed, speed_range
        Nominal speed, m/s, and range of *measured* speeds accepted.
    dispenser, spin, instrument
        Settings.
    """

    target: Target
    diameter_um: Distribution
    speed: float
    speed_range: tuple[float, float]
    dispenser: Dispenser
    spin: InitialSpin
    instrument: Instrument


@dataclass(frozen=True, slots=True, kw_only=True)
class Collected:
    """Outcome of one experiment, up to its last event.

    Attributes
    ----------
    measured
        Accepted events, in order of time; `event` counts in `impacts`.
    impacts
        All that the light sheet and the camera's field could show, in order of time.
    dropped
        Particles dropped.
    fates
        What became of them; `outside the class` is measured but of another speed.
    """

    measured: Measured
    impacts: Impacts
    dropped: int
    fates: Mapping[str, int]

    @property
    def captured(self) -> int:
        """Number of the impacts that were captured."""
        return int(np.sum(self.impacts.captured))

    @property
    def rebounded(self) -> int:
        """Number of the impacts that were not."""
        return len(self.impacts) - self.captured

    @property
    def true_restitution(self) -> FloatArray:
        """Restitution of the accepted events as it was; same shape as `measured`."""
        return self.impacts.in_plane.coefficient_of_restitution[self.measured.event]


def collect(
    recipe: Recipe, angle: float, events: int, most_dropped: int, rng: Generator
) -> Collected:
    """Drop particles until enough events are accepted, or the experiment is given up.

    Nothing depends on how many particles are looked at together.

    Parameters
    ----------
    recipe
        What to drop, on what, and how to look at it.
    angle
        Nominal angle of incidence from the surface, degrees, below 90.
    events
        Number of accepted events wanted.
    most_dropped
        Number of particles after which the experiment is given up.
    rng
        Of the experiment; its children serve the parts.
    """
    setup = Setup(
        instrument=recipe.instrument,
        angle=angle,
        speed=recipe.speed,
        diameter=mean(recipe.diameter_um) * 1e-6,
    )
    errors = draw_systematics(recipe.instrument, rng)
    fates: Counter[str] = Counter()
    looked: list[Impacts] = []
    found: list[Measured] = []
    dropped = first = accepted = 0
    while accepted < events and dropped < most_dropped:
        number = min(max(dropped, DROPPED_AT_FIRST), most_dropped - dropped)
        shown, batch = _drop(recipe, angle, number, child(rng, 2, dropped))
        used = number
        for start in range(0, max(1, len(shown)), LOOKED_AT_ONCE):
            some = batch.select(slice(start, start + LOOKED_AT_ONCE))
            wanted = events - accepted
            seen = modelled(some, setup, rng, first=first, errors=errors)
            part, end = _accepted(seen.measured, recipe, wanted, len(some))
            fates.update(seen.fates[:end])
            looked.append(some.select(slice(end)))
            found.append(replace(part, event=part.event + first))
            accepted, first = accepted + len(part), first + end
            if accepted == events:
                used = int(shown[start + end - 1]) + 1
                break
        fates[OFF_SHEET] += used - int(np.sum(shown < used))
        dropped += used
    fates[OUTSIDE_CLASS] = fates[MEASURED] - accepted
    return Collected(
        measured=Measured.joined(found),
        impacts=Impacts.joined(looked),
        dropped=dropped,
        fates=dict(fates),
    )


def _accepted(measured: Measured, recipe: Recipe, wanted: int, looked: int) -> tuple[Measured, int]:
    """Return the events of the class, no more than wanted, and how many impacts it took."""
    low, high = recipe.speed_range
    inside = np.flatnonzero((measured.speed >= low) & (measured.speed <= high))[:wanted]
    part = measured.select(inside)
    return part, int(part.event[-1]) + 1 if len(part) == wanted else looked


def _drop(recipe: Recipe, angle: float, number: int, rng: Generator) -> tuple[IntArray, Impacts]:
    """Return which of some particles arrive where they can be seen, and their impacts."""
    falling = release(
        number,
        angle=angle,
        height=drop_height(recipe.speed, recipe.dispenser),
        diameter_um=recipe.diameter_um,
        dispenser=recipe.dispenser,
        spin=recipe.spin,
        rng=rng,
    )
    shown = np.flatnonzero(in_sheet(falling.position, recipe.instrument))
    return shown, hit(falling.select(shown), recipe.target, rng)


def in_sheet(position: FloatArray, instrument: Instrument) -> BoolArray:
    """Tell at which places (n, 2) the light sheet and the camera can see an impact at all."""
    half = 0.5e-3 * instrument.sheet_thickness_mm
    field = 1e-6 * instrument.pixel_um * max(instrument.frame_px)
    x, y = position.T
    seen: BoolArray = (np.abs(y) <= half) & (np.abs(x) <= field)
    return seen


def quantities(measured: Measured) -> dict[str, FloatArray]:
    """Return restitution, impulse ratio and energy loss (Eqs. 1-3) of every event."""
    return {
        "restitution": measured.coefficient_of_restitution,
        "impulse_ratio": measured.impulse_ratio,
        "energy_loss": measured.translational_energy_loss,
    }


def reduced(measured: Measured, angle_error: float) -> dict[str, Mean]:
    """Return mean and interval of every quantity; the target's angle is shared by all events.

    The magnification and the chopper's rate scale all speeds alike and leave the ratios.

    Parameters
    ----------
    measured
        At least two events.
    angle_error
        Standard uncertainty of the target's angle, degrees.
    """
    high, low = (quantities(turned(measured, sign * angle_error)) for sign in (1.0, -1.0))
    return {
        name: mean_interval(values, systematic=0.5 * abs(np.mean(high[name] - low[name])))
        for name, values in quantities(measured).items()
    }


def turned(measured: Measured, angle: Real) -> Measured:
    """Return the events as seen from a target turned by an angle in degrees.

    The angle broadcasts with the events.
    """
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))

    def both(normal: FloatArray, tangential: FloatArray) -> tuple[FloatArray, FloatArray]:
        return cos * normal - sin * tangential, cos * tangential + sin * normal

    incident = both(measured.incident_normal, measured.incident_tangential)
    rebound = both(measured.rebound_normal, measured.rebound_tangential)
    return replace(
        measured,
        incident_normal=incident[0],
        incident_tangential=incident[1],
        rebound_normal=rebound[0],
        rebound_tangential=rebound[1],
    )
