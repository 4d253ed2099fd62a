"""Numbers of the claims of Section 4.3: effects of designed experiments on the capture velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.statistics.effects import effects as contrasts
from microimpact.statistics.effects import lenth
from study.analyses.fig24_25_doe.compute import PAIR
from study.analyses.fig24_25_doe.factors import LETTERS, at_levels, coded
from study.claims.claim import RIDGE, Claim, Number
from study.claims.context import Context, Numbers

REALISTIC, SMALL = "realistic", "uniform"


@dataclass(frozen=True, slots=True)
class Effects:
    """Effects (contacts,) that the fractional design estimates, in % of the mean, by their words.

    With what the design does not tell from them, and Lenth's margin of one effect (contacts,).
    """

    percent: dict[str, FloatArray]
    aliases: dict[str, str]
    margin: FloatArray


@Claim(
    "C53",
    (
        "With realistic levels the radius and the work of adhesion dominate the capture velocity; "
        "the radius lowers it, the work of adhesion raises it."
    ),
    says=(
        "The effect of the radius is {effect_of_radius_over_margin} times the margin and that of "
        "the work of adhesion {effect_of_work_of_adhesion_over_margin} times; the smaller of both "
        "is {smaller_of_both_over_largest_other_effect} times the largest other effect, where "
        "{smaller_of_both_over_largest_other_effect:bound} would dominate."
    ),
    where="4.3, Fig. 24",
    quote="factors C, microsphere radius, and B, Dupré surface energy, stand out",
    article="C negative and B positive, both outstanding",
    numbers={
        "effect_of_radius_over_margin": Number("effect of radius / margin", at_most=-1.0),
        "effect_of_work_of_adhesion_over_margin": Number(
            "effect of work of adhesion / margin", at_least=1.0
        ),
        "smaller_of_both_over_largest_other_effect": Number(
            "smaller of the two / largest other effect", at_least=1.001
        ),
        "log_range_of_work_of_adhesion_over_that_of_damping": Number(
            "logarithmic range of work of adhesion / of damping"
        ),
        "log_range_at_which_both_have_one_effect": Number(
            "logarithmic range at which both effects are equal"
        ),
    },
    reason=(
        "An effect stands out if it exceeds Lenth's margin of one effect, and it dominates if no "
        "third effect or interaction is larger. The realistic levels are not printed, so two sets "
        "are cases."
    ),
    cases=(
        "steel-silicon, n = 0, levels of this study",
        "steel-silicon, n = 0, levels of 5 %",
        "steel-silicon, n = 1, levels of this study",
        "steel-silicon, n = 1, levels of 5 %",
    ),
    figures="fig24",
    external=("surface energy and radius play by far the greatest part",),
    by_contact=True,
)
def c53(context: Context) -> Numbers:
    """Effects of radius and adhesion against all others, at two sets of levels.

    Beside them, how much wider the work of adhesion would have to vary to match the damping.
    """
    return {
        "levels of this study": ranking(context, REALISTIC),
        "levels of 5 %": ranking(context, SMALL),
    }


def ranking(context: Context, variation: str) -> Numbers:
    """Return how the effects of radius and work of adhesion rank at one set of levels."""
    effects = fraction(context, variation)
    slope = context.table("doe_elasticities").set_index("factor")["at_fixed_zeta"]
    levels = context.table("doe_levels", variation=variation).set_index("factor")
    ranges = np.log(levels["high_multiple"] / levels["low_multiple"])
    margin = effects.margin
    others = [size for word, size in effects.percent.items() if word not in ("B", "C")]
    return {
        "effect_of_radius_over_margin": effect(effects, "C") / margin,
        "effect_of_work_of_adhesion_over_margin": effect(effects, "B") / margin,
        "smaller_of_both_over_largest_other_effect": leading(effects)
        / np.max(np.abs(others), axis=0),
        "log_range_of_work_of_adhesion_over_that_of_damping": ranges["B"] / ranges["D"],
        "log_range_at_which_both_have_one_effect": slope["D"] / slope["B"],
    }


@Claim(
    "C54",
    (
        "With levels of plus and minus 5 % the effects of the stiffness and of the adhesion "
        "damping stand out from the interactions as well."
    ),
    says=(
        "The effect of the stiffness is {size_of_stiffness_effect_over_margin} times the margin "
        "and that of the adhesion damping {size_of_adhesive_damping_effect_over_margin} times; "
        "those of radius and adhesion are at least "
        "{smaller_of_radius_and_adhesion_over_larger_of_these} times as large."
    ),
    where="4.3, Fig. 25",
    quote="factors A, Hertzian stiffness, and D, adhesion damping, show significance",
    article="A and D significant as well as B and C",
    numbers={
        "size_of_stiffness_effect_over_margin": Number(
            "effect of stiffness / margin", at_least=1.0
        ),
        "size_of_adhesive_damping_effect_over_margin": Number(
            "effect of adhesion damping / margin", at_least=1.0
        ),
        "smaller_of_radius_and_adhesion_over_larger_of_these": Number(
            "smaller of radius and adhesion effects / larger of stiffness and damping effects",
            at_least=1.001,
        ),
    },
    reason=(
        "Significant means beyond Lenth's margin of one effect; the radius and the work of "
        "adhesion must remain the largest. Computed runs have no error, so the margin is that of "
        "the interactions: an effect, however small, stands out if the interactions are smaller."
    ),
    cases=RIDGE,
    figures="fig25",
    external=("surface energy and radius play by far the greatest part",),
    by_contact=True,
)
def c54(context: Context) -> Numbers:
    """Effects of stiffness and adhesion damping at small levels, over the margin."""
    effects = fraction(context, SMALL)
    margin = effects.margin
    stiffness, damping = (abs(effect(effects, letter)) for letter in "AD")
    return {
        "size_of_stiffness_effect_over_margin": stiffness / margin,
        "size_of_adhesive_damping_effect_over_margin": damping / margin,
        "smaller_of_radius_and_adhesion_over_larger_of_these": leading(effects)
        / np.maximum(stiffness, damping),
    }


@Claim(
    "C55",
    "The interaction of the work of adhesion with the adhesion damping is significant.",
    says=(
        "The interaction BD is {size_of_bd_over_margin} times the margin; significant is "
        "{size_of_bd_over_margin:bound}."
    ),
    where="4.3, Fig. 25",
    quote=(
        "an interaction between Dupré surface energy and adhesion damping, also shows significance"
    ),
    article="BD significant",
    numbers={
        "size_of_bd_over_margin": Number("interaction BD / margin", at_least=1.0),
        "size_of_bd_over_bc": Number("interaction BD / BC"),
        "size_of_bd_over_cd": Number("interaction BD / CD"),
        "largest_effect_taken_for_bd_by_a_quarter_of_the_design": Number(
            "largest effect that a quarter of the design attributes to BD", "%"
        ),
    },
    reason=(
        "Significant is an effect beyond the margin of error that the half-normal plot shows, as "
        "for the main effects (C53, C54)."
    ),
    cases=RIDGE,
    figures="fig25",
    external=("one interaction plays a small part: surface energy with adhesion damping",),
    by_contact=True,
)
def c55(context: Context) -> Numbers:
    """Interaction BD at small levels over the margin of error, and over those of the same factors.

    Beside it, what quarters of the design that confound it with a factor take for it.
    """
    quarters = context.table("doe_bd_aliasing", variation=SMALL)
    taken = quarters.loc[quarters["main_effect"] != "none", "apparent_percent"]
    effects = fraction(context, SMALL)
    size = {word: abs(effect(effects, word)) for word in ("BD", "BC", "CD")}
    return {
        "size_of_bd_over_margin": size["BD"] / effects.margin,
        "size_of_bd_over_bc": size["BD"] / size["BC"],
        "size_of_bd_over_cd": size["BD"] / size["CD"],
        "largest_effect_taken_for_bd_by_a_quarter_of_the_design": taken.abs().max(),
    }


@Claim(
    "C56",
    (
        "Stiffness and material damping influence capture less than the radius and the work of "
        "adhesion."
    ),
    says=(
        "The effects of stiffness and material damping are at most "
        "{larger_of_stiffness_and_material_damping_over_smaller_leading_effect} times the smaller "
        "leading effect."
    ),
    where="4.3",
    quote="the mechanical stiffness and material dissipation play secondary roles",
    article="secondary",
    numbers={
        "larger_of_stiffness_and_material_damping_over_smaller_leading_effect": Number(
            "larger of stiffness and material damping effects / smaller leading effect",
            at_most=0.999,
        ),
    },
    reason=(
        "Sizes of effects, the larger value of both sets of levels; any difference beyond 0.1 % "
        "counts."
    ),
    cases=RIDGE,
    figures="fig24 fig25",
    by_contact=True,
)
def c56(context: Context) -> Numbers:
    """Secondary effects over the smaller leading one, the larger of both sets of levels."""
    sets = [fraction(context, variation) for variation in (REALISTIC, SMALL)]
    sizes = [abs(effect(each, letter)) / leading(each) for each in sets for letter in "AE"]
    larger = np.max(sizes, axis=0)
    return {"larger_of_stiffness_and_material_damping_over_smaller_leading_effect": larger}


def fraction(context: Context, variation: str) -> Effects:
    """Return the effects of the runs of the fractional design about each contact.

    Raises NotComputable if its law has no damping of adhesion and material, the factors D and E.
    """
    steel = context.steel
    if steel.law is not None:
        raise NotComputable("the factors are those of the ring force")
    table = context.table("doe_design", variation=variation)
    runs = table.loc[table["in_fraction"].astype(str) == "True", list(LETTERS)].to_numpy(float)
    levels = context.table("doe_levels", variation=variation).set_index("factor").loc[[*LETTERS]]
    multiples = coded(levels[["low_multiple", "high_multiple"]].to_numpy(float).T, runs)
    key = ("fraction", variation, context.case, context.contacts is None)
    velocities = context.once(key, lambda: capture_velocity(at_levels(steel, multiples[:, None])).T)
    wanted = {"variation": variation, "design": "fraction", "response": "v_c"}
    aliases = context.table("doe_effects", **wanted).set_index("effect")["aliases"]
    sizes = contrasts(runs, LETTERS, [*aliases.index], velocities)
    percent = 100.0 * sizes / velocities.mean(axis=-1, keepdims=True)
    return Effects(
        percent=dict(zip(map(str, aliases.index), percent.T, strict=True)),
        aliases={str(word): str(others) for word, others in aliases.fillna("").items()},
        margin=np.array([lenth(of_one).margin for of_one in percent]),
    )


def effect(effects: Effects, word: str) -> FloatArray:
    """Return the design's estimates of the effect of a factor or of an interaction of two.

    Raises NotComputable if the design does not tell it from another such effect.
    """
    for name, size in effects.percent.items():
        words = [name, *effects.aliases[name].replace("-", "").split()]
        if word in words:
            if others := [other for other in words if other != word and len(other) <= PAIR]:
                mixed = " and ".join(others)
                raise NotComputable(
                    f"fig24_25_doe.generator: the design does not tell {word} from {mixed}"
                )
            return size
    raise NotComputable(f"fig24_25_doe.generator: {word} is constant over the runs of the design")


def leading(effects: Effects) -> FloatArray:
    """Return the smaller size of the effects of work of adhesion and radius."""
    smaller: FloatArray = np.minimum(*(abs(effect(effects, letter)) for letter in "BC"))
    return smaller
