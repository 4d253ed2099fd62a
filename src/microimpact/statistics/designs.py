"""Two-level designs of experiments in standard order: the one place that uses the library.

pyDOE2 serves Python 3.11, its successor pydoe later versions; they order the runs differently, so
the rows are sorted here, and run numbers do not depend on the library.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from microimpact.core.arrays import FloatArray


def fractional_factorial(generator: str) -> FloatArray:
    """Return a two-level fractional factorial design.

    Levels -1 and +1, shape (runs, factors), in standard (Yates) order: the first factor changes
    with every run. `generator`: one word per factor, as ``"a b c d abcd"``: single letters are
    varied freely, words are products of letters, with a minus sign for the negative fraction.
    Raises ValueError if the generator is empty or uses a letter that is no factor of its own.
    """
    # Imported here: the library brings much along that only a design needs.
    if sys.version_info >= (3, 12):
        from pydoe import fracfact
    else:
        from pyDOE2 import fracfact

    words = generator.split()
    letters = [word for word in words if len(word) == 1]
    unknown = sorted({char for word in words for char in word.lstrip("-+") if char not in letters})
    if not words or unknown:
        detail = f"letters {', '.join(unknown)} are no factors of their own" if unknown else "empty"
        raise ValueError(f"generator {generator!r}: {detail}")
    design: Any = np.asarray(fracfact(generator), dtype=np.float64)
    free = [words.index(letter) for letter in letters]
    order = np.lexsort([design[:, column] for column in free])
    rows: FloatArray = design[order]
    return rows


def full_factorial(factors: int) -> FloatArray:
    """Return all combinations of two levels, shape (2^factors, factors), in standard order."""
    return fractional_factorial(" ".join("abcdefghijklmnopqrstuvwxyz"[:factors]))
