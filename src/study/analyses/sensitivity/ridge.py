"""Many calibrations at once: steel on silicon along the ridge the printed numbers leave open.

Given are the two targets, the stiffness and a place along the ridge, as the share of the material
damping that alone would give the restitution; solved for are the work of adhesion and the adhesion
damping. Drawn independently, the four carry all correlation of w_A, c_A and c_H.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from microimpact.core.arrays import BoolArray, FloatArray
from microimpact.core.solve import roots
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from study.analyses.fig24_25_doe.factors import NAMES, at_levels

TURNS = 30
STEP = 1e-6
LARGEST_MOVE = 0.3
TOLERANCE = 1e-9
SMALLEST_DETERMINANT = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Targets:
    """Targets of each calibration, arrays of shape (n,); SI units.

    ``damping_share`` is c_H over the c_H that would give the restitution without adhesion;
    ``stiffness`` is a multiple of the start's.
    """

    high_speed: float
    restitution: FloatArray
    capture_velocity: FloatArray
    damping_share: FloatArray
    stiffness: FloatArray

    def some(self, chosen: BoolArray) -> Targets:
        """Return the targets of some calibrations."""
        arrays = ("restitution", "capture_velocity", "damping_share", "stiffness")
        return replace(self, **{name: getattr(self, name)[chosen] for name in arrays})


def calibrated_sample(start: Contact, targets: Targets) -> tuple[Contact, BoolArray]:
    """Calibrate a contact to many targets by Newton's method in ln w_A and ln c_A.

    Each search ends one turn after it meets its targets; few of them take the last turns.

    Contacts of shape (n,), and which of them meet their targets.

    Parameters
    ----------
    start
        A calibrated contact, where every search begins.
    targets
        What to meet.
    """
    damping = targets.damping_share * material_damping(targets.high_speed, targets.restitution)
    moved = _moved(start, targets.stiffness, damping)
    logs = np.log(np.array([moved.work_of_adhesion, moved.adhesion_damping]))
    miss = _misses(moved, targets, logs)
    left = np.ones(targets.stiffness.size, dtype=bool)
    for _ in range(TURNS):
        met = np.all(np.abs(miss) < TOLERANCE, axis=0)
        if np.all(met):
            break
        subset = targets.some(left)
        search = _moved(start, subset.stiffness, damping[left]), subset
        steps = _move(*search, logs[:, left], miss[:, left])
        logs[:, left] -= np.clip(steps, -LARGEST_MOVE, LARGEST_MOVE)
        miss[:, left] = _misses(*search, logs[:, left])
        left &= ~met
    return _placed(moved, logs), np.all(np.abs(miss) < TOLERANCE, axis=0)


def _moved(start: Contact, stiffness: FloatArray, damping: FloatArray) -> Contact:
    """Return contacts of other stiffness and material damping, near the ridge."""
    multiples = np.ones((stiffness.size, len(NAMES)))
    multiples[:, NAMES.index("stiffness")] = stiffness
    # The ridge goes with the velocity scale, V ~ K^(-1/3) w_A^(5/6).
    multiples[:, NAMES.index("work_of_adhesion")] = stiffness**0.4
    return at_levels(start, multiples).replace(hertz_damping=damping)


def material_damping(speed: float, restitution: FloatArray) -> FloatArray:
    """Material damping in s/m that alone gives a restitution at a speed (Hunt and Crossley).

    With d = c_H v, ``d - ln(1 + d) = -e d - ln(1 - e d)``.
    """

    def excess(share: FloatArray, e: FloatArray) -> FloatArray:
        # The unknown is e d, between 0 and 1; the square takes out the root at zero.
        d = share / e
        quotient: FloatArray = (d - np.log1p(d) + share + np.log1p(-share)) / d**2
        return quotient

    share = roots(excess, 1e-4, 1.0 - 1e-12, restitution)
    return share / restitution / speed


def _placed(moved: Contact, logs: FloatArray) -> Contact:
    work, damping = np.exp(logs)
    return moved.replace(work_of_adhesion=work, adhesion_damping=damping)


def _misses(moved: Contact, targets: Targets, logs: FloatArray) -> FloatArray:
    """How far both targets are missed, shape (2, n)."""
    sample = _placed(moved, logs)
    # An impact at the capture velocity depends on its damping at that speed only.
    damping = sample.adhesion_damping_at(targets.capture_velocity)
    rateless = sample.replace(adhesion_damping=damping, adhesion_rate_exponent=0.0)
    limit = capture_velocity(rateless)
    e = normal_impact(sample, targets.high_speed).coefficient_of_restitution
    return np.stack([np.log(limit / targets.capture_velocity), e - targets.restitution])


def _move(moved: Contact, targets: Targets, logs: FloatArray, miss: FloatArray) -> FloatArray:
    """Newton's step, zero where there is none; shape (2, n)."""
    (a, c), (b, d) = (
        (_misses(moved, targets, logs + STEP * axis[:, None]) - miss) / STEP for axis in np.eye(2)
    )
    determinant = a * d - b * c
    usable = np.isfinite(determinant) & (np.abs(determinant) > SMALLEST_DETERMINANT)
    step = np.stack([d * miss[0] - b * miss[1], a * miss[1] - c * miss[0]])
    return np.where(usable, step / np.where(usable, determinant, 1.0), 0.0)
