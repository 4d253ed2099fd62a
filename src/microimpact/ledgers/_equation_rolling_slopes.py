"""Section 4.1.2, Eqs. (39) to (41): normal incidence on a slope."""

from __future__ import annotations

from microimpact.ledgers._equation_records import (
    Consequence,
    Equation,
    Values,
    expands,
    follows,
)
from microimpact.ledgers._equation_roughness import (
    STEEP,
    UNITS,
    critical,
    normal_incidence,
    rolling,
    without_spin,
)
from microimpact.model import roughness
from microimpact.model.rigid_body import rolling_impulse_ratio


def _spun(x: Values) -> float:
    return float(rolling_impulse_ratio(x["vp_n"], x["vp_t"] - x["r"] * x["omega"], x["e"]))


EQUATIONS = (
    Equation(
        id="4.1.2 velocity",
        section="4.1.2",
        printed="v_r = 0",
        used="v_t = 0",
        slip="scan",
        units=UNITS,
        derivation=follows("components at 90 degrees", normal_incidence),
        reason="The tangential velocity is meant; v_r is declared nowhere.",
        function="microimpact.model.impact.velocity_components",
    ),
    Equation(
        id="39",
        section="4.1.2",
        printed="e_m = e - phi**2 + (1 + e)*mu_c*phi",
        used="e_m = e - (1 + e)*phi**2 + (1 + e)*mu_c*phi",
        slip="article",
        units=UNITS,
        derivation=expands("normal incidence, second order", normal_incidence, "phi", 2),
        reason="The denominator of Eq. (35) brings another -e phi^2; mu_c is mu_0.",
        function="microimpact.model.roughness.normal_restitution",
        implementation=lambda x: float(roughness.normal_restitution(x["phi"], x["e"], x["mu_c"])),
        consequence=Consequence(
            text="excess of e_m on a slope of 10 degrees, e = 0.70",
            unit="1",
            value=lambda at: at.printed(phi=STEEP) - at.used(phi=STEEP),
        ),
    ),
    Equation(
        id="40",
        section="4.1.2",
        printed="mu_0 = 2/(7*(1 + e))*(vp_t - r*v_omega)/vp_n",
        used="mu_0 = 2/(7*(1 + e))*(vp_t - r*omega)/vp_n",
        slip="scan",
        units=UNITS,
        derivation=follows("Eq. (12) along the local surface", critical),
        reason="The v before omega is no symbol of the article.",
        function="microimpact.model.rigid_body.rolling_impulse_ratio",
        implementation=_spun,
    ),
    Equation(
        id="4.1.2 impulse ratio",
        section="4.1.2",
        printed="(1 + e)*mu_c = -2*phi/7",
        used="(1 + e)*mu_c = 2*phi/7",
        slip="article",
        units=UNITS,
        derivation=expands("rolling without spin, first order", without_spin, "phi", 1),
        reason="v'_t/v'_n is +tan(phi) at normal incidence; Eq. (41) has it so.",
        function="microimpact.model.roughness.rolling_restitution",
        consequence=Consequence(
            text="(1 + e) mu_0 on a slope of 10 degrees, in place of +0.0499",
            unit="1",
            value=lambda at: at.printed(phi=STEEP),
        ),
    ),
    Equation(
        id="4.1.2 restitution",
        section="4.1.2",
        printed="e_m = e - 9*phi**2/7",
        used="e_m = e - (e + 5/7)*phi**2",
        slip="article",
        units=UNITS,
        derivation=expands("rolling without spin, second order", without_spin, "phi", 2),
        reason="Two slips, the sign of mu_c and the missing e phi^2, cancel only at e = 4/7.",
        function="microimpact.model.roughness.rolling_restitution",
        implementation=lambda x: float(roughness.rolling_restitution(x["phi"], x["e"])),
        consequence=Consequence(
            text="excess of e_m on a slope of 10 degrees, e = 0.70",
            unit="1",
            value=lambda at: at.printed(phi=STEEP) - at.used(phi=STEEP),
        ),
    ),
    Equation(
        id="41",
        section="4.1.2",
        printed="mu_m = -phi*(1 - (2/7)/(1 + e)) + (2/7)/(1 + e)*r*v_omega/vp_n",
        used="mu_m = -phi*(1 - (2/7)/(1 + e)) - (2/7)/(1 + e)*r*omega/vp_n",
        slip="article",
        units=UNITS,
        derivation=expands("rolling with spin, first order", rolling, "phi omega", 1),
        reason="v'_n < 0, so the spin adds with a minus; the plus needs v'_n as a speed.",
        function="microimpact.model.roughness.rolling_impulse_ratio_measured",
        consequence=Consequence(
            text="mu_m on a level surface by a spin of r omega/v = 0.2, in place of +0.0336",
            unit="1",
            value=lambda _: float(
                roughness.rolling_impulse_ratio_measured(0.0, 0.70, 0.2, printed=True)
            ),
        ),
    ),
)
