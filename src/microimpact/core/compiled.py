"""Numba's compiler, with its cache on disk where there is a place for it.

The cache is kept beside the source, else in the user's cache directory; ``NUMBA_CACHE_DIR`` names
another place. Where none can be written (an installation for reading only, without a home), every
process compiles again. Either is said once a process, on stderr.

Each module with compiled functions holds all functions and constants that they use: the cache looks
only at the file of the function it loads, and would keep what stood in another. Numba itself, a
third of a second of every start, is loaded with the first call of a compiled function of a module.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache, update_wrapper
from pathlib import Path
from threading import RLock
from typing import Any

_LOCK = RLock()
FIRST = "compiling, this once, up to half a minute; `microimpact warm-up` compiles all at once"
UNCACHED = "compiling in every process: no cache can be written; NUMBA_CACHE_DIR names a place"


def jit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function without the interpreter's lock, and caches it."""
    return lambda function: _Uncompiled(function, options)


class _Uncompiled:
    """A function whose first call puts Numba's in the place of all of its module."""

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self.function, self.options = function, options
        update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        """Call the compiled function; a name that was imported elsewhere still comes here."""
        return self.compiled()(*arguments)

    def compiled(self) -> Any:
        """Return Numba's function, which compiles itself for the kinds of its arguments."""
        module, name = self.function.__globals__, self.function.__name__
        with _LOCK:
            if module[name] is self:
                for key, value in list(module.items()):
                    if isinstance(value, _Uncompiled) and value.function.__globals__ is module:
                        module[key] = value.dispatcher()
        return module[name]

    def dispatcher(self) -> Any:
        """Return Numba's function, with a cache where there is a place for it."""
        from numba import njit

        options: Any = {"nogil": True, "error_model": "numpy"} | self.options
        try:
            dispatcher = njit(cache=True, **options)(self.function)
        except RuntimeError:  # "no locator available": nowhere to write
            notice(UNCACHED)
            return njit(**options)(self.function)
        announce(dispatcher.stats.cache_path, Path(self.function.__code__.co_filename).stem)
        return dispatcher


@cache
def announce(folder: str, module: str) -> None:
    """Say that functions are compiled for the first time; a module is looked for once."""
    if not any(Path(folder).glob(f"{module}.*.nbi")):
        notice(FIRST)


@cache
def notice(words: str) -> None:
    """Write a line for whoever waits, once a process."""
    sys.stderr.write(f"microimpact: {words}\n")
