"""What the numbers behind the claims on the analyses have in common: contacts, samples, tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import wraps

import pandas as pd

from microimpact.declared.parameters import Name
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.samples import Dropped, Sampling, Seen, half_width, seen
from microimpact.model.contact import Contact, resized
from microimpact.statistics.distributions import mean
from microimpact.studies.claims.analysis_claims.params import Params

# Numbers of one claim: by case, then by quantity. The case is empty where nothing is left open.
Numbers = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One of the contacts that the published facts leave open."""

    name: Name
    contact: Contact


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Context:
    """Parameters, tables of earlier studies, and what several claims need.

    Attributes
    ----------
    params
        Parameters of the study.
    inputs
        Tables by name.
    ridge
        Both ends of the family of contacts that the printed numbers leave open.
    """

    params: Params
    inputs: Mapping[str, pd.DataFrame]
    ridge: tuple[Case, ...]
    _seen: dict[tuple[Dropped, float, Sampling], Seen] = field(default_factory=dict)

    @classmethod
    def of(cls, params: Params, inputs: Mapping[str, pd.DataFrame]) -> Context:
        """Return the context of a run."""
        ridge = tuple(
            Case(name=pair.case, contact=calibrated_contact(inputs, pair.case))
            for pair in params.ridge
        )
        return cls(params=params, inputs=inputs, ridge=ridge)

    @property
    def sampling(self) -> Sampling:
        """How samples are drawn."""
        return self.params.samples.sampling(self.params.seed)

    def contact(self, case: str) -> Contact:
        """Return a calibrated contact."""
        return calibrated_contact(self.inputs, case)

    def seen(self, dropped: Dropped, angle: float, sampling: Sampling | None = None) -> Seen:
        """Return what a large sample of virtual impacts shows; drawn once."""
        how = sampling or self.sampling
        key = (dropped, angle, how)
        if key not in self._seen:
            base = self.contact(dropped.case).replace(friction=dropped.friction)
            sphere = resized(base, mean(dropped.diameter_um) * 1e-6)
            self._seen[key] = seen(dropped, sphere, angle, how)
        return self._seen[key]

    def over_half_width(
        self, quantity: str, one: tuple[Dropped, float], other: tuple[Dropped, float]
    ) -> float:
        """Return a difference of means, one less other, over the half-width of its interval.

        Parameters
        ----------
        quantity
            ``restitution``, ``impulse_ratio`` or ``energy_loss``.
        one, other
            What is dropped, and the angle in degrees.
        """
        a, b = (self.seen(*sample).statistics[quantity] for sample in (one, other))
        return (a.mean - b.mean) / half_width(a, b, self.sampling)


def once(compute: Callable[[Context], dict[str, float]]) -> Callable[[Context], Numbers]:
    """Return the numbers of a claim without alternatives."""

    @wraps(compute)
    def numbers(context: Context) -> Numbers:
        return {"": compute(context)}

    return numbers


def on_ridge(
    compute: Callable[[Context, Contact], dict[str, float]],
) -> Callable[[Context], Numbers]:
    """Return the numbers of a claim for both ends of the family."""

    @wraps(compute)
    def numbers(context: Context) -> Numbers:
        return {case.name: compute(context, case.contact) for case in context.ridge}

    return numbers


def by_name(compute: Callable[[Context, str], dict[str, float]]) -> Callable[[Context], Numbers]:
    """Return the numbers of a claim for both ends of the family, looked up by name in tables."""

    @wraps(compute)
    def numbers(context: Context) -> Numbers:
        return {case.name: compute(context, case.name) for case in context.ridge}

    return numbers
