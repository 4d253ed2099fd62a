"""Contacts that measured restitutions admit: draws of the posterior instead of one best contact.

Two numbers do not determine an adhesive, damped contact; a curve of e against the speed hardly
does. What is left open comes out as an array of contacts, which every model takes as it takes one.

`calibrate_laws` draws by several laws with the weights of a fit. In units of its capture velocity a
law of contact has one to three parameters, of which `microimpact.model.empirical.shapes` has
tables. These and v_c are drawn from the likelihood of the fit, of sizes that scatter and speeds
with errors, too. Similarity gives the work of adhesion and the other fields of a contact of the
bodies at hand, exactly: at one size the laws agree with the data, at others each goes its way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy

from microimpact.core import ensemble
from microimpact.core.arrays import FloatArray, Numbers, whole
from microimpact.core.readable import Readable
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.empirical import scatter, shapes
from microimpact.model.empirical.comparison import (
    LEAST,
    Comparison,
    compare_models,
    require_names,
    sorted_data,
)
from microimpact.model.empirical.data import (
    LARGEST_SIZE_SCATTER,
    SMALLEST_SIZE_SCATTER,
    DataSets,
)
from microimpact.model.empirical.kernel import LN_SIGMA, LN_SIZE, PARAMETERS, SCATTERED

LAWS = ("ring force", "viscous JKR", "Thornton-Ning", "hysteresis")
DRAWN = (*LAWS, shapes.EDGE)

# Misfits that chance brings about more rarely are told.
REJECTED = 0.01
# Steps of the sampler by free variable; if need be they are doubled, twice at most.
STEPS_EACH, DOUBLINGS = 350, 2
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


def calibrate_laws(
    contact: Contact,
    v: Numbers,
    e: Numbers,
    sigma: Numbers | None = None,
    sigma_v: Numbers | None = None,
    d: Numbers | None = None,
    size_scatter: Numbers | Literal["free"] | None = None,
    *,
    laws: Sequence[str] = LAWS,
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
    laws
        Names of laws of contact, of `LAWS` and `microimpact.model.empirical.shapes.EDGE`.
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
    require_names("laws", laws, DRAWN)
    measured = (v, e, sigma, sigma_v, d, size_scatter)
    comparison = compare_models(*measured, models=laws)
    data = sorted_data(*measured)
    if comparison.diameter is not None:
        contact = contact.replace(diameter=comparison.diameter)
    # Where sigma is not given, the data are in units of 1.
    widened = comparison.sigma or max(1.0, comparison.scatter)
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
    whole("draws", draws, 1)
    whole("seed", seed, 0)


def _chain(
    law: str,
    log_density: ensemble.LogDensity,
    low: FloatArray,
    high: FloatArray,
    names: Sequence[str],
    *,
    draws: int,
    seed: int,
) -> ensemble.Draws:
    """Draw in `STEPS_EACH` per axis, or in twice or four times as many if the chains do not agree.

    Raises NoConvergenceError, naming the worst axis, if they do not agree even then.
    """
    steps = STEPS_EACH * len(low)
    most = steps * 2**DOUBLINGS
    chain = ensemble.draw(log_density, low, high, draws=draws, steps=steps, seed=seed)
    while steps < most and not has_converged(chain, draws):
        steps *= 2
        chain = ensemble.draw(log_density, low, high, draws=draws, steps=steps, seed=seed)
    if has_converged(chain, draws):
        return chain
    worst = int(np.argmax(chain.split_r_hat))
    raise NoConvergenceError(
        f"the chains of {law} have not come together in {steps} steps: they are worth "
        f"{chain.effective_size:.0f} independent draws, and split R-hat of {names[worst]} is "
        f"{chain.split_r_hat[worst]:.3f}; give fewer draws"
    )


def has_converged(chain: ensemble.Draws, draws: int) -> bool:
    """Tell whether chains agree and are worth `LEAST_SHARE` of the draws."""
    agree = chain.split_r_hat.max() <= LARGEST_R_HAT
    return bool(agree and chain.effective_size >= LEAST_SHARE * draws)


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
            return -0.5 * scatter.deviance_at(law, data, np.zeros(len(at), int), v_c, at)
        e = shapes.curve(law, at, shapes.places(data.v / v_c[:, None]))[..., PARAMETERS]
        return np.asarray(-0.5 * np.sum(np.square((e - data.e) * data.weight / widened), axis=1))

    names = [*(f"axis {k}" for k in free), "v_c", "scatter of size"]
    ends = np.array(low), np.array(high)
    chain = _chain(law, log_likelihood, *ends, names, draws=draws, seed=seed)
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
    n = np.interp(points[:, 0], *_rates(law))
    v_c, model = points[:, -1], shapes.contact(law, first, second, n)
    # Speeds of contacts that are alike go as w_A^(5/6).
    slow = contact.replace(work_of_adhesion=1.0, law=None)
    ratio = v_c / capture_velocity(model) * model.velocity_scale / slow.velocity_scale
    work = ratio**1.2
    sized = slow.replace(work_of_adhesion=work)
    if model.law is None:
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
    edge, edge_of_model = (
        each.velocity_scale * each.hertz_radius / each.equilibrium_contact_radius
        for each in (sized, model)
    )
    scale = {
        "edge_speed": edge / edge_of_model,
        "edge_exponent": 1.0,
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
