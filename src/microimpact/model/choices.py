"""Words that choose between forms of the model, in calls, configuration and command line alike."""

from __future__ import annotations

from typing import Literal, get_args

# Normal force in Coulomb's law.
FrictionBasis = Literal["compressive", "hertz", "net"]
FRICTION_BASES: tuple[str, ...] = get_args(FrictionBasis)
# Compliance along the surface.
TANGENTIAL_LAWS = ("rigid", "mindlin", "spring")
STIFFNESS_MODELS = ("hertz", "reduced")
# Forms in which a rebound law is written.
FORMATS = ("c", "csv", "npz", "fluent", "openfoam", "lammps")
