"""Numba's compiler, with its cache on disk where there is a place for it.

The cache stands beside the source, else in the user's cache directory; ``NUMBA_CACHE_DIR`` names
another place. Where none can be written (an installation for reading only, without a home), every
process compiles anew, in some seconds.

Each module with compiled functions holds all that they call: the cache looks only at the file of
the function it loads, and would keep stale code of another.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def jit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function without the interpreter's lock, and caches it."""

    def compiled(function: Callable[..., Any]) -> Any:
        common: Any = {"nogil": True, "error_model": "numpy"} | options
        try:
            return njit(cache=True, **common)(function)
        except RuntimeError:  # "no locator available": nowhere to write
            return njit(**common)(function)

    return compiled
