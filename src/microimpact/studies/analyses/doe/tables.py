"""Tables of the designed experiments: effects and aliases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.core.tables import Row, series_frame
from microimpact.model.contact import Contact
from microimpact.statistics.effects import (
    Margins,
    aliases,
    effects,
    half_normal_positions,
    lenth,
    normal_positions,
    product,
    quarter_fractions,
)
from microimpact.studies.analyses.doe.factors import LETTERS, coded, elasticities


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DesignedExperiment:
    """One case with one set of levels."""

    # Which contact, and which set of levels.
    case: str
    variation: str
    # The nominal contact, and those of all runs: the nominal one first, then the full design.
    contact: Contact
    contacts: Contact
    levels: FloatArray  # Multiples of the nominal values, shape (2, 5)
    relation: dict[str, int]  # Defining relation of the fraction
    full: FloatArray  # Coded levels of the full design, shape (32, 5)
    runs: NDArray[np.integer[Any]]  # Which of its runs are in the fraction
    # Capture velocity of the nominal contact, and of all runs of the full design, m/s.
    centre: float
    response: FloatArray
    # That of the runs in the fraction by fits of Eq. (34), shape (replicates, runs), m/s.
    fitted: FloatArray
    confidence: float  # Of the margins


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Analysis:
    """The effects of one response over one design, in % (of the mean, or of 1 in ln v_c).

    ``power_law`` are those of a pure power law with the elasticities of the nominal contact,
    ``pseudo_error`` the standard deviation of an effect over replicates.
    """

    design: str
    response: str
    classes: dict[str, dict[str, int]]
    percent: FloatArray
    power_law: FloatArray
    pseudo_error: FloatArray
    margins: Margins


def analyses(each: DesignedExperiment) -> Iterator[Analysis]:
    """Yield the analysis of each response over the fraction, and of exact ones over all runs."""
    slopes = elasticities(each.contact).at_fixed_zeta
    law = each.centre * np.exp(np.log(coded(each.levels, each.full)) @ slopes)
    everything = np.arange(len(each.full))
    for name, runs in {"fraction": each.runs, "full": everything}.items():
        relation = each.relation if name == "fraction" else {}
        classes = aliases(relation, LETTERS)
        design = each.full[runs]
        responses = {
            "v_c": (each.response[None, runs], law[runs]),
            "ln v_c": (np.log(each.response[None, runs]), np.log(law[runs])),
        }
        if name == "fraction":
            responses["v_c by Eq. 34"] = (each.fitted, law[runs])
        for response, (values, predicted) in responses.items():
            logarithmic = response == "ln v_c"
            percent = _percent(design, classes, values, logarithmic=logarithmic)
            yield Analysis(
                design=name,
                response=response,
                classes=classes,
                percent=percent.mean(axis=0),
                power_law=_percent(design, classes, predicted, logarithmic=logarithmic),
                pseudo_error=percent.std(axis=0, ddof=1)
                if len(percent) > 1
                else np.full(len(classes), np.nan),
                margins=lenth(percent.mean(axis=0), each.confidence),
            )


def _percent(
    design: FloatArray, classes: dict[str, dict[str, int]], values: FloatArray, *, logarithmic: bool
) -> FloatArray:
    """Effects in % of the mean response; of a logarithm, in hundredths."""
    found = effects(design, LETTERS, list(classes), values)
    return 100.0 * (found if logarithmic else found / values.mean(axis=-1, keepdims=True))


_frame = partial(series_frame, x_unit="percent", y_unit="1")


def alias_rows(relation: Mapping[str, int]) -> list[Row]:
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


def effect_rows(each: DesignedExperiment) -> Iterator[Row]:
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


def bd_aliasing(each: DesignedExperiment) -> Iterator[Row]:
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


def figure_frame(each: DesignedExperiment, table: pd.DataFrame) -> pd.DataFrame:
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
