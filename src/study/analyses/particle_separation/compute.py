"""Separation force of an irregular, charged particle against the weight of silica on it.

An analysis beyond the article, after Rimai, Quesnel and Reifenberger 2000 in the same volume, of
whose paper only the abstract is used. Most inputs are ranges; a curve is drawn at their geometric
middles, and its band is what all combinations of low, middle and high span.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field

from microimpact.core.arrays import FloatArray, Real
from microimpact.core.computable import NotComputable
from microimpact.model.separation import (
    PLACEMENTS,
    CoatedParticle,
    adhesion_force,
    carried_share,
    coverage,
    image_force,
    patch_area,
    patch_force,
    touching_spherules,
)
from study.contacts import all_printed
from study.declared.parameters import AboveOne, Fraction, Must, OpenShare, Positive
from study.tables import Row, Tables, series_frame

PRINTED_VALUES = ("separation_force_bare_over_jkr", "separation_force_silica_over_bare")
Span = tuple[Positive, Positive]

# Steps of a twentieth of a per cent.
POINTS = 61


def middle(values: FloatArray, axes: int) -> FloatArray:
    """Return values where every range is at its middle, given the number of ranges."""
    return np.asarray(values[(1,) * axes])


def first_crossing(x: FloatArray, ratio: FloatArray) -> FloatArray:
    """Return x at which a ratio first falls to one, along its last axis; NaN if it never does."""
    below = ratio <= 1.0
    crossing = np.where(below[..., 0], x[0], np.nan)
    crosses = below.any(axis=-1) & ~below[..., 0]
    after = below[crosses].argmax(axis=-1)
    row = np.arange(after.size)
    above, at = (np.log(ratio[crosses][row, after - i]) for i in (1, 0))
    crossing[crosses] = x[after - 1] + above / (above - at) * (x[after] - x[after - 1])
    return crossing


def distance_from_equality(*values: FloatArray) -> FloatArray:
    """Return the factor by which the farthest of some values misses their geometric mean."""
    logarithms = [np.log(each) for each in values]
    mean = sum(logarithms) / len(values)
    return np.asarray(np.exp(reduce(np.maximum, (np.abs(one - mean) for one in logarithms))))


def band_row(
    quantity: str, values: FloatArray, unit: str = "-", *, low: float = np.nan, high: float = np.nan
) -> Row:
    """Return a row of a table: middle, band, and how often given bounds hold.

    ``holds`` is for the middle, ``share`` for all combinations, alike in weight. Without bounds the
    share is that of the combinations in which the quantity exists.

    Parameters
    ----------
    quantity, unit
        What it is.
    values
        At every combination, shape (3, ..., 3); NaN where it does not exist.
    low, high
        Bounds of a statement; one that is not given excludes nothing.
    """
    bounded = np.isfinite(low) or np.isfinite(high)
    exists = np.isfinite(values)
    inside = exists & ~((values < low) | (values > high))
    present = values[exists] if exists.any() else np.array([np.nan])
    centre = (1,) * values.ndim
    return {
        "quantity": quantity,
        "middle": float(values[centre]),
        "low": float(present.min()),
        "high": float(present.max()),
        "unit": unit,
        "bound_low": low,
        "bound_high": high,
        "holds": ("yes" if inside[centre] else "no") if bounded else "",
        "share": float(inside.mean()),
        "evidence": "computed",
    }


# SI units per unit in the name of a span.
SCALES = {
    "work_of_adhesion_J_per_m2": 1.0,
    "youngs_modulus_GPa": 1e9,
    "particle_density_kg_per_m3": 1.0,
    "surface_factor": 1.0,
    "silica_diameter_nm": 1e-9,
    "charge_to_mass_uC_per_g": 1e-3,
    "image_enhancement": 1.0,
    "patch_share": 1.0,
    "breakdown_field_V_per_um": 1e6,
}
# All combinations: an axis per range, and one for the placement, whose middle is "even".
SHAPE = (3,) * len(SCALES) + (len(PLACEMENTS),)

ADHESION, UNIFORM, PATCHES = "adhesion", "uniform charge", "charged patches"


@dataclass(frozen=True, slots=True, kw_only=True)
class Params:
    """Sizes, ranges as (low, high), and tolerances of agreement with the abstract."""

    diameter_um: Positive
    poissons_ratio: Annotated[float, Field(ge=0, le=0.5)]
    silica_density_kg_per_m3: Positive
    work_of_adhesion_J_per_m2: Span  # noqa: N815 (the unit)
    youngs_modulus_GPa: Span  # noqa: N815 (the unit)
    particle_density_kg_per_m3: Span
    surface_factor: Span
    silica_diameter_nm: Span
    charge_to_mass_uC_per_g: Span  # noqa: N815 (the unit)
    image_enhancement: Span
    patch_share: Span
    breakdown_field_V_per_um: Span  # noqa: N815 (the unit)
    largest_silica_fraction: OpenShare
    compared_silica_fraction: Annotated[Fraction, Must("at most", "largest_silica_fraction")]
    far_exceeds_factor: AboveOne
    about_factor: AboveOne

    def __post_init__(self) -> None:
        """Refuse a range upside down, and more than all patches."""
        for name in SCALES:
            low, high = getattr(self, name)
            if low > high:
                raise ValueError(f"{name}: [{low:g}, {high:g}] must ascend")
        if self.patch_share[1] > 1.0:
            raise ValueError(f"patch_share: {self.patch_share[1]:g} must be at most 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Combinations:
    """All combinations of the ranges: the particle, its charge, and how the charge lies."""

    particle: CoatedParticle
    charge_to_mass: Real
    enhancement: Real
    patch_share: Real
    breakdown_field: Real

    @property
    def charge(self) -> Real:
        """Of a particle, C."""
        volume = 4.0 / 3.0 * np.pi * np.power(self.particle.radius, 3)
        return self.charge_to_mass * self.particle.density * volume


def run(params: Params, inputs: Tables) -> Tables:
    """Compute adhesion and both estimates of the electric force against the weight of silica.

    ``separation``: force in nN against silica in per cent of weight, with bands.
    ``particle_separation``: forces and ratios without and with silica, each with its band; the
    abstract's statements, whether they hold at the middles of the ranges and in what share of their
    combinations (not a probability: the combinations are not weighted). Raises ValueError if the
    charge does not fit on the particle at the density that breakdown allows.
    """
    case = combinations(params)
    stated = all_printed(inputs)
    silica = np.linspace(0.0, params.largest_silica_fraction, POINTS)
    return {
        "separation": curves(params, case, silica, stated),
        "particle_separation": summary(params, case, silica, stated),
    }


def combinations(params: Params) -> Combinations:
    """Return low, geometric middle and high of every range, each along an axis of its own."""
    spans = [getattr(params, name) for name in SCALES]
    ends = np.ix_(*([low, np.sqrt(low * high), high] for low, high in spans))
    # The last two axes are those of the placement and of the weight of silica.
    mesh = {
        name: SCALES[name] * end[..., None, None] for name, end in zip(SCALES, ends, strict=True)
    }
    particle = CoatedParticle(
        radius=0.5e-6 * params.diameter_um,
        density=mesh["particle_density_kg_per_m3"],
        surface_factor=mesh["surface_factor"],
        # Silica is so much stiffer than a polymer that the polymer alone yields.
        stiffness=4.0 / 3.0 * mesh["youngs_modulus_GPa"] / (1.0 - params.poissons_ratio**2),
        work_of_adhesion=mesh["work_of_adhesion_J_per_m2"],
        spherule_radius=0.5 * mesh["silica_diameter_nm"],
        spherule_density=params.silica_density_kg_per_m3,
    )
    case = Combinations(
        particle=particle,
        charge_to_mass=mesh["charge_to_mass_uC_per_g"],
        enhancement=mesh["image_enhancement"],
        patch_share=mesh["patch_share"],
        breakdown_field=mesh["breakdown_field_V_per_um"],
    )
    surface = 4.0 * np.pi * np.square(particle.radius)
    if np.any(patch_area(case.charge, case.breakdown_field) > surface):
        raise NotComputable(
            f"breakdown_field_V_per_um {params.breakdown_field_V_per_um}: too low for "
            f"charge_to_mass_uC_per_g {params.charge_to_mass_uC_per_g}; the patches would cover "
            "more than the particle"
        )
    return case


def forces(case: Combinations, silica: FloatArray) -> dict[str, FloatArray]:
    """Return the three forces in N; shapes broadcast to `SHAPE` and the shape of silica.

    The charge is lifted by the diameter of a spherule in so far as spherules carry the contact.
    """
    particle = case.particle
    share = over_placements(lambda p: carried_share(particle, silica, p))
    gap = share * 2.0 * particle.spherule_radius
    image = image_force(case.charge, particle.radius, gap, case.enhancement)
    return {
        ADHESION: over_placements(lambda p: adhesion_force(particle, silica, p)),
        UNIFORM: np.asarray(image),
        PATCHES: patch_force(case.charge, case.patch_share, case.breakdown_field, gap),
    }


def over_placements(compute: Callable[[str], FloatArray]) -> FloatArray:
    """Return the values of a function for every placement of the silica, along an axis."""
    return np.concatenate(np.broadcast_arrays(*map(compute, PLACEMENTS)), axis=-2)


def full(values: Real) -> FloatArray:
    """Return values at every combination of the ranges, and at every weight of silica."""
    return np.broadcast_to(values, SHAPE + np.shape(values)[-1:])


def curves(
    params: Params, case: Combinations, silica: FloatArray, stated: pd.Series[float]
) -> pd.DataFrame:
    """Return the data of the figure: curves with bands, limits of the adhesion, statements."""
    full_forces = {name: full(force) for name, force in forces(case, silica).items()}
    ranges = tuple(range(len(SCALES)))
    frames = []
    for name, force in full_forces.items():
        even = force[..., PLACEMENTS.index("even"), :]
        band = even.min(axis=ranges), even.max(axis=ranges)
        frames.append(_frame(name, silica, middle(even, len(SCALES)), *band))
    limits = middle(full_forces[ADHESION], len(SCALES))
    for placement in ("random", "lifted"):
        curve = limits[PLACEMENTS.index(placement)]
        frames.append(_frame(f"{ADHESION}, {placement}", silica, curve))
    bare = full_forces[ADHESION][..., 0]
    factors = stated[["separation_force_bare_over_jkr", "separation_force_silica_over_bare"]]
    at = np.array([0.0, params.compared_silica_fraction])
    mark, low, high = (
        factors.to_numpy(float) * force
        for force in (middle(bare, len(SHAPE)), bare.min(), bare.max())
    )
    frames.append(_frame("stated", at, mark, low, high, evidence="printed"))
    return pd.concat(frames, ignore_index=True)


def summary(
    params: Params, case: Combinations, silica: FloatArray, stated: pd.Series[float]
) -> pd.DataFrame:
    """Return forces and ratios with bands, and the bounds that the abstract sets to some."""
    x = params.compared_silica_fraction
    at = {name: full(force) for name, force in forces(case, np.array([0.0, x])).items()}
    bare, coated = ({name: force[..., i] for name, force in at.items()} for i in (0, 1))
    far, about = params.far_exceeds_factor, params.about_factor
    excess, within_excess = (
        {f"{ADHESION} over {name}": of[ADHESION] / of[name] for name in (UNIFORM, PATCHES)}
        for of in (bare, coated)
    )
    without, within = (
        [band_row(name, force * 1e9, "nN") for name, force in of.items()] for of in (bare, coated)
    )
    without += [band_row(name, factor, low=far) for name, factor in excess.items()]
    within += [band_row(name, factor) for name, factor in within_excess.items()]
    left = coated[ADHESION] / bare[ADHESION]
    value = float(stated["separation_force_silica_over_bare"])
    equality = distance_from_equality(*coated.values())
    charge = full(case.charge_to_mass)[..., 0] * np.sqrt(coated[ADHESION] / coated[UNIFORM])
    low, high = params.charge_to_mass_uC_per_g
    within += [
        band_row(f"{ADHESION} over bare", left, low=value / about, high=value * about),
        band_row("distance from equality", equality, high=about),
        band_row("charge to mass for equality", charge * 1e3, "uC/g", low=low, high=high),
        band_row("layers of silica", full(coverage(case.particle, x))[..., 0]),
    ]
    held = [*(factor >= far for factor in excess.values()), equality <= about]
    held.append((left >= value / about) & (left <= value * about))
    anywhere = _any_silica(case, silica)
    anywhere.append(band_row("statements that hold, of four", np.sum(held, axis=0), low=4.0))
    table = pd.DataFrame([*without, *within, *anywhere])
    counts = len(without), len(within), len(anywhere)
    table.insert(1, "silica_percent", np.repeat([0.0, 100.0 * x, np.nan], counts))
    return table


def _any_silica(case: Combinations, silica: FloatArray) -> list[Row]:
    """Return where the forces meet, and the forces with a full layer of silica."""
    case_forces = forces(case, silica)
    rows = []
    for name in (UNIFORM, PATCHES):
        where = first_crossing(silica, full(case_forces[ADHESION] / case_forces[name]))
        rows.append(band_row(f"silica where {ADHESION} meets {name}", 100.0 * where, "percent"))
    touching = full(touching_spherules(case.particle))[..., 0]
    left = touching * full(case.particle.spherule_radius / case.particle.radius)[..., 0]
    return [
        *rows,
        band_row(f"{ADHESION} over bare, full layer", left),
    ]


def _frame(
    series: str,
    silica: FloatArray,
    force: FloatArray,
    low: Real = np.nan,
    high: Real = np.nan,
    evidence: str = "computed",
) -> pd.DataFrame:
    y, *ends = (1e9 * np.asarray(of) for of in (force, low, high))
    return series_frame(
        "forces", series, 100.0 * silica, y, evidence, *ends, x_unit="percent", y_unit="nN"
    )
