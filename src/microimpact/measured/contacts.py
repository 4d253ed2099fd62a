"""Calibrated contacts in a file, to hand them from one command to others."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from microimpact.core.files import write_file
from microimpact.core.materials import Material
from microimpact.core.nearest import nearest
from microimpact.model.choices import NUMBERS
from microimpact.model.contact import Contact

TEXTS = ("stiffness_model",)
PARTNER = "partner_diameter"


def write_contacts(path: Path | str, contact: Contact, best: Contact) -> None:
    """Write contacts as JSON in SI units.

    Parameters
    ----------
    path
        The file.
    contact
        One contact, or an array of draws (draws,).
    best
        The best draw.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    record: dict[str, Any] = {
        role: asdict(getattr(contact, role)) for role in ("particle", "surface")
    }
    for name in NUMBERS:
        value = getattr(contact, name)
        record[name] = value if value is None else np.asarray(value).tolist()
    record |= {name: getattr(contact, name) for name in TEXTS}
    numbers = {name: getattr(best, name) for name in NUMBERS}
    if best.is_pair:
        record[PARTNER] = numbers[PARTNER] = best.partner_diameter
    record["best"] = {
        name: value if value is None else float(value) for name, value in numbers.items()
    }
    write_file(path, json.dumps(record, indent=1, allow_nan=False) + "\n")


def read_contacts(path: Path | str) -> tuple[Contact, Contact]:
    """Read a file that `write_contacts` wrote.

    Returns
    -------
    contact
        Its arrays have the shape (draws, 1), to broadcast with speeds.
    best
        The best draw.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is no such file, or a number is out of range.
    """
    name = Path(path).name
    try:
        record = json.loads(Path(path).read_text(encoding="utf-8"))
        bodies: dict[str, Any] = {
            role: Material(**record.pop(role)) for role in ("particle", "surface")
        }
        best = record.pop("best")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(
            f"{name} must be a file that 'microimpact calibrate -o' wrote: {error}"
        ) from None
    for key in (*record, *best):
        if key not in (*NUMBERS, PARTNER, *TEXTS):
            raise ValueError(f"{name}: {key!r} unknown{nearest(key, NUMBERS)}")
    texts = {key: record[key] for key in TEXTS if key in record}
    drawn: dict[str, Any] = {
        key: np.reshape(value, (-1, 1)) if isinstance(value, list) else value
        for key, value in record.items()
    }
    try:
        return Contact(**bodies, **drawn), Contact(**bodies, **best, **texts)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{name}: {error}") from None
