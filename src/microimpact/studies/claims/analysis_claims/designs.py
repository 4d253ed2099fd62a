"""Claims of Section 4.3, from the effects of the designed experiments on the capture velocity."""

from __future__ import annotations

import pandas as pd

from microimpact.studies.claims.analysis_claims.context import Context

REALISTIC, SMALL = "realistic", "uniform"
DIRECT, LOGARITHM = "v_c", "ln v_c"


def c53(context: Context, case: str) -> dict[str, float]:
    """Return the effects of radius and adhesion at realistic levels against all others."""
    effects = fraction(context, case, REALISTIC)
    margin = float(effects["margin_percent"].iloc[0])
    size = effects["effect_percent"].abs()
    return {
        "effect_of_radius_over_margin": effect(effects, "C") / margin,
        "effect_of_work_of_adhesion_over_margin": effect(effects, "B") / margin,
        "smaller_of_both_over_largest_other_effect": leading(effects)
        / float(size.drop(["B", "C"]).max()),
    }


def c54(context: Context, case: str) -> dict[str, float]:
    """Return the effects of stiffness and adhesive damping at small levels, over the margin."""
    effects = fraction(context, case, SMALL)
    margin = float(effects["margin_percent"].iloc[0])
    stiffness, damping = (abs(effect(effects, letter)) for letter in "AD")
    return {
        "size_of_stiffness_effect_over_margin": stiffness / margin,
        "size_of_adhesive_damping_effect_over_margin": damping / margin,
        "smaller_of_radius_and_adhesion_over_larger_of_these": leading(effects)
        / max(stiffness, damping),
    }


def c55(context: Context, case: str) -> dict[str, float]:
    """Return the interaction BD at small levels over those of the same factors."""
    effects, logarithm = (fraction(context, case, SMALL, kind) for kind in (DIRECT, LOGARITHM))
    size = {word: abs(effect(effects, word)) for word in ("BD", "BC", "CD")}
    of_logarithm = abs(effect(logarithm, "BD")) / abs(effect(logarithm, "BC"))
    return {
        "size_of_bd_over_bc": size["BD"] / size["BC"],
        "size_of_bd_over_cd": size["BD"] / size["CD"],
        "size_of_bd_over_margin": size["BD"] / float(effects["margin_percent"].iloc[0]),
        "size_of_bd_over_bc_of_logarithm": of_logarithm,
    }


def c56(context: Context, case: str) -> dict[str, float]:
    """Return secondary effects over the smaller leading one, the larger of both sets of levels."""
    sets = [fraction(context, case, variation) for variation in (REALISTIC, SMALL)]
    stiffness, damping = (
        max(abs(effect(effects, letter)) / leading(effects) for effects in sets) for letter in "AE"
    )
    return {
        "larger_of_stiffness_and_material_damping_over_smaller_leading_effect": max(
            stiffness, damping
        ),
        "size_of_material_damping_effect_over_smaller_leading_effect": damping,
    }


def fraction(context: Context, case: str, variation: str, response: str = DIRECT) -> pd.DataFrame:
    """Return the effects that the fractional design estimates, by their words."""
    table = context.inputs["doe_effects"]
    own = (
        (table["case"] == case)
        & (table["variation"] == variation)
        & (table["design"] == "fraction")
        & (table["response"] == response)
    )
    return table[own].set_index("effect")


def effect(effects: pd.DataFrame, word: str) -> float:
    """Return what the design takes for the effect of a word: that of its whole alias class.

    Raises
    ------
    ValueError
        If the word is constant over the runs.
    """
    for name, row in effects.iterrows():
        aliases = str(row["aliases"]).split()
        if word == name or word in aliases:
            return float(row["effect_percent"])
        if f"-{word}" in aliases:
            return -float(row["effect_percent"])
    raise ValueError(f"doe_effects: {word} is constant over the runs of the design")


def leading(effects: pd.DataFrame) -> float:
    """Return the smaller size of the effects of work of adhesion and radius."""
    return min(abs(effect(effects, letter)) for letter in "BC")
