"""Two-level designs of experiments and their effects: aliases, contrasts, Lenth's margins.

An effect is a word of factor letters (``BD``); the responses are deterministic, so effects are
exact contrasts, and Lenth's margins screen for sparsity; they are no tests.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from string import ascii_lowercase
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray

LEAST_RESOLUTION = 3

SignedWords = Mapping[str, int]


def fractional_factorial(generator: str) -> FloatArray:
    """Return a two-level fractional factorial design.

    Levels -1 and +1, shape (runs, factors), in standard (Yates) order: the first factor changes
    with every run. The libraries order the runs differently, so the rows are sorted here.

    Parameters
    ----------
    generator
        One word per factor, as ``"a b c d abcd"``: single letters are varied freely, words are
        products of letters, with a minus sign for the negative fraction; see `defining_relation`.
    """
    # Imported here: the library brings much along that only a design needs.
    if sys.version_info >= (3, 12):
        from pydoe import fracfact
    else:
        from pyDOE2 import fracfact

    reading = _read(generator)
    free = [column for column, word in enumerate(reading) if word == (1, (column,))]
    # The libraries name the free factors by the alphabet, whatever the letters here.
    named = dict(zip(free, ascii_lowercase, strict=False))
    spelt = ("-" * (sign < 0) + "".join(named[c] for c in columns) for sign, columns in reading)
    design: Any = np.asarray(fracfact(" ".join(spelt)), dtype=np.float64)
    order = np.lexsort([design[:, column] for column in free])
    rows: FloatArray = design[order]
    return rows


def _read(generator: str) -> list[tuple[int, tuple[int, ...]]]:
    """Sign of every factor's word, and the places of the free factors of which it is the product.

    Raises ValueError if a word is no product of letters, or a letter no factor of its own.
    """
    words = generator.split()
    free: dict[str, int] = {}
    for column, word in enumerate(words):
        if len(word) == 1 and word.isalpha():
            free.setdefault(word, column)
    reading = []
    for word in words:
        body = word.removeprefix("-")
        if not body.isalpha() or len(set(body)) != len(body):
            raise ValueError(f"generator {generator!r}: {word!r} must be a product of letters")
        if unknown := sorted(set(body) - set(free)):
            detail = f"letters {', '.join(unknown)} are no factors of their own"
            raise ValueError(f"generator {generator!r}: {detail}")
        reading.append((-1 if word != body else 1, tuple(free[letter] for letter in body)))
    return reading


def full_factorial(factors: int) -> FloatArray:
    """Return all combinations of two levels, shape (2^factors, factors), in standard order."""
    return fractional_factorial(" ".join(ascii_lowercase[:factors]))


def words(letters: str) -> list[str]:
    """Return all main effects and interactions, by order and then by letter."""
    return [
        "".join(word) for size in range(1, len(letters) + 1) for word in combinations(letters, size)
    ]


def product(first: str, second: str) -> str:
    """Return the product of two words: letters that occur in only one of them."""
    return "".join(sorted(set(first) ^ set(second)))


def defining_relation(generator: str, letters: str) -> dict[str, int]:
    """Words that are constant over a fraction, each with its sign.

    Parameters
    ----------
    generator
        One word per factor: ``"a b c d abcd"``.
    letters
        Letters of the factors, in the generator's order.

    Raises
    ------
    ValueError
        If the number of words is not that of the factors, a word repeats or misses a letter, or
        two factors could not be told apart (resolution below III).
    """
    reading = _read(generator)
    if len(reading) != len(letters):
        raise ValueError(
            f"generator {generator!r}: must have {len(letters)} words, one for each of"
            f" {', '.join(letters)}, got {len(reading)}"
        )
    relation = _group(
        {
            product(letters[place], "".join(letters[c] for c in columns)): sign
            for place, (sign, columns) in enumerate(reading)
            if (sign, columns) != (1, (place,))
        }
    )
    shortest = min(relation, key=len, default=letters)
    if len(shortest) < LEAST_RESOLUTION:
        raise ValueError(
            f"generator {generator!r}: {shortest!r} is constant over the runs; every such word"
            " must have three factors or more (resolution III), or main effects fall together"
        )
    return relation


def _group(generators: SignedWords) -> dict[str, int]:
    """Return all products of the generating words."""
    signed_words = {"": 1}
    for word, sign in generators.items():
        signed_words |= {product(word, other): sign * s for other, s in signed_words.items()}
    return {word: sign for word, sign in signed_words.items() if word}


def quarter_fractions(letters: str) -> list[tuple[str, str]]:
    """Return every pair of defining words, one per 2^(k-2) fraction of resolution III or more."""
    long = [word for word in words(letters) if len(word) >= LEAST_RESOLUTION]
    fractions: dict[frozenset[str], tuple[str, str]] = {}
    for pair in combinations(long, 2):
        group = frozenset((*pair, product(*pair)))
        if min(map(len, group)) >= LEAST_RESOLUTION:
            fractions.setdefault(group, pair)
    return list(fractions.values())


def aliases(relation: SignedWords, letters: str) -> dict[str, dict[str, int]]:
    """Return each estimable effect with the effects aliased to it, and their signs.

    An effect of the lowest order represents its class; an effect of the defining relation belongs
    to none.
    """
    classes: dict[str, dict[str, int]] = {}
    seen = set(relation)
    for word in words(letters):
        if word in seen:
            continue
        classes[word] = {product(word, other): sign for other, sign in relation.items()}
        seen |= {word, *classes[word]}
    return classes


def effects(
    design: FloatArray, letters: str, chosen: Sequence[str], response: FloatArray
) -> FloatArray:
    """Effects: the mean response where the word's product is +1 less that where it is -1.

    Parameters
    ----------
    design
        Coded levels -1 and +1, (runs, factors).
    letters
        Letters of the factors.
    chosen
        Words of the effects.
    response
        Response of the runs, (..., runs).

    Returns
    -------
    effects
        Shape (..., effects).
    """
    columns = [design[:, [letters.index(c) for c in word]].prod(axis=1) for word in chosen]
    contrasts = np.stack(columns, axis=1)
    contrast_means: FloatArray = 2.0 / len(design) * np.asarray(response) @ contrasts
    return contrast_means


@dataclass(frozen=True, slots=True)
class Margins:
    """Lenth's pseudo standard error, margin and simultaneous margin, in the effects' unit."""

    pseudo_error: float
    margin: float
    simultaneous: float


def lenth(effects: FloatArray, confidence: float = 0.95) -> Margins:
    """Lenth's margins for the effects of an unreplicated design.

    Parameters
    ----------
    confidence
        Of one effect (margin), and of all together (simultaneous).

    References
    ----------
    R. V. Lenth, Technometrics 31 (1989) 469-473.
    """
    from scipy.special import stdtrit

    sizes = np.abs(effects)
    first = 1.5 * float(np.median(sizes))
    # Effects that are all zero have no error.
    error = 1.5 * float(np.median(sizes[sizes < 2.5 * first])) if first > 0.0 else 0.0
    single = 0.5 * (1.0 + confidence)
    together = 0.5 * (1.0 + confidence ** (1.0 / sizes.size))
    quantile, wide = stdtrit(sizes.size / 3.0, [single, together])
    return Margins(error, float(quantile) * error, float(wide) * error)


def normal_positions(effects: FloatArray) -> FloatArray:
    """Normal quantiles of the ranks of effects, for a normal probability plot."""
    from scipy.special import ndtri

    positions: FloatArray = ndtri(_ranks(effects))
    return positions


def half_normal_positions(effects: FloatArray) -> FloatArray:
    """Quantiles of the absolute normal variate, for a half-normal plot of absolute effects."""
    from scipy.special import ndtri

    positions: FloatArray = ndtri(0.5 + 0.5 * _ranks(np.abs(effects)))
    return positions


def _ranks(values: FloatArray) -> FloatArray:
    """Return the ranks as probabilities (i - 1/2) / m; equal effects rank in order of their names.

    Equal means to a millionth of the largest: rounding must not decide between B and C.
    """
    largest = float(np.max(np.abs(values), initial=0.0)) or 1.0
    ranks = np.empty(values.size)
    order = np.argsort(np.round(values / largest, 6), kind="stable")
    ranks[order] = (np.arange(values.size) + 0.5) / values.size
    return ranks
