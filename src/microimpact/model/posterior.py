"""Contacts that measured restitutions admit: draws of the posterior instead of one best contact.

Two numbers do not determine an adhesive, damped contact; a curve of e against the speed hardly
does. What is left open comes out as an array of contacts, which every model takes as it takes one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral

import numpy as np
import scipy

from microimpact.core import ensemble
from microimpact.core.arrays import NON_NEGATIVE, POSITIVE, FloatArray, Numbers, Range, checked
from microimpact.core.nearest import nearest
from microimpact.core.readable import Readable
from microimpact.model.choices import INTERVAL
from microimpact.model.contact import Contact, require_contact
from microimpact.model.contact_laws import RING_FORCE
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
SYMBOLS = dict(zip(("w_A", "c_H", "c_A", "n"), FREE, strict=True))
PER_SPEED = frozenset({"hertz_damping", "adhesion_damping"})
# Those whose logarithm is uniform in its range; the others are so themselves.
LOGARITHMIC = frozenset({"work_of_adhesion", "adhesion_damping"})

RESTITUTION = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)

# Misfits that chance brings about more rarely are told.
REJECTED = 0.01
SPREAD, WALKERS, STEPS = 13, 40, 450
# The chains have not come together where their halves differ by more, or where they are worth fewer
# independent draws than this share of those wanted.
LARGEST_R_HAT, LEAST_SHARE = 1.1, 0.5


@dataclass(frozen=True, slots=True)
class Misfit:
    """Least chi-square by a law, and the degrees of freedom; as text with its probability."""

    law: str
    chi_square: float
    freedom: int

    @property
    def probability(self) -> float:
        """Probability that chance brings about such a chi-square or a larger one."""
        return float(scipy.special.chdtrc(self.freedom, self.chi_square))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warning that the law does not fit, if the misfit is improbable."""
        return (f"{self.law} does not fit: {self}",) if self.probability < REJECTED else ()

    def __str__(self) -> str:
        reduced = self.chi_square / max(self.freedom, 1)
        return (
            f"reduced chi-square {reduced:.3g} ({self.freedom} degrees of freedom, probability "
            f"{self.probability:.2g})"
        )


class NoConvergenceError(RuntimeError):
    """The chains have not come together."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Calibration(Readable):
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
    misfit
        The least of these.
    acceptance, effective_size, split_r_hat
        Of the sampler: share of accepted moves, independent draws that its steps are worth, and
        per free field the spread between the halves of the chains against that within.
    """

    contact: Contact
    best: Contact
    free: tuple[str, ...]
    log_likelihood: FloatArray = field(repr=False)
    misfit: Misfit
    acceptance: float
    effective_size: float
    split_r_hat: Mapping[str, float]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to trust the draws, in sentences."""
        return self.misfit.warnings

    def summary(self) -> str:
        """Misfit, state of the sampler and range of each free field, as text."""
        lines = [
            f"{self.log_likelihood.size} draws; {self.misfit}; acceptance {self.acceptance:.2f}, "
            f"effective size {self.effective_size:.0f}"
        ]
        for name in self.free:
            low, middle, high = np.quantile(getattr(self.contact, name), INTERVAL)
            lines.append(
                f"{name} {middle:.4g} [{low:.4g}, {high:.4g}] (median, 95 %), "
                f"split R-hat {self.split_r_hat[name]:.3f}"
            )
        return "\n".join(lines)


def calibrate(
    contact: Contact,
    v: Numbers,
    e: Numbers,
    sigma: Numbers,
    free: Iterable[str] = FREE,
    *,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    draws: int = 400,
    steps: int = STEPS,
    seed: int = 0,
) -> Calibration:
    """Draw the contacts by the ring force that measured restitutions in normal impacts admit.

    `microimpact.model.law_draws.calibrate_laws` does not suppose this law.
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
        Fields to be drawn: ``work_of_adhesion`` or ``w_A``, ``hertz_damping`` or ``c_H``,
        ``adhesion_damping`` or ``c_A``, ``adhesion_rate_exponent`` or ``n``. Where n is, and the
        contact has no reference velocity, that is the geometric mean of the speeds.
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
    names = free_fields(free)
    speed, target, error = _data(v, e, sigma)
    if "adhesion_rate_exponent" in names and contact.reference_velocity is None:
        contact = contact.replace(reference_velocity=float(np.exp(np.mean(np.log(speed)))))
    require_whole_numbers(draws=(draws, 1), steps=(steps, 30), seed=(seed, 0))
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
    require_convergence(chain, draws, steps, names)
    chosen = contacts(chain.points)
    arrays = {name: getattr(chosen, name)[:, 0] for name in names}
    best = int(np.argmax(chain.log_density))
    return Calibration(
        contact=contact.replace(**arrays),
        best=contact.replace(**{name: float(value[best]) for name, value in arrays.items()}),
        free=names,
        log_likelihood=chain.log_density,
        misfit=Misfit(RING_FORCE, -2.0 * chain.log_density.max(), speed.size - len(names)),
        acceptance=chain.acceptance,
        effective_size=chain.effective_size,
        split_r_hat=dict(zip(names, chain.split_r_hat.tolist(), strict=True)),
    )


def require_whole_numbers(**numbers: tuple[object, int]) -> None:
    """Raise TypeError or ValueError unless arguments, each with its least value, are such."""
    for name, (value, least) in numbers.items():
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise TypeError(f"{name} must be a whole number, got {value!r}")
        if value < least:
            raise ValueError(f"{name} must be at least {least}, got {value}")


def has_converged(chain: ensemble.Draws, draws: int) -> bool:
    """Tell whether chains agree and are worth so many draws."""
    agree = chain.split_r_hat.max() <= LARGEST_R_HAT
    return bool(agree and chain.effective_size >= LEAST_SHARE * draws)


def require_convergence(
    chain: ensemble.Draws, draws: int, steps: int, names: Sequence[str], law: str = ""
) -> None:
    """Refuse chains over named axes that are not worth so many draws.

    Parameters
    ----------
    chain
        Draws with split R-hat of each axis and their effective size.
    draws
        Number of independent draws that they must be worth a share of.
    steps
        Steps taken, for the message.
    names
        Names of the axes.
    law
        Law of contact of the chains, for the message.

    Raises
    ------
    NoConvergenceError
        If they are not worth so many draws.
    """
    worst = int(np.argmax(chain.split_r_hat))
    if not has_converged(chain, draws):
        raise NoConvergenceError(
            f"the chains {f'of {law} ' if law else ''}have not come together in {steps} steps: "
            f"they are worth {chain.effective_size:.0f} independent draws, and split R-hat of "
            f"{names[worst]} is {chain.split_r_hat[worst]:.3f}; give "
            f"{'fewer draws' if law else 'more steps, narrower ranges, or fewer free'}"
        )


def free_fields(free: Iterable[str]) -> tuple[str, ...]:
    """Return the fields of a contact by their names or symbols."""
    names = (free,) if isinstance(free, str) else tuple(free)
    for name in names:
        if name not in SYMBOLS and name not in FREE:
            known = (*SYMBOLS, *FREE)
            raise ValueError(
                f"free must be among {', '.join(known)}, got {name!r}{nearest(str(name), known)}"
            )
    names = tuple(SYMBOLS.get(name, name) for name in names)
    if not names or len(set(names)) < len(names):
        raise ValueError(f"free must name one field or more, each once, got {names}")
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
