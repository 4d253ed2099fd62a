"""The name that was probably meant, for error messages."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable


def nearest(key: object, known: Iterable[str]) -> str:
    """Return `` (did you mean ...?)`` with the most similar known key, or all of them.

    One that differs in capitals, zeros before a number, or the order of a pair is the most similar.
    """
    names, key = sorted(known), str(key)
    alike = [name for name in names if _core(name) == _core(key)]
    close = alike or difflib.get_close_matches(key, names, n=1, cutoff=0.5)
    if close:
        return f" (did you mean '{close[0]}'?)"
    return f" (known here: {', '.join(names)})" if names else " (no key is known here)"


def _core(name: str) -> list[str]:
    return sorted(re.sub(r"(?<![\d.])0+(?=\d)", "", name.casefold()).split(" on "))
