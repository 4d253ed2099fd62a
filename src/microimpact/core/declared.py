"""The declared materials by name, as the command line knows them: ``materials["silicon"]``."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from microimpact.core.materials import Declared, Material, declared_file, read_materials

materials: Mapping[str, Material] = MappingProxyType(
    Declared("material", read_materials(declared_file("materials.csv")))
)
