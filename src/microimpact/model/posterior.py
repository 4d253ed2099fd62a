"""Contacts that measured restitutions admit: draws of the posterior instead of one best contact.

Two numbers do not determine an adhesive, damped contact; a curve of e against the speed hardly
does. What is left open comes out as an array of contacts, which every model takes as it takes one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from numbers import Integral

import numpy as np

from microimpact.core import ensemble
from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, FloatArray, Numbers, Range, checked
from microimpact.core.nearest import nearest
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.empirical.data import measurements

# Ranges of what can be free; those of damping are of c v at the highest speed, a pure number.
RANGES = {
    "work_of_adhesion": (1e-3, 10.0),
    "hertz_damping": (0.0, 10.0),
    "adhesion_damping": (1e-3, 1e3),
    "adhesion_rate_exponent": (0.0, 1.0),
}
FREE = tuple(RANGES)
PER_SPEED = frozenset({"hertz_damping", "adhesion_damping"})
# Those whose logarithm is uniform in its range; the others are so themselves.
LOGARITHMIC = frozenset({"work_of_adhesion", "adhesion_damping"})

RESTITUTION = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)

SPREAD, WALKERS, STEPS = 13, 40, 450
# The chains have not come together where their halves differ by more, or where they are worth fewer
# independent draws than this share of those wanted.
LARGEST_R_HAT, LEAST_SHARE = 1.1, 0.5


class NoConvergenceError(RuntimeError):
    """The chains have not come together."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Calibration:
    """Contacts that data admit; ``str(calibration)`` is a summary.

    Attributes
    ----------
    contact
        Contact whose free fields are arrays (draws,): `simulate` and `capture_velocity` take it
        as it is, with speeds of shape (..., 1) for curves.
    best
        The one of these contacts with the highest posterior density.
    free
        Names of the free fields.
    log_likelihood
        Of each draw (draws,): minus half its chi-square.
    acceptance, effective_size, split_r_hat
        Of the sampler: share of accepted moves, independent draws that its steps are worth, and
        per free field the spread between the halves of the chains against that within.
    """

    contact: Contact
    best: Contact
    free: tuple[str, ...]
    log_likelihood: FloatArray = field(repr=False)
    acceptance: float
    effective_size: float
    split_r_hat: Mapping[str, float]

    def __str__(self) -> str:
        least = -2.0 * self.log_likelihood.max()
        lines = [
            f"{self.log_likelihood.size} draws, least chi-square {least:.3g}; "
            f"acceptance {self.acceptance:.2f}, effective size {self.effective_size:.0f}"
        ]
        for name in self.free:
            low, middle, high = np.quantile(getattr(self.contact, name), [0.05, 0.5, 0.95])
            lines.append(
                f"{name} {middle:.4g} [{low:.4g}, {high:.4g}] (median, 5 to 95 %), "
                f"split R-hat {self.split_r_hat[name]:.3f}"
            )
        return "\n".join(lines)


def calibrate(
    contact: Contact,
    v: Numbers,
    e: Numbers,
    sigma: Numbers,
    free: Iterable[str] = ("work_of_adhesion", "hertz_damping", "adhesion_damping"),
    *,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    draws: int = 400,
    steps: int = STEPS,
    seed: int = 0,
) -> Calibration:
    """Draw the contacts that measured restitutions in normal impacts admit.

    The likelihood is normal in e. Within their ranges the logarithms of w_A and c_A are uniform
    before the data, and so are c_H, which adds to the loss, and n.

    Parameters
    ----------
    contact
        One contact; its fields that are not free are kept.
    v
        Normal speeds, m/s, positive (m,), two or more.
    e
        Restitutions measured there, in [0, 1]; 0 for captured spheres.
    sigma
        Standard errors of e, positive: one for all, or (m,).
    free
        Names of fields to be drawn: ``work_of_adhesion``, ``hertz_damping``,
        ``adhesion_damping``, ``adhesion_rate_exponent``.
    ranges
        Ends of a free field's range, by name, in its unit. If not given: w_A from 0.001 to
        10 J/m2, n from 0 to 1, and with the highest speed v: c_H v up to 10, c_A v from 0.001
        to 1000.
    draws
        How many are returned.
    steps
        Of the sampler.
    seed
        Of all random numbers, 0 or more.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another kind, shape or range.
    NoConvergenceError
        If the chains have not come together in so many steps.

    Examples
    --------
    >>> found = calibrate(contact, v=[0.3, 0.8, 1.7], e=[0.45, 0.69, 0.70], sigma=0.02)
    >>> capture_velocity(found.contact).shape
    (400,)
    """
    require_contact(contact, pair=True)
    if contact.shape:
        raise ValueError(f"contact must be a single one, got one of shape {contact.shape}")
    names = _free(free, contact)
    speed, target, error = _data(v, e, sigma)
    for name, value, least in (("draws", draws, 1), ("steps", steps, 30), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise TypeError(f"{name} must be a whole number, got {value!r}")
        if value < least:
            raise ValueError(f"{name} must be at least {least}, got {value}")
    ends = np.array([_range(name, ranges or {}, float(speed.max())) for name in names])
    for name in ranges or {}:
        if name not in names:
            raise ValueError(f"ranges: {name!r} is not free{nearest(name, names)}")
    logs = np.array([name in LOGARITHMIC for name in names])
    ends[logs] = np.log(ends[logs])

    def contacts(points: FloatArray) -> Contact:
        values = np.where(logs, np.exp(np.where(logs, points, 0.0)), points)
        return contact.replace(**dict(zip(names, values.T[..., None], strict=True)))

    def log_likelihood(points: FloatArray) -> FloatArray:
        e = normal_impact(contacts(points), speed).coefficient_of_restitution
        return np.asarray(-0.5 * np.sum(np.square((e - target) / error), axis=1))

    chain = ensemble.draw(
        log_likelihood, *ends.T, draws=draws, spread=SPREAD, walkers=WALKERS, steps=steps, seed=seed
    )
    worst = int(np.argmax(chain.split_r_hat))
    if chain.split_r_hat[worst] > LARGEST_R_HAT or chain.effective_size < LEAST_SHARE * draws:
        raise NoConvergenceError(
            f"the chains have not come together in {steps} steps: they are worth "
            f"{chain.effective_size:.0f} independent draws, and split R-hat of {names[worst]} is "
            f"{chain.split_r_hat[worst]:.3f}; give more steps, narrower ranges, or fewer free"
        )
    chosen = contacts(chain.points)
    arrays = {name: getattr(chosen, name)[:, 0] for name in names}
    best = int(np.argmax(chain.log_density))
    return Calibration(
        contact=contact.replace(**arrays),
        best=contact.replace(**{name: float(value[best]) for name, value in arrays.items()}),
        free=names,
        log_likelihood=chain.log_density,
        acceptance=chain.acceptance,
        effective_size=chain.effective_size,
        split_r_hat=dict(zip(names, chain.split_r_hat.tolist(), strict=True)),
    )


def _free(free: Iterable[str], contact: Contact) -> tuple[str, ...]:
    names = (free,) if isinstance(free, str) else tuple(free)
    for name in names:
        if name not in FREE:
            raise ValueError(
                f"free must be among {', '.join(FREE)}, got {name!r}{nearest(str(name), FREE)}"
            )
    if not names or len(set(names)) < len(names):
        raise ValueError(f"free must name one field or more, each once, got {names}")
    if "adhesion_rate_exponent" in names and contact.reference_velocity is None:
        raise ValueError(
            "contact must have a reference_velocity where adhesion_rate_exponent is free"
        )
    return names


def _data(v: Numbers, e: Numbers, sigma: Numbers) -> tuple[FloatArray, FloatArray, FloatArray]:
    speed, target, error = measurements(v, e, sigma, RESTITUTION, POSITIVE)
    if speed.size < 2:
        raise ValueError(f"v and e must hold two measurements or more, got {speed.size}")
    return speed, target, error


def _range(
    name: str, ranges: Mapping[str, tuple[float, float]], speed: float
) -> tuple[float, float]:
    if name not in ranges:
        low, high = RANGES[name]
        return (low / speed, high / speed) if name in PER_SPEED else (low, high)
    ends = np.atleast_1d(
        checked(
            f"ranges[{name!r}]", ranges[name], POSITIVE if name in LOGARITHMIC else NON_NEGATIVE
        )
    )
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise ValueError(f"ranges[{name!r}] must be two numbers that ascend, got {ranges[name]!r}")
    return float(ends[0]), float(ends[1])
