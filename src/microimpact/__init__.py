"""microimpact: impact, rebound and capture of microparticles.

A reproducibility study of "Experiments and Engineering Models of Microparticle Impact and
Deposition" (Brach, Dunn and Li, J. Adhesion 74, 2000), and its models for use on other particles
and surfaces. Names are loaded on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from microimpact.core.materials import Material as Material
    from microimpact.model.contact import Contact as Contact
    from microimpact.model.contact_laws import JKR as JKR
    from microimpact.model.contact_laws import Hysteresis as Hysteresis
    from microimpact.model.contact_laws import ThorntonNing as ThorntonNing
    from microimpact.model.dynamics.capture import capture_velocity as capture_velocity
    from microimpact.model.dynamics.impact import Impact as Impact
    from microimpact.model.dynamics.impact import SpatialImpact as SpatialImpact
    from microimpact.model.dynamics.impact import planar as planar
    from microimpact.model.dynamics.impact import simulate as simulate
    from microimpact.model.dynamics.impact import spatial as spatial
    from microimpact.model.dynamics.trajectory import Trajectory as Trajectory
    from microimpact.model.dynamics.trajectory import trajectory as trajectory
    from microimpact.model.empirical.bootstrap import bootstrap_v_c as bootstrap_v_c
    from microimpact.model.empirical.comparison import compare_models as compare_models
    from microimpact.model.empirical.equations import restitution as restitution
    from microimpact.model.empirical.fit import fit_restitution as fit_restitution
    from microimpact.model.law.table import Law as Law
    from microimpact.model.law.table import tabulate as tabulate
    from microimpact.model.posterior import calibrate as calibrate
    from microimpact.model.rigid_body.algebra import rigid_body_rebound as rigid_body_rebound
    from microimpact.run.study import run_study as run_study

_HOME = {
    "Material": "core.materials",
    "Contact": "model.contact",
    "Hysteresis": "model.contact_laws",
    "JKR": "model.contact_laws",
    "Law": "model.law.table",
    "ThorntonNing": "model.contact_laws",
    "Impact": "model.dynamics.impact",
    "SpatialImpact": "model.dynamics.impact",
    "Trajectory": "model.dynamics.trajectory",
    "bootstrap_v_c": "model.empirical.bootstrap",
    "calibrate": "model.posterior",
    "capture_velocity": "model.dynamics.capture",
    "compare_models": "model.empirical.comparison",
    "fit_restitution": "model.empirical.fit",
    "planar": "model.dynamics.impact",
    "restitution": "model.empirical.equations",
    "rigid_body_rebound": "model.rigid_body.algebra",
    "simulate": "model.dynamics.impact",
    "spatial": "model.dynamics.impact",
    "tabulate": "model.law.table",
    "trajectory": "model.dynamics.trajectory",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("microimpact")
    if name == "run_study":
        return _run_study()
    if name not in _HOME:
        raise AttributeError(f"module 'microimpact' has no attribute {name!r}")
    return getattr(import_module(f"microimpact.{_HOME[name]}"), name)


def _run_study() -> object:
    try:
        study = import_module("microimpact.run.study")
    except ModuleNotFoundError as error:
        raise ImportError(
            f"run_study needs the packages of the study ({error}): pip install '.[study]'"
        ) from error
    return study.run_study


def __dir__() -> list[str]:
    return __all__
