"""Settings that claims share; those of one are the keyword arguments of its function."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import AfterValidator, Field

from microimpact.lab.pdpa.analyser import Analyser
from microimpact.lab.ptis.system import ImagingSystem
from microimpact.model.choices import FrictionBasis
from study.declared.parameters import (
    AngleDegrees,
    CaseName,
    Count,
    Finite,
    Fraction,
    InferredName,
    Positive,
    ScenarioName,
)
from study.studies.samples import Sampling


def _descending(angles: tuple[float, float]) -> tuple[float, float]:
    """Refuse angles that do not run from a steep one to a shallow one."""
    steep, shallow = angles
    if steep <= shallow:
        raise ValueError(f"[{steep:g}, {shallow:g}] must descend")
    return angles


Angles = Annotated[tuple[AngleDegrees, ...], Field(min_length=2)]
AngleRange = tuple[AngleDegrees, AngleDegrees]
SteepToShallow = Annotated[AngleRange, AfterValidator(_descending)]
FacingDegrees = Annotated[float, Field(gt=-90, lt=90)]
Rebounds = Annotated[int, Field(ge=8)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Steel:
    """Steel on silicon, and the impact that a claim means unless it says otherwise."""

    # Calibrated cases of the pair, between which the published facts leave the choice open.
    cases: Annotated[tuple[CaseName, ...], Field(min_length=1)]
    # Spin as r omega over v; restitution as printed.
    diameter_um: Positive
    speed_m_per_s: Positive
    restitution: Fraction
    friction: Fraction
    spin_ratio: Finite
    friction_basis: FrictionBasis  # Normal force in Coulomb's law
    angles_deg: Angles  # Declared angles of incidence
    angle_step_deg: Positive  # Of sweeps over all angles


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Contacts for which claims are computed as well: those drawn of a case, in scenarios."""

    case: InferredName
    scenarios: Annotated[tuple[ScenarioName, ...], Field(min_length=1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Common:
    """Settings that claims share."""

    steel: Steel
    # How samples are drawn, and how many impacts each has where there are many samples.
    sampling: Sampling
    series_impacts: Count
    # Instruments that see events.
    analyser: Analyser
    camera: ImagingSystem
    draws: Draws
