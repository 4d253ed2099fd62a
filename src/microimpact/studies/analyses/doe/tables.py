"""Tables of the designed experiments: effects, aliases, what the article says of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.model.dynamics.normal import normal_impact
from microimpact.statistics.effects import (
    aliases,
    effects,
    half_normal_positions,
    normal_positions,
    product,
    quarter_fractions,
)
from microimpact.studies.analyses.doe.experiment import Experiment, analyses
from microimpact.studies.analyses.doe.factors import LETTERS, elasticities

# Relative distances from the capture velocity tried forwards, to see how exact it is.
DISTANCES = 10.0 ** np.arange(-13, -2)


def alias_rows(relation: Mapping[str, int]) -> list[dict[str, object]]:
    """Return, per effect the fraction estimates, what is added to it."""
    resolution = min(map(len, relation), default=0)
    return [
        {
            "effect": word,
            "aliases": _signed(others),
            "defining_relation": " = ".join(["I", *_terms(relation)]),
            "resolution": resolution or "full",
        }
        for word, others in aliases(relation, LETTERS).items()
    ]


def _terms(signed: Mapping[str, int]) -> list[str]:
    return [("-" if sign < 0 else "") + word for word, sign in signed.items()]


def _signed(others: Mapping[str, int]) -> str:
    return " ".join(_terms(others))


def effect_rows(each: Experiment) -> Iterator[dict[str, object]]:
    """Yield one row per effect, response and design."""
    for found in analyses(each):
        normal = normal_positions(found.percent)
        half = half_normal_positions(found.percent)
        for i, (word, others) in enumerate(found.classes.items()):
            yield {
                "case": each.case,
                "variation": each.variation,
                "design": found.design,
                "response": found.response,
                "effect": word,
                "aliases": _signed(others),
                "effect_percent": found.percent[i],
                "power_law_percent": found.power_law[i],
                "pseudo_error_percent": found.pseudo_error[i],
                "lenth_pseudo_error_percent": found.margins.pseudo_error,
                "margin_percent": found.margins.margin,
                "simultaneous_margin_percent": found.margins.simultaneous,
                "normal_quantile": normal[i],
                "half_normal_quantile": half[i],
                "evidence": "computed",
            }


def bd_aliasing(each: Experiment) -> Iterator[dict[str, object]]:
    """Yield what BD looks like in every quarter fraction, all choices of signs."""
    whole = effects(each.full, LETTERS, ["BD"], each.response)[0] / each.response.mean()
    for first, second in quarter_fractions(LETTERS):
        for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            relation = {
                first: signs[0],
                second: signs[1],
                product(first, second): signs[0] * signs[1],
            }
            kept = np.all([_column(each.full, w) == s for w, s in relation.items()], axis=0)
            response = each.response[kept]
            others = {product("BD", word): sign for word, sign in relation.items()}
            main = [word for word in others if len(word) == 1]
            apparent = effects(each.full[kept], LETTERS, ["BD"], response)[0] / response.mean()
            yield {
                "case": each.case,
                "variation": each.variation,
                "defining_relation": " = ".join(["I", *_terms(relation)]),
                "aliases_of_BD": _signed(others),
                "main_effect": main[0] if main else "none",
                "apparent_percent": 100.0 * apparent,
                "BD_percent": 100.0 * whole,
                "evidence": "computed",
            }


def _column(design: FloatArray, word: str) -> FloatArray:
    column: FloatArray = design[:, [LETTERS.index(c) for c in word]].prod(axis=1)
    return column


def statement_rows(each: Experiment, table: pd.DataFrame) -> Iterator[dict[str, object]]:
    """Yield numbers for what Section 4.3 says, from the fraction, per response."""
    own = table[(table["case"] == each.case) & (table["variation"] == each.variation)]
    common = {"case": each.case, "variation": each.variation}
    for response, rows in own[own["design"] == "fraction"].groupby("response", sort=False):
        size = rows.set_index("effect")["effect_percent"].abs()
        signed = rows.set_index("effect")["effect_percent"]
        margin = float(rows["margin_percent"].iloc[0])
        for claim, quantity, value, unit in _numbers(size, signed, margin):
            row = {"claim": claim, "quantity": quantity, "value": value, "unit": unit}
            yield common | {"response": response} | row | {"evidence": "computed"}
    for claim, quantity, value, unit in _of_the_experiment(each):
        row = {"claim": claim, "quantity": quantity, "value": value, "unit": unit}
        yield common | {"response": "v_c"} | row | {"evidence": "computed"}


def _numbers(
    size: pd.Series[float], signed: pd.Series[float], margin: float
) -> Iterator[tuple[str, str, float, str]]:
    """Yield (claim, quantity, value, unit) of one response, for the words that it estimates."""
    main = size[list(LETTERS)]
    rank = _ranks(size)
    yield "C53", "effect_B", float(signed["B"]), "%"
    yield "C53", "effect_C", float(signed["C"]), "%"
    yield "C53", "rank_of_B", float(rank["B"]), "-"
    yield "C53", "rank_of_C", float(rank["C"]), "-"
    others = float(size.drop(["B", "C"]).max())
    weaker = float(main[["B", "C"]].min())
    yield "C53", "smaller_of_B_and_C_over_largest_other", weaker / others, "-"
    for letter in "AD":
        yield "C54", f"effect_{letter}", float(signed[letter]), "%"
        yield "C54", f"{letter}_over_margin", _ratio(size[letter], margin), "-"
    if "BD" in size:
        yield "C55", "effect_BD", float(signed["BD"]), "%"
        yield "C55", "BD_over_margin", _ratio(size["BD"], margin), "-"
        yield from (
            ("C55", f"BD_over_{word}", float(size["BD"] / size[word]), "-")
            for word in ("BC", "CD")
            if word in size
        )
    yield "C56", "effect_E", float(signed["E"]), "%"
    yield "C56", "rank_of_E_among_factors", float(_ranks(main)["E"]), "-"
    yield "C56", "E_over_smaller_of_B_and_C", float(main["E"]) / weaker, "-"


def _ranks(size: pd.Series[float]) -> pd.Series[float]:
    """Return ranks from the largest; sizes equal but for rounding share one."""
    return size.round(9).rank(ascending=False, method="min")


def _ratio(size: float, margin: float) -> float:
    return float(size) / margin if margin > 0.0 else float("inf")


def _of_the_experiment(each: Experiment) -> Iterator[tuple[str, str, float, str]]:
    """Yield numbers that do not depend on how effects are estimated."""
    mean = each.response.mean()
    sticky = (each.full[:, 1] > 0.0) & (each.full[:, 2] < 0.0)
    groups = [
        each.response[(each.full[:, 1] == b) & (each.full[:, 2] == c)].mean()
        for b, c in ((-1, -1), (-1, 1), (1, 1))
    ]
    slopes = elasticities(each.contact).at_fixed_zeta
    highest = float(each.response[sticky].mean())
    log_range = np.log(each.levels[1] / each.levels[0])
    yield "C53", "log_range_of_B_over_that_of_D", float(log_range[1] / log_range[3]), "-"
    yield "C53", "log_range_at_which_B_equals_D", float(slopes[3] / slopes[1]), "-"
    yield "C57", "v_c_of_small_and_adhesive_over_mean", highest / mean, "-"
    yield "C57", "v_c_of_small_and_adhesive_over_next_group", highest / max(groups), "-"
    yield "C57", "exponent_of_work_over_radius", float(slopes[1]), "-"
    yield "C57", "exponent_of_work_plus_that_of_radius", float(slopes[1] + slopes[2]), "-"
    designs = pd.DataFrame(bd_aliasing(each))
    onto_main = designs[designs["main_effect"] != "none"]
    yield "C55", "quarter_fractions", len(designs) / 4, "-"
    yield "C55", "quarter_fractions_with_BD_on_a_factor", len(onto_main) / 4, "-"
    for main, rows in onto_main.groupby("main_effect"):
        largest = float(rows["apparent_percent"].abs().max())
        yield "C55", f"largest_apparent_BD_on_{main}", largest, "%"
    yield "all", "nominal_less_mean", 100.0 * (each.center - mean) / mean, "%"
    log_mean = np.log(each.response).mean()
    yield "all", "ln_nominal_less_mean_ln", 100.0 * (np.log(each.center) - log_mean), "%"
    yield "all", "solver_error", 100.0 * solver_error(each), "%"


def solver_error(each: Experiment) -> float:
    """Relative half width of the bracket in which forward impacts find the capture velocities.

    Not below the smallest distance tried; infinite if the largest does not bracket them.
    """
    limit = np.concatenate([[each.center], each.response])
    for distance in DISTANCES:
        below = normal_impact(each.contacts, limit * (1.0 - distance)).captured
        above = normal_impact(each.contacts, limit * (1.0 + distance)).captured
        if np.all(below) and not np.any(above):
            return float(distance)
    return float("inf")


def figure_frame(each: Experiment, table: pd.DataFrame) -> pd.DataFrame:
    """Return the effects of an experiment as drawn: panels by plot, series by response and word."""
    own = table[
        (table["case"] == each.case)
        & (table["variation"] == each.variation)
        & (table["design"] == "fraction")
    ]
    frames = []
    for response, rows in own.groupby("response", sort=False):
        for panel, column, x in (
            ("normal", "normal_quantile", rows["effect_percent"]),
            ("half_normal", "half_normal_quantile", rows["effect_percent"].abs()),
        ):
            for word, size, quantile in zip(rows["effect"], x, rows[column], strict=True):
                series = f"{response}: {word}"
                frames.append(_frame(panel, series, [size], [quantile]))
            for name in ("margin", "simultaneous margin"):
                margin = rows[f"{name.replace(' ', '_')}_percent"].iloc[0]
                ends = [-margin, margin] if panel == "normal" else [margin]
                frames.append(_frame(panel, f"{response}: {name}", ends, 0.0))
    return pd.concat(frames, ignore_index=True)


def _frame(panel: str, series: str, x: list[float], y: object) -> pd.DataFrame:
    return series_frame(
        panel=panel,
        series=series,
        evidence="computed",
        x=x,
        y=y,  # type: ignore[arg-type]
        x_unit="percent",
        y_unit="1",
    )
