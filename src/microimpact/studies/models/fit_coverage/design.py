"""Design of the study of Eq. (34): parameters, and the cells that they span."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Annotated

from pydantic import Field

from microimpact.declared.parameters import CaseName, Count, Keyed, Positive
from microimpact.studies.models.fit_coverage.intervals import Methods
from microimpact.studies.models.fit_coverage.truths import TRUTHS, TruthName, Variant

AboveCapture = Annotated[float, Field(gt=1, allow_inf_nan=False)]
Open = Annotated[float, Field(gt=0, lt=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """The design: the first variant at all levels, the others at the reference levels.

    Speeds are in capture velocities of the nominal sphere, so none may be 1 or less.
    """

    seed: Annotated[int, Field(ge=0)]
    case: CaseName
    fixed_exponent: Positive
    lowest_speeds_in_v_c: tuple[AboveCapture, ...]
    highest_speed_in_v_c: AboveCapture
    noise_of_e: tuple[Positive, ...]
    points: tuple[Annotated[int, Field(ge=8)], ...]
    reference_noise_of_e: Positive
    reference_points: Annotated[int, Field(ge=8)]
    variants: Annotated[tuple[Variant, ...], Keyed("variant")]
    sizes: Annotated[int, Field(ge=3)]
    replicates: Count
    interval_replicates: Count
    starts: Annotated[int, Field(ge=1, le=5)]
    confidence: Annotated[float, Field(ge=0.5, lt=1)]
    methods: Methods

    def __post_init__(self) -> None:
        """Refuse a design without its reference, or with speeds out of order."""
        for name in ("lowest_speeds_in_v_c", "noise_of_e", "points", "variants"):
            if not getattr(self, name):
                raise ValueError(f"{name}: must hold at least one value")
        lowest = max(*self.lowest_speeds_in_v_c, *self.methods.lowest_speeds_in_v_c, 1.0)
        if lowest >= self.highest_speed_in_v_c:
            raise ValueError(
                f"highest_speed_in_v_c: {self.highest_speed_in_v_c:g} must be above every lowest "
                f"speed, of which the largest is {lowest:g}"
            )
        for name in ("noise_of_e", "points"):
            reference, levels = getattr(self, f"reference_{name}"), getattr(self, name)
            if reference not in levels:
                raise ValueError(f"reference_{name}: {reference:g} must be one of {levels}")
        for name in ("interval_replicates", "methods"):
            value = getattr(self, name)
            fewer = value.replicates if isinstance(value, Methods) else value
            if fewer > self.replicates:
                key = "methods.replicates" if isinstance(value, Methods) else name
                raise ValueError(f"{key}: {fewer} must not exceed replicates, {self.replicates}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One combination of the factors; the exponent q is None where it is free."""

    truth: TruthName
    variant: Variant
    noise: float
    points: int
    lowest: float
    q: float | None

    @property
    def factors(self) -> dict[str, object]:
        """Its columns in a table."""
        return {
            "truth": self.truth,
            "variant": self.variant.variant,
            "noise_of_e": self.noise,
            "points": self.points,
            "lowest_speed_in_v_c": self.lowest,
            "exponent": "free" if self.q is None else "fixed",
        }


def cells(params: Params) -> Iterator[Cell]:
    """All cells, in pairs with q free and fixed."""
    for number, variant in enumerate(params.variants):
        noise = params.noise_of_e if number == 0 else (params.reference_noise_of_e,)
        points = params.points if number == 0 else (params.reference_points,)
        factors = (
            TRUTHS,
            noise,
            points,
            params.lowest_speeds_in_v_c,
            (None, params.fixed_exponent),
        )
        for truth, sigma, count, lowest, q in product(*factors):
            yield Cell(truth=truth, variant=variant, noise=sigma, points=count, lowest=lowest, q=q)


def method_cells(params: Params) -> Iterator[Cell]:
    """Cells in which methods of intervals are compared."""
    lowest = params.methods.lowest_speeds_in_v_c
    for truth, speed, q in product(TRUTHS, lowest, (None, params.fixed_exponent)):
        yield Cell(
            truth=truth,
            variant=params.variants[0],
            noise=params.reference_noise_of_e,
            points=params.reference_points,
            lowest=speed,
            q=q,
        )
