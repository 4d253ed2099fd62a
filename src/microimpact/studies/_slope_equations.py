"""The article's equations for coefficients measured on a slope, in one form each (Section 4.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from microimpact.arrays import FloatArray, Real
from microimpact.model.roughness import (
    RoughRebound,
    measured_restitution,
    normal_restitution,
    rolling_impulse_ratio_measured,
    rolling_restitution,
    rough_rebound,
    shallow_restitution,
    sloped_impulse_ratio,
)

RESTITUTION, IMPULSE = "restitution", "impulse ratio"
PRINTED, CORRECTED = FORMS = ("printed", "corrected")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Impacts: angle and slope in radians, which broadcast; all else numbers."""

    angle: Real
    slope: Real
    e: float
    friction: float
    spin_ratio: float

    @property
    def rebound(self) -> RoughRebound:
        """The exact rebound."""
        return rough_rebound(self.angle, self.slope, self.e, self.friction, self.spin_ratio)

    @property
    def mu(self) -> FloatArray:
        """Signed impulse ratio about the local normal."""
        return self.rebound.impulse_ratio

    @property
    def sliding(self) -> FloatArray:
        """The impulse ratio if the sphere slid throughout, +-f."""
        return np.copysign(self.friction, self.mu)


@dataclass(frozen=True, slots=True, kw_only=True)
class Equation:
    """One equation of the article for a measured coefficient.

    Parameters
    ----------
    name, quantity
        Its number, and which coefficient it gives.
    shallow
        Whether it is for shallow incidence; else for normal incidence.
    spun
        Whether spin stands in it.
    form
        Its value for a case, as printed (True) or as it should be.
    """

    name: str
    quantity: str
    shallow: bool
    spun: bool = False
    form: Callable[[Case, bool], Real]

    def exact(self, case: Case) -> FloatArray:
        """Return the measured coefficient without expansion."""
        rebound = case.rebound
        if self.quantity == RESTITUTION:
            return rebound.measured_restitution
        return rebound.measured_impulse_ratio

    def value(self, case: Case, form: str) -> FloatArray:
        """Return what the equation gives, in the shape of the exact value."""
        exact = self.exact(case)
        return np.broadcast_to(self.form(case, form == PRINTED), np.shape(exact))

    def error(self, case: Case, form: str) -> FloatArray:
        """Return the error relative to the exact value."""
        exact = self.exact(case)
        return np.abs(self.value(case, form) - exact) / np.abs(exact)


EQUATIONS = {
    equation.name: equation
    for equation in (
        Equation(
            name="35",
            quantity=RESTITUTION,
            shallow=True,
            form=lambda c, p: measured_restitution(c.angle, c.slope, c.e, c.mu, printed=p),
        ),
        Equation(
            name="37",
            quantity=RESTITUTION,
            shallow=True,
            form=lambda c, p: shallow_restitution(c.angle, c.slope, c.e, c.sliding, printed=p),
        ),
        Equation(
            name="38",
            quantity=IMPULSE,
            shallow=True,
            form=lambda c, p: sloped_impulse_ratio(c.slope, c.sliding, printed=p),
        ),
        Equation(
            name="39",
            quantity=RESTITUTION,
            shallow=False,
            spun=True,
            form=lambda c, p: normal_restitution(c.slope, c.e, c.mu, printed=p),
        ),
        Equation(
            name="after 40",
            quantity=RESTITUTION,
            shallow=False,
            form=lambda c, p: rolling_restitution(c.slope, c.e, c.spin_ratio, printed=p),
        ),
        Equation(
            name="41",
            quantity=IMPULSE,
            shallow=False,
            spun=True,
            form=lambda c, p: rolling_impulse_ratio_measured(c.slope, c.e, c.spin_ratio, printed=p),
        ),
    )
}
