"""The law of normal impacts as a table: ensembles from a few integrations, to a stated error.

In the adhesive scale the outcome of a normal impact follows from its speed in velocity scales V and
from the damping groups, and these follow from V where the damping is one for all. So impacts that
share their damping, or their groups, are one function of the speed and, at most, of V, whatever
diameters, works of adhesion and materials differ. Speeds count from the threshold of capture,
x = v/v_c - 1: there, and nowhere else, the outcome is singular (e ~ sqrt(x)), so on pieces that
grow with x polynomials converge fast.

Impacts within `THRESHOLD` of capture, and those beyond the table in speed or in V, are integrated:
verdicts are the integrator's, and the bound of the relative error of e holds down to the threshold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from microimpact.core.arrays import (
    BoolArray,
    FloatArray,
    Numbers,
    Range,
    checked,
    whole,
)
from microimpact.core.readable import Readable
from microimpact.core.solve import IntArray
from microimpact.model import passes
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics.impact import (
    PULL_OFF,
    SPEED,
    Impact,
    incident,
    planar_fields,
    velocity_components,
)
from microimpact.model.law.families import Family, Sizes
from microimpact.model.law.pieces import (
    NOTHING,
    TOLERANCES,
    WIDTHS,
    Compiled,
    Table,
    between,
    compiled,
    in_blocks,
    slowness,
    smallest,
)

TOLERANCE, TOLERANCE_BY_LAW = 1e-9, 1e-6

# Relative distance from the capture velocity within which impacts are integrated.
THRESHOLD = 2.0**-9

# Octaves of speed that a table has at most; bands of velocity scales that are tried in turn.
MOST_OCTAVES = 64
BANDS = (1, 2, 4, 8, 16, 32)

# Of the capture velocity; its error, divided by THRESHOLD, enters e.
CAPTURE_TOLERANCE = 1e-13


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Law(Readable):
    """The law of normal impacts of some contacts as a table; made by `tabulate`.

    Attributes
    ----------
    contact
        The contacts it was made for, whose impacts `simulate` computes.
    family
        All contacts that it holds for.
    fastest
        Normal speed up to which it was asked for, m/s.
    slowness
        Chebyshev coefficients, over the position in the family, of the reciprocal of the capture
        velocity in velocity scales, which is nearly linear; empty where nothing is captured.
    rebounds, captures
        Tables of the impacts above and below it; empty where no speed asked for is there.
    error
        Bound of the relative errors of all quantities further than `THRESHOLD` from capture: twice
        the largest difference from integration at points between the nodes.
    """

    contact: Contact
    family: Family | Sizes = field(repr=False)
    fastest: float
    slowness: FloatArray = field(repr=False)
    rebounds: Table = field(repr=False)
    captures: Table = field(repr=False)
    error: float

    def simulate(
        self,
        speed: Numbers,
        angle: Numbers = 90.0,
        spin: Numbers = 0.0,
        friction_basis: str = "compressive",
        *,
        threads: int = 1,
        partner_spin: Numbers = 0.0,
    ) -> Impact:
        """Simulate impacts as `model.dynamics.impact.simulate` does, from the table.

        Verdicts on capture are those of integration. Normal impacts differ from integrated ones by
        no more than ``interpolation_error``, relative, which grows towards capture: there rounding
        of the speed alone moves e by about 2e-14/(v/v_c - 1). Normal speeds beyond the table are
        integrated.

        Parameters
        ----------
        speed, angle, spin, friction_basis, partner_spin
            As of `model.dynamics.impact.simulate`; they broadcast with the contacts.
        threads
            Among which the work is shared; results do not depend on it.

        Raises
        ------
        TypeError, ValueError
            If an argument is not a number or out of range, or the shapes do not broadcast.
        RuntimeError
            If an integration failed.
        """
        threads = whole("threads", threads, 1)
        before, spins, shape = incident(
            self.contact, speed, angle, spin, friction_basis, partner_spin=partner_spin
        )
        columns = *before.values(), spins.joint
        speed, angle, _ = states = [passes.flat(values, shape) for values in columns]
        contacts = self.family.columns(self.contact, shape)
        out, flags = passes.outcomes(shape)
        if friction_basis == PULL_OFF:
            raise ValueError(
                f"friction_basis {PULL_OFF!r} is not in a table: take 'compressive' or 'net' here, "
                "or integrate with microimpact.simulate"
            )
        support = passes.SUPPORT[friction_basis]

        def run(which: IntArray, integrated: FloatArray) -> None:
            passes.tabulated(
                which, integrated, self.compiled, *states, contacts, support, out, flags
            )

        def block(part: slice) -> None:
            run(np.arange(part.start, part.stop), np.empty((passes.WIDTH, 0)))

        in_blocks(block, math.prod(shape), threads)
        rest = np.flatnonzero(np.isnan(out[passes.OUT_RESTITUTION]))
        if rest.size:
            rows, toward, tilt = (a[rest % len(a)] for a in (contacts, speed, angle))
            w = -velocity_components(toward, tilt)[0] / rows[:, passes.UNIT]
            position = rows[:, passes.PLACE]
            run(rest, self.family.impacts(w, position, ledger=True)[0])
            out[passes.OUT_ERROR, rest] = self._error(w, position)
        fields = {"contact_time": passes.OUT_CONTACT_TIME, "interpolation_error": passes.OUT_ERROR}
        fields |= {"maximum_compression": passes.OUT_COMPRESSION}
        impact = Impact(
            **planar_fields(out, shape),
            **{name: out[row].reshape(shape)[()] for name, row in fields.items()},
            captured=flags[passes.OUT_CAPTURED].reshape(shape)[()],
            rolling=flags[passes.OUT_ROLLING].reshape(shape)[()],
        )
        return spins.separate(impact)

    @cached_property
    def compiled(self) -> Compiled:
        """Arguments of the compiled look-up."""
        return compiled(self.slowness, self.captures, self.rebounds, THRESHOLD, self.error)

    @property
    def pieces(self) -> int:
        """Number of pieces of both tables."""
        return self.rebounds.pieces + self.captures.pieces

    def quantities(self, w: FloatArray, position: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Scaled quantities (WIDTH, n) of impacts, and the captured ones (n,).

        Parameters
        ----------
        w, position
            Coordinates of the impacts, see `Family.coordinates`; a position of one element holds
            for all impacts.
        """
        values = np.empty((passes.WIDTH, w.size))
        passes.look_up(w, position, self.compiled, values, 0)
        rest = np.flatnonzero(np.isnan(values[passes.RESTITUTION]))
        captured = values[passes.CONTACT_TIME] == np.inf
        if rest.size:
            values[:, rest], captured[rest] = self.family.impacts(
                w[rest], np.broadcast_to(position, w.shape)[rest], ledger=True
            )
        return values, captured

    def restitution(self, w: FloatArray, position: FloatArray) -> FloatArray:
        """Coefficients of restitution (n,) at coordinates as of `quantities`; 0 where captured."""
        e = np.empty(w.size)
        passes.restitution(w, position, self.compiled, e)
        rest = np.flatnonzero(np.isnan(e))
        if rest.size:
            positions = np.broadcast_to(position, w.shape)[rest]
            values, _ = self.family.impacts(w[rest], positions, ledger=False)
            e[rest] = values[passes.RESTITUTION]
        return e

    def _error(self, w: FloatArray, position: FloatArray) -> FloatArray:
        """Bound of the relative difference from integration."""
        if not self.slowness.size:
            return np.full(w.shape, self.error + passes.ROUNDING)
        excess = np.asarray(np.abs(w * chebyshev.chebval(position, self.slowness) - 1.0))
        if np.any(beyond := np.broadcast_to(np.abs(position) > 1.0, w.shape)):
            limit = self.family.capture_speed(np.broadcast_to(position, w.shape)[beyond])
            excess[beyond] = np.abs(w[beyond] / limit - 1.0)
        with np.errstate(divide="ignore"):
            return np.asarray(self.error + passes.ROUNDING / excess)


def tabulate(
    contact: Contact, slowest: float, fastest: float, tolerance: float | None = None
) -> Law:
    """Tabulate the law of normal impacts of some contacts, for ensembles of many impacts.

    It takes some hundredths of a second, and pays from about 100,000 impacts on.

    Parameters
    ----------
    contact
        One contact, or an array of contacts that share their damping, or their damping groups:
        spheres of many diameters, say. By another law than the ring force they differ in their
        diameters alone.
    slowest, fastest
        Normal speeds of approach between which the table holds, m/s, positive; impacts beyond are
        integrated.
    tolerance
        Largest relative error from interpolation; 1e-9 if not given, by another law than the ring
        force 1e-6, for such laws have kinks.

    Returns
    -------
    Law
        With `Law.simulate` in place of `model.dynamics.impact.simulate`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not a number or out of range.
    NoTableError
        A ValueError: if the contacts share neither, if at no speed a sphere of them rebounds, or if
        no table reaches the tolerance.
    """
    require_contact(contact, any_law=True, pair=True)
    slowest = float(checked("slowest", slowest, SPEED))
    fastest = float(
        checked("fastest", fastest, Range(lower=slowest, upper=SPEED.upper, lower_closed=True))
    )
    if tolerance is None:
        tolerance = TOLERANCE_BY_LAW if contact.law else TOLERANCE
    tolerance = float(checked("tolerance", tolerance, TOLERANCES))
    family = Sizes.of(contact) if contact.law else Family.of(contact)
    slow, fast = (family.coordinates(contact, np.asarray(v))[0] for v in (slowest, fastest))
    slowness = _slowness(family)
    least, greatest = float(np.min(slow)), float(np.max(fast))
    rebounds = captures = NOTHING
    if not slowness.size:
        rebounds = _fitted(family, slowness, _octaves(least, greatest), tolerance)
    else:
        limits = 1.0 / chebyshev.chebval(between(60), slowness)
        excess = greatest / float(limits.min()) - 1.0
        if excess >= THRESHOLD:
            rebounds = _fitted(family, slowness, _octaves(THRESHOLD, excess), tolerance)
        if least < float(limits.max()):
            octaves = _octaves(least / float(limits.max()), 1.0 - THRESHOLD)
            captures = _fitted(family, slowness, octaves, tolerance, captured=True)
    return Law(
        contact=contact,
        family=family,
        fastest=fastest,
        slowness=slowness,
        rebounds=rebounds,
        captures=captures,
        error=max(rebounds.error, captures.error),
    )


def _octaves(lowest: float, highest: float) -> tuple[int, int]:
    """Binary exponent of the first octave, and number of octaves, from the lowest x to the highest.

    There are `MOST_OCTAVES` at most, the highest.
    """
    first, last = math.frexp(lowest)[1], math.frexp(highest)[1]
    number = min(last - first + 1, MOST_OCTAVES)
    return last - number + 1, number


def _slowness(family: Family | Sizes) -> FloatArray:
    """Chebyshev coefficients of one over the capture velocity, in velocity scales."""
    if not np.any(family.capture_speed(between(1))):
        return np.zeros(0)
    return slowness(family.capture_speed, CAPTURE_TOLERANCE, alike=family.alike)


def _fitted(
    family: Family | Sizes,
    slowness: FloatArray,
    octaves: tuple[int, int],
    tolerance: float,
    *,
    captured: bool = False,
) -> Table:
    """Smallest table that reaches the tolerance."""

    def sampled(x: FloatArray, position: FloatArray) -> FloatArray:
        w = x
        if slowness.size:
            w = (x if captured else 1.0 + x) / chebyshev.chebval(position, slowness)
        values, stays = family.impacts(w, position, ledger=True, captured=captured)
        values[:, stays != captured] = np.nan
        if captured:
            values[passes.CONTACT_TIME] = 0.0  # really infinite, and not asked of the table
        return values

    if family.alike:
        return smallest(sampled, octaves, tolerance)
    split = smallest(sampled, octaves, 0.25 * tolerance).split
    return smallest(sampled, octaves, tolerance, (split,), BANDS, WIDTHS)
