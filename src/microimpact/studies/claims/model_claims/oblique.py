"""Numbers behind the claims on oblique impacts of steel on silicon."""

from __future__ import annotations

import numpy as np

from microimpact.core.arrays import FloatArray
from microimpact.model.contact import Contact
from microimpact.model.dynamics.impact import Impact, simulate
from microimpact.model.rigid_body.algebra import INERTIA
from microimpact.model.rigid_body.roughness import measured_restitution
from microimpact.studies.claim_numbers import Numbers
from microimpact.studies.claims.model_claims.context import (
    Context,
    boundary,
    without_adhesion,
)

# Speeds in m/s between which that of capture is sought: none below, all above.
SLOWEST, FASTEST = 1e-3, 1e2


def c09(context: Context) -> dict[str, float]:
    """Normal speed of capture at 30 deg over that at 90 deg, the larger ratio of all cases."""
    shallow, steep = context.params.oblique.captured_at_deg
    ratios = [
        normal_capture_speed(case, shallow) / normal_capture_speed(case, steep)
        for case in context.cases()
    ]
    return {"normal_capture_speed_ratio_30_to_90_deg": max(ratios)}


def normal_capture_speed(context: Context, angle: float) -> float:
    """Return the speed normal to the nominal surface at which simulated impacts begin to rebound.

    The sphere meets a facet that faces it by the slope declared, as a rule none.
    """
    steel, local = context.steel, angle + context.params.oblique.facet_slope_deg
    local = min(local, 180.0 - local)

    def rebounds(log_speed: float) -> bool:
        return not context.hit(steel, np.exp(log_speed), local).captured

    speed = np.exp(boundary(rebounds, np.log(SLOWEST), np.log(FASTEST)))
    return float(speed * np.sin(np.radians(angle)))


def c10(context: Context) -> dict[str, float]:
    """Angle at which the sphere that leaves begins to roll."""
    steel = context.steel
    shallowest = float(context.rebounds(steel)[0].min())

    def rolls(angle: float) -> bool:
        return bool(context.hit(steel, context.speed, angle).rolling)

    return {"rolling_to_sliding_angle": boundary(rolls, shallowest, 90.0)}


def c11(context: Context) -> dict[str, float]:
    """Greatest true and measured restitution over shallow angles and facets up to the angle.

    The impact with the facet is simulated; Eq. (35) gives what is measured about the nominal
    surface. The largest over all cases.
    """
    oblique = context.params.oblique
    angles = np.linspace(*oblique.rough_angles_deg, oblique.points)[:, None]
    slopes = angles * np.linspace(0.0, 1.0, oblique.points)
    true, measured, bounded = [], [], []
    for case in context.cases():
        impact = case.hit(case.steel, context.speed, angles + slopes)
        e, mu = impact.coefficient_of_restitution, -impact.impulse_ratio
        seen = np.asarray(measured_restitution(np.radians(angles), np.radians(slopes), e, mu))
        free = ~impact.captured
        true.append(e[free].max())
        measured.append(seen[free].max())
        bounded.append((seen * np.sin(np.radians(angles)))[free].max())
    return {
        "largest_true_restitution": max(true),
        "largest_measured_restitution": max(measured),
        "largest_measured_restitution_times_sine": max(bounded),
    }


def c12(context: Context) -> dict[str, float]:
    """Change of the translational loss between 85 and 50 deg, over its value at 85 deg."""
    steep, shallow = context.params.oblique.level_loss_deg
    loss = translational_loss(context, context.params.oblique.loss_speed_m_per_s, steep, shallow)
    return {"largest_relative_change_of_energy_loss": np.max(np.abs(loss / loss[0] - 1.0))}


def c13(context: Context) -> dict[str, float]:
    """Translational loss at 10 deg, and its greatest rise above any value at a steeper angle."""
    loss = translational_loss(context, context.speed, *context.params.oblique.falling_loss_deg)
    return {
        "energy_loss_at_10_deg": loss[-1],
        "largest_rise_towards_shallow_angles": np.max(loss - np.minimum.accumulate(loss)),
    }


def translational_loss(context: Context, speed: float, steep: float, shallow: float) -> FloatArray:
    """Return the loss of Eq. (3) in all steps from the steep angle to the shallow one."""
    angles = context.all_angles(steep, shallow)
    return np.asarray(context.hit(context.steel, speed, angles).translational_energy_loss)


def c19(context: Context) -> dict[str, float]:
    """Impulse ratio over the coefficient of friction, the largest over all rebounds."""
    _, impact = context.rebounds(context.steel)
    ratio = np.max(impact.impulse_ratio) / context.params.steel.friction
    return {"largest_impulse_ratio_over_friction": ratio}


def c22(context: Context) -> dict[str, float]:
    """Signed impulse ratio of Eq. (2) at normal incidence with spin of either sign and without."""
    spin = context.params.oblique.normal_spin_ratio * context.speed / context.steel.radius
    impact = simulate(context.steel, context.speed, 90.0, np.array([spin, -spin, 0.0]))
    positive, negative, none = -impact.impulse_ratio
    return {
        "signed_impulse_ratio_positive_spin": positive,
        "signed_impulse_ratio_negative_spin": negative,
        "signed_impulse_ratio_no_spin": none,
    }


def c23(context: Context) -> dict[str, float]:
    """Impulse ratio at the shallowest angle of adhesive rebound over that at 15 deg.

    With adhesion, and without at the same two angles.
    """
    steel = context.steel
    shallowest = context.rebounds(steel)[0].min()

    def rise(contact: Contact) -> float:
        ends = np.array([shallowest, context.params.oblique.plateau_deg])
        ratio = context.hit(contact, context.speed, ends).impulse_ratio
        return float(ratio[0] / ratio[1])

    return {
        "rise_to_shallowest_rebound_with_adhesion": rise(steel),
        "rise_to_shallowest_rebound_without_adhesion": rise(without_adhesion(steel)),
    }


def c39(context: Context) -> dict[str, float]:
    """Spin after the impact at 50 deg."""
    angle = context.params.oblique.spin_angle_deg
    return {"final_spin_at_50_deg": float(context.hit(context.steel, context.speed, angle).spin)}


def c40(context: Context) -> dict[str, float]:
    """Spin after impact, the largest over all rebounds."""
    _, impact = context.rebounds(context.steel)
    return {"largest_final_spin": np.max(np.abs(impact.spin))}


def c59(context: Context) -> dict[str, float]:
    """Loss of energy, rotation included, with friction less that without; least of all rebounds."""
    steel = context.steel
    angles, impact = context.rebounds(steel, np.array(context.params.steel.angles_deg))
    oblique = angles < 90.0
    smooth = context.hit(steel.replace(friction=0.0), context.speed, angles)
    return {
        "least_added_loss_of_total_energy": np.min(
            (impact.energy_loss - smooth.energy_loss)[oblique]
        )
    }


def rotational_share(contact: Contact, impact: Impact) -> float:
    """Return the share of rotation in the kinetic energy after an impact."""
    rotation = INERTIA * np.square(contact.radius * impact.spin)
    moving = np.square(impact.normal_velocity) + np.square(impact.tangential_velocity)
    return float(rotation / (rotation + moving))


CLAIMS = {
    "C09": Numbers(of=c09),
    "C10": Numbers(of=c10, by_case=True, units={"rolling_to_sliding_angle": "deg"}),
    "C11": Numbers(of=c11),
    "C12": Numbers(of=c12, by_case=True),
    "C13": Numbers(of=c13, by_case=True),
    "C19": Numbers(of=c19, by_case=True),
    "C22": Numbers(of=c22, by_case=True),
    "C23": Numbers(of=c23, by_case=True),
    "C39": Numbers(of=c39, by_case=True, units={"final_spin_at_50_deg": "rad/s"}),
    "C40": Numbers(of=c40, by_case=True, units={"largest_final_spin": "rad/s"}),
    "C59": Numbers(of=c59, by_case=True),
}
