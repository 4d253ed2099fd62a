"""microimpact: impact, rebound and capture of microparticles.

A reproducibility study of "Experiments and Engineering Models of Microparticle Impact and
Deposition" (Brach, Dunn and Li, J. Adhesion 74, 2000), and its models for use on other particles
and surfaces. Names are loaded on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from microimpact.materials import Material as Material
    from microimpact.model.capture import capture_velocity as capture_velocity
    from microimpact.model.contact import Contact as Contact
    from microimpact.model.impact import Impact as Impact
    from microimpact.model.impact import SpatialImpact as SpatialImpact
    from microimpact.model.impact import planar as planar
    from microimpact.model.impact import simulate as simulate
    from microimpact.model.impact import spatial as spatial
    from microimpact.model.restitution import restitution as restitution
    from microimpact.model.restitution_fit import bootstrap_v_c as bootstrap_v_c
    from microimpact.model.restitution_fit import fit_restitution as fit_restitution
    from microimpact.model.rigid_body import rigid_body_rebound as rigid_body_rebound
    from microimpact.model.trajectory import Trajectory as Trajectory
    from microimpact.model.trajectory import trajectory as trajectory

_HOME = {
    "Material": "materials",
    "Contact": "model.contact",
    "Impact": "model.impact",
    "SpatialImpact": "model.impact",
    "Trajectory": "model.trajectory",
    "bootstrap_v_c": "model.restitution_fit",
    "capture_velocity": "model.capture",
    "fit_restitution": "model.restitution_fit",
    "planar": "model.impact",
    "restitution": "model.restitution",
    "rigid_body_rebound": "model.rigid_body",
    "simulate": "model.impact",
    "spatial": "model.impact",
    "trajectory": "model.trajectory",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'microimpact' has no attribute {name!r}")
    return getattr(import_module(f"microimpact.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return __all__
