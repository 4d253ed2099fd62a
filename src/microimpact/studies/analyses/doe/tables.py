"""Tables of the designed experiments: effects and aliases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np
import pandas as pd

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import series_frame
from microimpact.statistics.effects import (
    aliases,
    effects,
    half_normal_positions,
    normal_positions,
    product,
    quarter_fractions,
)
from microimpact.studies.analyses.doe.experiment import Experiment, analyses
from microimpact.studies.analyses.doe.factors import LETTERS

_frame = partial(series_frame, x_unit="percent", y_unit="1")


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
