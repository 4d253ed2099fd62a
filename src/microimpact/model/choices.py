"""Words for forms and numbers of the model, in calls, files and on the command line alike."""

from __future__ import annotations

from typing import Literal, get_args

# Normal force in Coulomb's law.
FrictionBasis = Literal["compressive", "hertz", "net"]
FRICTION_BASES: tuple[str, ...] = get_args(FrictionBasis)
# Laws of contact that can be fitted to a restitution and a capture velocity.
FittedLaw = Literal["jkr", "thornton-ning"]
# Compliance along the surface.
TANGENTIAL_LAWS = ("rigid", "mindlin", "spring")
# What makes a contact of two materials: adhesion, damping, and how damping goes with the rate.
CALIBRATED = (
    *("work_of_adhesion", "hertz_damping", "adhesion_damping"),
    *("adhesion_rate_exponent", "reference_velocity"),
)
# All numbers of a contact beside those of its materials.
NUMBERS = ("diameter", *CALIBRATED, "friction")
STIFFNESS_MODELS = ("hertz", "reduced")
# Quantiles of draws: the ends and the middle of a 95 % interval, the level of all intervals here.
INTERVAL = (0.025, 0.5, 0.975)
# A measured e above 1 is noise up to this many of its standard deviations.
NOISE = 3.0
# Forms in which a rebound law is written.
FORMATS = ("c", "csv", "fluent", "openfoam", "lammps-jkr")
# Those of a wall, which a second sphere is not.
WALL_FORMATS = ("fluent", "openfoam", "lammps-jkr")
