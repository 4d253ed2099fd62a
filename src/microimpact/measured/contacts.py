"""Calibrated contacts in a file, to hand them from one command to others."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from dataclasses import fields as dataclass_fields
from pathlib import Path
from typing import Any

import numpy as np

from microimpact.core.files import write_file
from microimpact.core.materials import Material
from microimpact.core.nearest import nearest
from microimpact.model.choices import NUMBERS
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import LAWS

TEXTS = ("stiffness_model",)
PARTNER = "partner_diameter"


def write_contacts(
    path: Path | str, contacts: Mapping[str, Contact], best: Mapping[str, Contact]
) -> None:
    """Write contacts as JSON in SI units.

    Parameters
    ----------
    path
        The file.
    contacts
        By the name of their law, the heaviest first: one contact, or an array of draws (draws,).
    best
        The best draw by each law.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    first = next(iter(best.values()))
    record: dict[str, Any] = {
        role: asdict(getattr(first, role)) for role in ("particle", "surface")
    }
    record["laws"] = {
        law: _numbers(contact) | {"best": _numbers(best[law])} for law, contact in contacts.items()
    }
    write_file(path, json.dumps(record, indent=1, allow_nan=False) + "\n")


def _numbers(contact: Contact) -> dict[str, Any]:
    """Numbers and words of a contact, beside those of its bodies."""
    names = (*NUMBERS, PARTNER) if contact.is_pair else NUMBERS
    record = {name: getattr(contact, name) for name in names}
    if contact.law is not None:
        record |= {"law": contact.law.name, **contact.law.parameters}
    plain = {
        name: value if value is None or isinstance(value, str) else np.asarray(value).tolist()
        for name, value in record.items()
    }
    return plain | {name: getattr(contact, name) for name in TEXTS}


def read_contacts(path: Path | str) -> tuple[dict[str, Contact], dict[str, Contact]]:
    """Read a file that `write_contacts` wrote.

    Returns
    -------
    contacts
        By law; their arrays have the shape (draws, 1), to broadcast with speeds.
    best
        The best draw by each law.

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
        laws = {law: (numbers, numbers.pop("best")) for law, numbers in record["laws"].items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(
            f"{name} must be a file that 'microimpact calibrate -o' wrote: {error}"
        ) from None
    contacts, best = {}, {}
    try:
        for law, (numbers, best_numbers) in laws.items():
            contacts[law] = _contact(bodies, numbers)
            best[law] = _contact(bodies, best_numbers)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{name}: {error}") from None
    return contacts, best


def _contact(bodies: Mapping[str, Any], record: Mapping[str, Any]) -> Contact:
    """Contact of the numbers that `_numbers` returns; arrays become (draws, 1)."""
    fields: dict[str, Any] = {
        key: np.reshape(value, (-1, 1)) if isinstance(value, list) else value
        for key, value in record.items()
    }
    known: tuple[str, ...] = (*NUMBERS, PARTNER, *TEXTS)
    if "law" in fields:
        kinds = {kind.name: kind for kind in LAWS}
        law = kinds.get(fields.pop("law"))
        if law is None:
            raise ValueError(f"law must be one of {', '.join(kinds)}, got {record['law']!r}")
        parameters = {field.name: fields.pop(field.name, None) for field in dataclass_fields(law)}
        fields["law"] = law(**parameters)
        known = (*known, "law")
    for key in fields:
        if key not in known:
            raise ValueError(f"{key!r} unknown{nearest(key, NUMBERS)}")
    return Contact(**bodies, **fields)
