"""Doubts about a contact and an impact: numbers that are allowed but hardly meant."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from microimpact.core.arrays import Real
from microimpact.core.plausible import PLACES, PLAUSIBLE, implausible
from microimpact.model.contact import Contact

# Far above the speeds at which any solid stays elastic.
FASTEST = 1e3  # m/s
# Beyond it a facet hides its neighbours, which no model of a rough surface here considers.
STEEPEST = 0.5  # rad
# Of the radius: beyond it the contact is no small circle on a sphere.
DEEPEST = 0.1
# Of the softer body's modulus: hardly anything stays elastic beyond it.
HIGHEST = 0.05


def doubt_of_input(key: str, value: object) -> str:
    """Return the doubt about a diameter, speed or slope of the configuration, by its key's words.

    Metres for micrometres are the commonest slip. Nothing is said of what is likely.
    """
    *_, above, name = ("", *key.partition("[")[0].split("."))
    name = above if name in PLACES else name
    if not isinstance(value, int | float) or isinstance(value, bool):
        return ""
    if "diameter" in name and name.endswith("_um"):
        low, high = (1e6 * end for end in PLAUSIBLE["diameter"][:2])
        unit = "um"
    elif name.startswith("speed") and name.endswith("_m_per_s"):
        low, high, unit = 0.0, FASTEST, "m/s"
    elif name.endswith("slope"):
        low, high, unit = -STEEPEST, STEEPEST, "rad"
    else:
        return ""
    allowed = f"from {low:g} to {high:g} {unit}"
    return "" if low <= value <= high else f"{key}: {value:g} {unit} must be {allowed}"


def doubts(
    contact: Contact, compression: Real | None = None, yield_strength: float | None = None
) -> Iterator[str]:
    """Doubts about a contact, each in a sentence that names the number.

    Parameters
    ----------
    contact
        Contact whose fields may have any shape.
    compression
        Greatest compression of impacts, m.
    yield_strength
        Of the softer body, Pa, against which the pressure is held.
    """
    # The integrator is slow to import, and inputs are checked without it.
    from microimpact.model.dynamics.capture import capture_velocity

    for role in ("particle", "surface"):
        yield from implausible(getattr(contact, role), f"{role}: ")
    yield from implausible(contact)
    if np.all(np.isinf(capture_velocity(contact))):
        yield "no sphere leaves this contact at any speed: it is overdamped"
    if compression is not None:
        yield from _about_the_impact(contact, compression, yield_strength)


def _about_the_impact(
    contact: Contact, compression: Real, yield_strength: float | None
) -> Iterator[str]:
    depth = float(np.max(np.asarray(compression) / contact.hertz_radius))
    if depth > DEEPEST:
        yield f"the greatest compression is {depth:.2g} of the radius: Hertz's contact is small"
    pressure = 1.5 / np.pi * contact.hertz_stiffness * np.sqrt(depth)
    softer = np.minimum(contact.particle.youngs_modulus, contact.surface.youngs_modulus)
    share = float(np.max(pressure / softer))
    if share > HIGHEST:
        yield (
            f"the greatest pressure, {float(np.max(pressure)):.3g} Pa, is {share:.2g} of Young's "
            "modulus: most materials yield"
        )
    if yield_strength is None:
        return
    from microimpact.model.closed_forms import YIELD_PRESSURE_RATIO, yield_velocity

    onset = YIELD_PRESSURE_RATIO * yield_strength
    if np.max(pressure) > onset:
        slowest = float(np.min(yield_velocity(contact, yield_strength)))
        yield (
            f"the greatest pressure, {float(np.max(pressure)):.3g} Pa, is above {onset:.3g} Pa, "
            f"{YIELD_PRESSURE_RATIO:g} times the yield strength: impacts above {slowest:.2g} m/s "
            "are plastic"
        )
