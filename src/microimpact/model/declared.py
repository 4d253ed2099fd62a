"""The declared contacts by their pair: ``contacts["stainless-steel-316 on silicon"]``."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from microimpact.core.declared import materials
from microimpact.core.materials import Declared
from microimpact.model.contact import Contact
from microimpact.model.pairs import declared_pairs, pair_contact

_pairs = declared_pairs()
contacts: Mapping[str, Contact] = MappingProxyType(
    Declared(
        "contact", {" on ".join(pair): pair_contact(*pair, materials, _pairs) for pair in _pairs}
    )
)
