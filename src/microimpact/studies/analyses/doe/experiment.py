"""A designed experiment with its responses, and the effects in each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from microimpact.core.arrays import FloatArray
from microimpact.model.contact import Contact
from microimpact.statistics.effects import Margins, aliases, effects, lenth
from microimpact.studies.analyses.doe.factors import LETTERS, coded, elasticities


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Experiment:
    """One case with one set of levels.

    Attributes
    ----------
    case, variation
        Which contact, and which set of levels.
    contact, contacts
        The nominal contact, and those of all runs: the nominal one first, then the full design.
    levels
        Multiples of the nominal values, shape (2, 5).
    relation
        Defining relation of the fraction.
    full
        Coded levels of the full design, shape (32, 5).
    runs
        Which of its runs are in the fraction.
    centre, response
        Capture velocity of the nominal contact, and of all runs of the full design, m/s.
    fitted
        That of the runs in the fraction by fits of Eq. (34), shape (replicates, runs), m/s.
    confidence
        Of the margins.
    """

    case: str
    variation: str
    contact: Contact
    contacts: Contact
    levels: FloatArray
    relation: dict[str, int]
    full: FloatArray
    runs: NDArray[np.integer[Any]]
    centre: float
    response: FloatArray
    fitted: FloatArray
    confidence: float


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


def analyses(each: Experiment) -> Iterator[Analysis]:
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
