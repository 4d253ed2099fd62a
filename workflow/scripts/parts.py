"""Parts of a heavy study on disk: plain values as JSON, read back exactly.

JSON runs nothing when it is read. Python's form of it brings every float back to the last bit, NaN
and infinity included.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np


def part_text(part: object) -> str:
    """Return a part as text.

    Parameters
    ----------
    part
        Lists, tuples and mappings of numbers, texts and None. Tuples come back as lists.

    Raises
    ------
    TypeError
        If it holds anything else.
    """
    return json.dumps(part, default=_plain)


def part_from_text(text: str) -> Any:
    """Return the part that a text holds."""
    return json.loads(text)


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"a part may hold plain values only, not {type(value).__name__}")
