"""A pair whose contact is open: its free parameters, printed values and posterior."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from microimpact.core import ensemble
from microimpact.core.arrays import FloatArray
from microimpact.model.choices import FrictionBasis
from microimpact.model.contact import Contact
from microimpact.statistics.distributions import generator
from study.declared.parameters import (
    Ascending,
    CaseName,
    Count,
    CounterpartName,
    MaterialName,
    Name,
    NonNegative,
    Positive,
    PositiveRange,
)
from study.studies.contacts import declared_contact
from study.studies.models.admissible_contacts.statements import (
    Evaluation,
    Likelihood,
    NoCapture,
    Statement,
    Statements,
    Within,
    dissipation_ratio,
    impacts_of,
)
from study.tables import Tables

# Parameters that can be open, and the field of a contact that each is.
FIELDS = {
    "work_of_adhesion_J_per_m2": "work_of_adhesion",
    "hertz_damping_s_per_m": "hertz_damping",
    "adhesion_damping_s_per_m": "adhesion_damping",
    "rate_exponent": "adhesion_rate_exponent",
    "friction": "friction",
}
# Those whose logarithm is uniform before the statements.
LOGARITHMIC = ("work_of_adhesion_J_per_m2", "adhesion_damping_s_per_m")
# Ends of what may vanish.
Span = Annotated[tuple[NonNegative, Positive], Ascending]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranges:
    """Ends of the open parameters; None where the pair declares them.

    The logarithms of w_A and c_A are uniform before the statements, for not even their order is
    known; c_H is so itself, for it adds to the loss: no share of the material is preferred.
    """

    work_of_adhesion_J_per_m2: PositiveRange | None = None  # noqa: N815 (the unit)
    hertz_damping_s_per_m: Span | None = None
    adhesion_damping_s_per_m: PositiveRange | None = None
    rate_exponent: Span | None = None
    friction: PositiveRange | None = None

    def open(self) -> dict[str, tuple[float, float]]:
        """Ends of the open parameters by name."""
        return {name: ends for name in FIELDS if (ends := getattr(self, name)) is not None}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A pair, its open parameters, and the printed statements on it."""

    # The materials; what is not open is as declared of the pair.
    particle: MaterialName
    surface: CounterpartName
    # Where derived numbers are told; the speed is the reference velocity of the rate exponent.
    diameter_um: Positive
    speed_m_per_s: Positive
    ranges: Ranges  # Of the open parameters
    # Diameters where a statement gives none.
    classes_um: Annotated[tuple[Positive, ...], Field(min_length=2)]
    # Normal forces that Coulomb's law may take.
    friction_bases: Annotated[tuple[FrictionBasis, ...], Field(min_length=1)]
    shown_m_per_s: PositiveRange  # Normal speeds of the figures
    compared: tuple[CaseName, ...]  # Cases of the two-stage calibration to be compared with
    # What is printed.
    statements: dict[Name, Within]
    no_capture: dict[Name, NoCapture] = field(default_factory=dict)

    @property
    def all_statements(self) -> dict[str, Statement]:
        """Statements of both sorts, by name."""
        return {**self.statements, **self.no_capture}

    def printed_limits(self) -> list[float]:
        """Middles of the stated capture velocities of an open size, m/s."""
        stated = self.statements.values()
        return [0.5 * sum(s.interval) for s in stated if s.of_capture and not s.diameter_um]

    def printed_restitutions(self) -> Iterator[tuple[float, float, tuple[float, float]]]:
        """Diameter (um), normal speed (m/s) and interval of each restitution that is stated."""
        for statement in self.statements.values():
            if statement.quantity == "restitution":
                for size, speed, _ in impacts_of(statement, self.classes_um):
                    yield size, speed, statement.interval

    def __post_init__(self) -> None:
        """Refuse diameters at which no capture velocity is computed."""
        diameters = {n: s.diameter_um for n, s in self.statements.items() if s.of_capture}
        for name, size in {"diameter_um": self.diameter_um, **diameters}.items():
            if size not in {None, *self.classes_um}:
                raise ValueError(f"{name}: {size} must be one of classes_um {self.classes_um}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """Statements that are left out; a case need not have them."""

    without: tuple[Name, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampler:
    """How the ensemble draws."""

    # Binary logarithm of the number of points among which walkers find their starts.
    spread: Annotated[int, Field(ge=8, le=20)]
    # Of each of its ensembles.
    walkers: Annotated[int, Field(ge=12)]
    steps: Annotated[int, Field(ge=30)]
    pool: Count  # Draws whose capture velocities are computed


@dataclass(frozen=True, slots=True, kw_only=True)
class Posterior:
    """A pool of draws by the statements on impacts, with the likelihoods of all statements."""

    name: str  # Of the case
    case: Case  # The pair
    evaluation: Evaluation  # How statements are evaluated
    pool: ensemble.Draws  # The draws
    quantities: Mapping[str, FloatArray]  # By statement
    limits: FloatArray  # Capture velocities (n, classes), m/s
    seed: int  # Of what is drawn from the pool

    def likelihood(self, statements: Statements) -> Likelihood:
        """Return the log-likelihood of the pool by some statements."""
        return self.evaluation.likelihood(statements, self.quantities)

    def stated(self, without: Collection[str]) -> Statements:
        """All statements but some, by name."""
        return {n: s for n, s in self.case.all_statements.items() if n not in without}

    def weights(self, without: Collection[str]) -> FloatArray:
        """Weights of the pool by all statements but some, the largest 1."""
        all_of = self.likelihood(self.stated(without)).total
        logs = all_of - self.likelihood(on_impacts(self.case)).total
        return np.exp(logs - np.max(logs))

    def chosen(self, variant: str, without: tuple[str, ...], draws: int) -> Chosen:
        """Draw from the pool by its weights, and class and basis of each by their likelihoods."""
        rng = generator(self.seed, 1)
        taken = ensemble.resampled(self.weights(without), draws, rng)
        logs = self.likelihood(self.stated(without))
        classes, bases = _one_each(logs.by_class[taken], rng), _one_each(logs.by_basis[taken], rng)
        rows = np.arange(draws)
        return Chosen(
            variant=variant,
            without=without,
            taken=taken,
            points=self.pool.points[taken],
            classes=classes,
            bases=bases,
            log_likelihood=logs.plain[taken]
            + logs.by_class[taken][rows, classes]
            + logs.by_basis[taken][rows, bases],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """Draws of one variant (n,)."""

    variant: str
    without: tuple[str, ...]  # Statements that it leaves out
    taken: FloatArray  # Their numbers in the pool
    points: FloatArray  # As sampled (n, axes)
    # Numbers of size class and basis of friction.
    classes: FloatArray
    bases: FloatArray
    log_likelihood: FloatArray  # Of all statements of the variant, class and basis being these


def _one_each(logs: FloatArray, rng: np.random.Generator) -> Any:
    """Draw a column index per row, with probabilities in proportion to exp(logarithms)."""
    share = np.cumsum(np.exp(logs - np.max(logs, axis=1, keepdims=True)), axis=1)
    return np.argmax(share > rng.random((len(logs), 1)) * share[:, -1:], axis=1)


def on_impacts(case: Case) -> Statements:
    """Statements that need no capture velocity."""
    return {name: s for name, s in case.all_statements.items() if not s.of_capture}


def bare_contact(case: Case, inputs: Tables) -> Contact:
    """Return the declared contact of the pair, with w_A of its declared diameter."""
    declared = declared_contact(inputs, case.particle, case.surface)
    return declared.replace(
        diameter=case.diameter_um * 1e-6,
        work_of_adhesion=declared.work_of_adhesion,
        reference_velocity=case.speed_m_per_s,
    )


def values(case: Case, points: FloatArray) -> dict[str, FloatArray]:
    """Open parameters by name (n,) from points as sampled (n, axes)."""
    return {
        name: np.exp(column) if name in LOGARITHMIC else column
        for name, column in zip(case.ranges.open(), points.T, strict=True)
    }


def contacts(case: Case, bare: Contact, points: FloatArray, diameters_um: FloatArray) -> Contact:
    """Contacts of points (n, axes) at diameters (k,): fields of shape (n, k)."""
    fields = {FIELDS[name]: value[:, None] for name, value in values(case, points).items()}
    work = fields.pop("work_of_adhesion", bare.work_of_adhesion)
    return bare.replace(diameter=diameters_um * 1e-6, work_of_adhesion=work, **fields)


def posterior(name: str, case: Case, inputs: Tables, sampler: Sampler, seed: int) -> Posterior:
    """Draw the pool of a case and evaluate all statements."""
    bare = bare_contact(case, inputs)
    ends = case.ranges.open()
    ratio = next(
        (
            dissipation_ratio(
                bare,
                s.speeds_m_per_s[0],
                ends["hertz_damping_s_per_m"],
                ends["adhesion_damping_s_per_m"],
            )
            for s in case.statements.values()
            if s.quantity == "dissipation over adhesion"
        ),
        None,
    )
    evaluation = Evaluation(
        contacts=lambda points, diameters: contacts(case, bare, points, diameters),
        classes_um=case.classes_um,
        bases=case.friction_bases,
        ratio=ratio,
    )
    stated = on_impacts(case)
    box = np.array([np.log(e) if n in LOGARITHMIC else e for n, e in ends.items()])
    pool = ensemble.draw(
        lambda points: evaluation.likelihood(stated, evaluation.quantities(points, stated)).total,
        *box.T,
        draws=sampler.pool,
        spread=sampler.spread,
        walkers=sampler.walkers,
        steps=sampler.steps,
        seed=seed,
    )
    limits = evaluation.limits(pool.points)
    return Posterior(
        name=name,
        case=case,
        evaluation=evaluation,
        pool=pool,
        quantities=evaluation.quantities(pool.points, case.all_statements, limits),
        limits=limits,
        seed=seed,
    )
