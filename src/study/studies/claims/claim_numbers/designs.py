"""Numbers of the claims of Section 4.3: effects of designed experiments on the capture velocity."""

from __future__ import annotations

import numpy as np
import pandas as pd

from microimpact.core.computable import NotComputable
from microimpact.model.dynamics.capture import capture_velocity
from study.declared.parameters import Finite
from study.studies.claims.claim_numbers.claim import claim
from study.studies.claims.claim_numbers.context import Context, Numbers
from study.studies.claims.claim_numbers.experiments import EXPONENT_STEP, local_exponents

REALISTIC, SMALL = "realistic", "uniform"


@claim("C53", by_case=True)
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
    margin = effects["margin_percent"].iloc[0]
    others = effects["effect_percent"].drop(["B", "C"], errors="ignore")
    return {
        "effect_of_radius_over_margin": effect(effects, "C") / margin,
        "effect_of_work_of_adhesion_over_margin": effect(effects, "B") / margin,
        "smaller_of_both_over_largest_other_effect": leading(effects) / others.abs().max(),
        "log_range_of_work_of_adhesion_over_that_of_damping": ranges["B"] / ranges["D"],
        "log_range_at_which_both_have_one_effect": slope["D"] / slope["B"],
    }


@claim("C54", by_case=True)
def c54(context: Context) -> Numbers:
    """Effects of stiffness and adhesion damping at small levels, over the margin."""
    effects = fraction(context, SMALL)
    margin = effects["margin_percent"].iloc[0]
    stiffness, damping = (abs(effect(effects, letter)) for letter in "AD")
    return {
        "size_of_stiffness_effect_over_margin": stiffness / margin,
        "size_of_adhesive_damping_effect_over_margin": damping / margin,
        "smaller_of_radius_and_adhesion_over_larger_of_these": leading(effects)
        / max(stiffness, damping),
    }


@claim("C55", by_case=True)
def c55(context: Context) -> Numbers:
    """Interaction BD at small levels over those of the same factors.

    Beside it, what quarters of the design that confound it with a factor take for it.
    """
    quarters = context.table("doe_bd_aliasing", variation=SMALL)
    taken = quarters.loc[quarters["main_effect"] != "none", "apparent_percent"]
    effects = fraction(context, SMALL)
    size = {word: abs(effect(effects, word)) for word in ("BD", "BC", "CD")}
    return {
        "size_of_bd_over_bc": size["BD"] / size["BC"],
        "size_of_bd_over_cd": size["BD"] / size["CD"],
        "size_of_bd_over_margin": size["BD"] / effects["margin_percent"].iloc[0],
        "largest_effect_taken_for_bd_by_a_quarter_of_the_design": taken.abs().max(),
    }


@claim("C56", by_case=True)
def c56(context: Context) -> Numbers:
    """Secondary effects over the smaller leading one, the larger of both sets of levels."""
    sets = [fraction(context, variation) for variation in (REALISTIC, SMALL)]
    larger = max(
        abs(effect(effects, letter)) / leading(effects) for effects in sets for letter in "AE"
    )
    return {"larger_of_stiffness_and_material_damping_over_smaller_leading_effect": larger}


def fraction(context: Context, variation: str) -> pd.DataFrame:
    """Return the effects that the fractional design estimates, by their words."""
    wanted = {"variation": variation, "design": "fraction", "response": "v_c"}
    return context.table("doe_effects", **wanted).set_index("effect")


def effect(effects: pd.DataFrame, word: str) -> float:
    """Return the design's estimate of the effect of a word: the effect of its alias class.

    Raises NotComputable if the word is constant over the runs.
    """
    for name, size, aliases in zip(
        effects.index, effects["effect_percent"], effects["aliases"].astype(str), strict=True
    ):
        if word in (name, *aliases.split()):
            return float(size)
        if f"-{word}" in aliases.split():
            return -float(size)
    raise NotComputable(f"doe_effects: {word} is constant over the runs of the design")


def leading(effects: pd.DataFrame) -> float:
    """Return the smaller size of the effects of work of adhesion and radius."""
    return min(abs(effect(effects, letter)) for letter in "BC")


@claim("C57", by_case=True)
def c57(context: Context, *, work_size_exponent: Finite) -> Numbers:
    """Elasticities of the capture velocity at the nominal contact, damping held.

    Beside them, its mean over the realistic runs with small and adhesive spheres, over that of the
    next of the four groups.
    """
    runs = context.table("doe_design", variation=REALISTIC)
    groups = runs[runs["run"] > 0].groupby(["B", "C"])["capture_velocity_m_per_s"].mean()
    over_next = groups[1, -1] / groups.drop((1, -1)).max()
    contact = context.steel
    work = np.asarray(contact.work_of_adhesion) * np.exp([EXPONENT_STEP, -EXPONENT_STEP])
    limit = capture_velocity(contact.replace(work_of_adhesion=work))
    return {
        "elasticity_to_work_of_adhesion": np.log(limit[0] / limit[1]) / (2.0 * EXPONENT_STEP),
        "elasticity_to_diameter": local_exponents(contact, contact.diameter, work_size_exponent),
        "capture_velocity_of_small_and_adhesive_over_next_group": over_next,
    }
