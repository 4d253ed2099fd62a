"""Contacts that measured restitutions admit: draws of the posterior instead of one best contact.

Two numbers do not determine an adhesive, damped contact; a curve of e against the speed hardly
does. What is left open comes out as an array of contacts, which every model takes as it takes one.

`calibrate` draws by the ring force, `calibrate_laws` by several laws with the weights of a fit.
In units of its capture velocity a law of contact has one to three parameters, of which
`microimpact.model.empirical.shapes` has tables. These and v_c are drawn from the likelihood of the
fit, of sizes that scatter and speeds with errors, too. Similarity gives the work of adhesion and
the other fields of a contact of the bodies at hand, exactly: at one size the laws agree with the
data, at others each goes its way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Any, Literal

import numpy as np
import scipy

from microimpact.core import ensemble
from microimpact.core.arrays import POSITIVE, FloatArray, Numbers, Range
from microimpact.core.nearest import nearest
from microimpact.core.readable import Readable
from microimpact.model.choices import INTERVAL
from microimpact.model.contact import Contact, require_contact
from microimpact.model.contact_laws import RING_FORCE
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.empirical import scatter, shapes
from microimpact.model.empirical.comparison import LEAST, Comparison, compare_models, sorted_data
from microimpact.model.empirical.data import (
    LARGEST_SIZE_SCATTER,
    SMALLEST_SIZE_SCATTER,
    DataSets,
    measurements,
)
from microimpact.model.empirical.kernel import LN_SIGMA, LN_SIZE, PARAMETERS, SCATTERED

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
LAWS = ("ring force", "viscous JKR", "Thornton-Ning", "hysteresis")

RESTITUTION = Range(lower=0.0, upper=1.0, lower_closed=True, upper_closed=True)

# Misfits that chance brings about more rarely are told.
REJECTED = 0.01
# Steps of the sampler by the ring force, and by free variable of several laws; if need be they are
# doubled, twice at most.
STEPS, STEPS_EACH, DOUBLINGS = 450, 350, 2
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
    misfit
        Of the best contact.
    effective_size, split_r_hat
        Of the sampler: independent draws that its steps are worth, and per free field the spread
        between the halves of the chains against that within.
    """

    contact: Contact
    best: Contact
    free: tuple[str, ...]
    misfit: Misfit
    effective_size: float
    split_r_hat: Mapping[str, float]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to trust the draws, in sentences."""
        return self.misfit.warnings

    def summary(self) -> str:
        """Misfit, state of the sampler and range of each free field, as text."""
        number = self.contact.shape[0]
        lines = [f"{number} draws; {self.misfit}; effective size {self.effective_size:.0f}"]
        for name in self.free:
            low, middle, high = np.quantile(getattr(self.contact, name), INTERVAL)
            lines.append(
                f"{name} {middle:.4g} [{low:.4g}, {high:.4g}] (median, 95 %), "
                f"split R-hat {self.split_r_hat[name]:.3f}"
            )
        return "\n".join(lines)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class LawDraws(Readable):
    """Contacts by several laws; ``str(draws)`` is a summary.

    Attributes
    ----------
    contacts
        By law, the heaviest first: a contact whose fields are arrays of as many draws as the
        weight of the law makes.
    best
        By law the draw of the highest density.
    comparison
        The fit of these laws to the same data, with their weights.
    misfit
        Of the best law; under scatter approximately.
    """

    contacts: Mapping[str, Contact]
    best: Mapping[str, Contact]
    comparison: Comparison
    misfit: Misfit

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons not to trust the draws, in sentences."""
        return (*self.misfit.warnings, *self.comparison.warnings)

    def of_all(self, quantity: Callable[[Contact], Any]) -> FloatArray:
        """Return a quantity of all draws, joined along the last axis."""
        return np.concatenate([np.asarray(quantity(c)) for c in self.contacts.values()], axis=-1)

    def summary(self) -> str:
        """Weight and number of draws of each law, and the misfit of the best, as text."""
        weights = {model.name: model.weight for model in self.comparison.models}
        lines = [
            f"{name}: weight {weights[name]:.2f}, {contact.shape[0]} draws"
            for name, contact in self.contacts.items()
        ]
        return "\n".join([*lines, f"{self.comparison.models[0].name}: {self.misfit}"])


def calibrate(
    contact: Contact,
    v: Numbers,
    e: Numbers,
    sigma: Numbers,
    free: Iterable[str] = FREE,
    *,
    draws: int = 400,
    seed: int = 0,
) -> Calibration:
    """Draw the contacts by the ring force that measured restitutions in normal impacts admit.

    `calibrate_laws` does not suppose this law. The likelihood is normal in e. Before the data the
    logarithms of w_A, from 0.001 to 10 J/m2, and of c_A v, from 0.001 to 1000, are uniform, and so
    are c_H v up to 10, which adds to the loss, and n up to 1; v is the highest speed.

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
    draws
        How many are returned.
    seed
        Of all random numbers, 0 or more.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another kind, shape or range.
    NoConvergenceError
        If the chains have not come together.

    Examples
    --------
    >>> found = calibrate(contact, v=[0.3, 0.8, 1.7], e=[0.45, 0.69, 0.70], sigma=0.02)
    >>> capture_velocity(found.contact).shape
    (400,)
    """
    require_contact(contact, pair=True)
    _require_single(contact, draws, seed)
    names = free_fields(free)
    speed, target, error = measurements(v, e, sigma, RESTITUTION, POSITIVE)
    if speed.size < 2:
        raise ValueError(f"v and e must hold two measurements or more, got {speed.size}")
    if "adhesion_rate_exponent" in names and contact.reference_velocity is None:
        contact = contact.replace(reference_velocity=float(np.exp(np.mean(np.log(speed)))))
    fastest = float(speed.max())
    ends = np.array([RANGES[name] for name in names])
    ends /= np.array([[fastest if name in PER_SPEED else 1.0] for name in names])
    logs = np.array([name in LOGARITHMIC for name in names])
    ends[logs] = np.log(ends[logs])

    def contacts(points: FloatArray) -> Contact:
        values = np.where(logs, np.exp(np.where(logs, points, 0.0)), points)
        return contact.replace(**dict(zip(names, values.T[..., None], strict=True)))

    def log_likelihood(points: FloatArray) -> FloatArray:
        e = normal_impact(contacts(points), speed).coefficient_of_restitution
        return np.asarray(-0.5 * np.sum(np.square((e - target) / error), axis=1))

    chain = _chain(log_likelihood, ends.T[0], ends.T[1], names, draws=draws, steps=STEPS, seed=seed)
    chosen = contacts(chain.points)
    arrays = {name: getattr(chosen, name)[:, 0] for name in names}
    best = int(np.argmax(chain.log_density))
    return Calibration(
        contact=contact.replace(**arrays),
        best=contact.replace(**{name: float(value[best]) for name, value in arrays.items()}),
        free=names,
        misfit=Misfit(RING_FORCE, -2.0 * chain.log_density.max(), speed.size - len(names)),
        effective_size=chain.effective_size,
        split_r_hat=dict(zip(names, chain.split_r_hat.tolist(), strict=True)),
    )


def calibrate_laws(
    contact: Contact,
    v: Numbers,
    e: Numbers,
    sigma: Numbers,
    sigma_v: Numbers | None = None,
    d: Numbers | None = None,
    size_scatter: Numbers | Literal["free"] | None = None,
    *,
    draws: int = 400,
    seed: int = 0,
    progress: Callable[[str], object] | None = None,
) -> LawDraws:
    """Draw contacts by several laws from measured restitutions in normal impacts.

    v_c, the damping groups, or the one parameter of another law, are drawn with uniform
    logarithms, n from 0 to 2. Where the best law leaves more scatter than sigma admits, sigma is
    taken larger by that much, as in `compare_models`.

    Parameters
    ----------
    contact
        Bodies, friction, and the diameter of the median sphere, unless ``d`` has it; adhesion and
        damping are not used.
    v, e, sigma, sigma_v, d, size_scatter
        Measurements, as of `compare_models`.
    draws
        Number of contacts, shared among the laws by weight.
    seed
        Of all random numbers, 0 or more.
    progress
        Takes a sentence before each law is drawn, how far it is.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another kind, shape or range, or the data are too few to compare laws.
    NoConvergenceError
        If the chains of a law have not come together.

    Examples
    --------
    >>> drawn = calibrate_laws(contact, v, e, sigma=0.02)
    >>> low, high = np.quantile(drawn.of_all(capture_velocity), [0.025, 0.975])
    """
    require_contact(contact, any_law=True, pair=True)
    if contact.damped_attachment:
        raise ValueError("contact must be one without damped_attachment: laws are drawn without it")
    _require_single(contact, draws, seed)
    measured = (v, e, sigma, sigma_v, d, size_scatter)
    comparison = compare_models(*measured, models=LAWS)
    data = sorted_data(*measured)
    if comparison.diameter is not None:
        contact = contact.replace(diameter=comparison.diameter)
    widened = max(1.0, comparison.scatter)
    reference = contact.reference_velocity
    if reference is None:
        reference = data.unit[0] * np.exp(np.mean(np.log(data.v)))
    contacts, best, drawn = {}, {}, 0
    for model, number in zip(comparison.models, _shares(comparison, draws), strict=True):
        if number:
            if progress is not None:
                progress(f"{drawn} of {draws} contacts are drawn, next those of {model.name}")
            drawn += number
            points, highest = _drawn(model.name, data, widened, number, seed)
            all_draws = _contacts(model.name, contact, points, float(reference))
            contacts[model.name] = all_draws
            best[model.name] = all_draws.at(highest)
    return LawDraws(
        contacts=contacts,
        best=best,
        comparison=comparison,
        misfit=_misfit(comparison, data),
    )


def _require_single(contact: Contact, draws: object, seed: object) -> None:
    """Raise TypeError or ValueError unless a contact is one, and numbers of draws are whole."""
    if contact.shape:
        raise ValueError(f"contact must be a single one, got one of shape {contact.shape}")
    for name, value, least in (("draws", draws, 1), ("seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, Integral):
            raise TypeError(f"{name} must be a whole number, got {value!r}")
        if value < least:
            raise ValueError(f"{name} must be at least {least}, got {value}")


def _chain(
    log_density: ensemble.LogDensity,
    low: FloatArray,
    high: FloatArray,
    names: Sequence[str],
    *,
    draws: int,
    steps: int,
    seed: int,
    law: str = "",
) -> ensemble.Draws:
    """Draw in so many steps, or in twice or four times as many if the chains do not agree.

    Raises NoConvergenceError, naming the worst axis, if they still are not worth so many draws.
    """
    most = steps * 2**DOUBLINGS
    chain = ensemble.draw(log_density, low, high, draws=draws, steps=steps, seed=seed)
    while steps < most and not has_converged(chain, draws):
        steps *= 2
        chain = ensemble.draw(log_density, low, high, draws=draws, steps=steps, seed=seed)
    if has_converged(chain, draws):
        return chain
    worst = int(np.argmax(chain.split_r_hat))
    raise NoConvergenceError(
        f"the chains {f'of {law} ' if law else ''}have not come together in {steps} steps: "
        f"they are worth {chain.effective_size:.0f} independent draws, and split R-hat of "
        f"{names[worst]} is {chain.split_r_hat[worst]:.3f}; give fewer draws"
        f"{'' if law else ', or fewer free'}"
    )


def has_converged(chain: ensemble.Draws, draws: int) -> bool:
    """Tell whether chains agree and are worth so many draws."""
    agree = chain.split_r_hat.max() <= LARGEST_R_HAT
    return bool(agree and chain.effective_size >= LEAST_SHARE * draws)


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


def _shares(comparison: Comparison, draws: int) -> list[int]:
    """Draws of each law, by its weight."""
    exact = draws * np.array([model.weight for model in comparison.models])
    numbers = np.floor(exact).astype(int)
    largest = np.argsort(numbers - exact, kind="stable")[: draws - int(numbers.sum())]
    numbers[largest] += 1
    return [int(number) for number in numbers]


def _misfit(comparison: Comparison, data: DataSets) -> Misfit:
    """Misfit of the best law."""
    best = comparison.models[0]
    return Misfit(
        best.name, float(best.chi_square or 0.0), int(np.sum(data.v[0] >= 1.0)) - best.free
    )


def _drawn(
    law: str, data: DataSets, widened: float, draws: int, seed: int
) -> tuple[FloatArray, int]:
    """Places in a law's table and v_c in m/s (draws, 4), and the number of the best of them."""
    last = np.array(shapes.table(law).shape[:PARAMETERS]) - 1.0
    free = np.flatnonzero(last > 0.0)
    low = [*np.zeros(free.size), np.log(LEAST)]
    high = [*last[free], float(np.log(data.reach[0]))]
    scattered = data.scatter is not None and data.scatter.free_size
    if scattered:
        low.append(float(np.log(SMALLEST_SIZE_SCATTER)))
        high.append(float(np.log(LARGEST_SIZE_SCATTER)))

    def places(points: FloatArray) -> FloatArray:
        at = np.zeros((len(points), SCATTERED))
        at[:, free] = points[:, : free.size]
        at[:, LN_SIGMA] = np.log(widened)
        at[:, LN_SIZE] = points[:, -1] if scattered else 0.0
        return at

    def log_likelihood(points: FloatArray) -> FloatArray:
        at, v_c = places(points), np.exp(points[:, free.size])
        if data.scatter is not None:
            return -0.5 * scatter.deviance_at(law, data, v_c, at)
        e = shapes.curve(law, at, shapes.places(data.v / v_c[:, None]))[..., PARAMETERS]
        return np.asarray(-0.5 * np.sum(np.square((e - data.e) * data.weight / widened), axis=1))

    names = [*(f"axis {k}" for k in free), "v_c", "scatter of size"]
    steps = STEPS_EACH * len(low)
    chain = _chain(
        log_likelihood,
        np.array(low),
        np.array(high),
        names,
        draws=draws,
        steps=steps,
        seed=seed,
        law=law,
    )
    at = places(chain.points)[:, :PARAMETERS]
    v_c = data.unit[0] * np.exp(chain.points[:, free.size])
    return np.column_stack([at, v_c]), int(np.argmax(chain.log_density))


def _contacts(law: str, contact: Contact, points: FloatArray, reference: float) -> Contact:
    """Contacts (draws,) of the bodies at hand by places in a law's table and v_c (draws, 4)."""
    axes = shapes.LAWS[law].axes
    first, second = (
        low * (high / low) ** (points[:, k] / max(size - 1, 1))
        for k, (low, high, size) in enumerate(axes, 1)
    )
    v_c, model = points[:, -1], shapes.contact(law, first, second)
    # Speeds of contacts that are alike go as w_A^(5/6).
    slow = contact.replace(work_of_adhesion=1.0, law=None)
    ratio = v_c / capture_velocity(model) * model.velocity_scale / slow.velocity_scale
    work = ratio**1.2
    sized = slow.replace(work_of_adhesion=work)
    if model.law is None:
        n = np.interp(points[:, 0], *_rates(law))
        hertz, adhesion = (group / sized.velocity_scale for group in model.groups)
        return sized.replace(
            hertz_damping=hertz,
            adhesion_damping=adhesion * (v_c / reference) ** n,
            adhesion_rate_exponent=n,
            reference_velocity=reference,
        )
    length, length_of_model = (
        each.equilibrium_contact_radius**2 / each.hertz_radius for each in (sized, model)
    )
    adhesion = work / shapes.WORK
    scale = {
        "viscous_time": length / sized.velocity_scale / (length_of_model / model.velocity_scale),
        "yield_pressure": adhesion * length_of_model / length,
        "unloading_work": adhesion,
    }
    parameters = {name: value * scale[name] for name, value in model.law.parameters.items()}
    return slow.by_law(type(model.law)(**parameters), work)


def _rates(law: str) -> tuple[FloatArray, FloatArray]:
    """Places of the rate exponents in a law's table, and these."""
    rates = shapes.LAWS[law].values[0]
    return np.arange(rates.size, dtype=float), rates
