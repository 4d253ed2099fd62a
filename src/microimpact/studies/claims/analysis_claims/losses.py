"""Claims decided by the losses and the damping of normal impacts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from microimpact.core.arrays import FloatArray, Real
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.empirical.batch import data_sets, fit_batch, interval_batch
from microimpact.model.rigid_body.algebra import adhesion_work
from microimpact.statistics.distributions import generator
from microimpact.studies.claims.analysis_claims.context import Context

ANALYSIS = 104
CONFIDENCE = 0.95
# Points of curves over speed, and of a trajectory whose works are added up.
POINTS, INSTANTS = 60, 4001
# How far from the known capture velocity another is sought, as a logarithm.
REACH = 3.0


def c70(context: Context, contact: Contact) -> dict[str, float]:
    """Return the share of the loss at the nominal speed that goes into damped adhesion."""
    found = works(contact, np.array([context.params.losses.speed_m_per_s]))
    share = found.adhesion / (found.adhesion + found.material)
    return {"adhesion_share_of_normal_loss": float(share[0])}


def c99(context: Context, contact: Contact) -> dict[str, float]:
    """Return the error of e at speeds not fitted, and how far members of the family differ."""
    losses = context.params.losses
    e = simulate(contact, np.array(losses.held_out_speeds_m_per_s)).coefficient_of_restitution
    at_open_speed = [
        float(simulate(member, losses.open_speed_m_per_s).coefficient_of_restitution)
        for member in flat_members(context, contact)
    ]
    return {
        "largest_error_at_0p75_1_and_3_m_per_s": float(np.max(np.abs(e - losses.plateau))),
        "spread_of_members_at_0p45_m_per_s": float(np.ptp(at_open_speed)),
    }


def flat_members(context: Context, contact: Contact) -> list[Contact]:
    """Return the members of the family that keep e flat enough, of all rate exponents.

    Raises
    ------
    ValueError
        If there is none.
    """
    table = context.inputs["calibration_family"]
    flat = table[table["deviation_from_plateau"] <= context.params.losses.flat_within]
    if flat.empty:
        raise ValueError("flat_within: no member of the calibrated family is so flat")
    return [
        contact.replace(
            work_of_adhesion=float(row["work_of_adhesion_J_per_m2"]),
            hertz_damping=float(row["hertz_damping_s_per_m"]),
            adhesion_damping=float(row["adhesion_damping_s_per_m"]),
            adhesion_rate_exponent=float(row["rate_exponent"]),
        )
        for _, row in flat.iterrows()
    ]


def c100(context: Context, contact: Contact) -> dict[str, float]:
    """Return what it changes to hold zeta at each impact's own speed, or at another nominal one."""
    losses = context.params.losses
    speed = np.geomspace(*losses.normalised_speeds_m_per_s, POINTS)
    e = simulate(contact, speed).coefficient_of_restitution
    own = simulate(at_own_speed(contact, speed), speed).coefficient_of_restitution
    other = renormalised(contact, losses.other_speed_m_per_s)
    again = simulate(other, speed).coefficient_of_restitution
    return {
        "largest_change_of_restitution_with_each_speed": float(np.max(np.abs(own - e))),
        "largest_change_of_restitution_with_another_nominal_speed": float(
            np.max(np.abs(again - e))
        ),
        "capture_velocity_ratio_with_each_speed": capture_ratio(contact),
    }


def at_own_speed(contact: Contact, speed: Real) -> Contact:
    """Return the contact with the zeta of Eqs. (23) and (24) held, v_N the speed of each impact."""
    unit = contact.replace(reference_velocity=speed).damping_unit / contact.damping_unit
    return contact.replace(
        hertz_damping=contact.hertz_damping * unit, adhesion_damping=contact.adhesion_damping * unit
    )


def renormalised(contact: Contact, speed: float) -> Contact:
    """Return the same contact by zeta at another nominal speed."""
    # damping that varies with the rate is quoted at the nominal speed
    adhesion = contact.adhesion_damping_at(speed)
    bare = contact.replace(reference_velocity=speed)
    return Contact.from_zeta(
        zeta_hertz=contact.hertz_damping / bare.damping_unit,
        zeta_adhesion=adhesion / bare.damping_unit,
        reference_velocity=speed,
        particle=contact.particle,
        surface=contact.surface,
        diameter=contact.diameter,
        work_of_adhesion=contact.work_of_adhesion,
        friction=contact.friction,
        adhesion_rate_exponent=contact.adhesion_rate_exponent,
    )


def capture_ratio(contact: Contact) -> float:
    """Return the capture velocity with zeta at each speed over that with one; 1 without damping."""
    limit = float(capture_velocity(contact))
    if limit == 0.0:
        return 1.0

    def excess(log_speed: float) -> float:
        speed = float(np.exp(log_speed))
        return log_speed - float(np.log(capture_velocity(at_own_speed(contact, speed))))

    start = float(np.log(limit))
    return float(
        np.exp(scipy.optimize.brentq(excess, start - REACH, start + REACH, xtol=1e-12) - start)
    )


def c101(context: Context, contact: Contact) -> dict[str, float]:
    """Return W_A of Eq. (18), R from impacts without adhesion, over the simulated adhesion loss."""
    speed = np.array(context.params.losses.speeds_m_per_s)
    body = body_restitution(contact, speed)
    e = simulate(contact, speed).coefficient_of_restitution
    rigid = adhesion_work(speed, body, 1.0 - e / body)
    ratio = rigid / works(contact, speed).adhesion
    return {
        "least_ratio_of_works": float(ratio.min()),
        "greatest_ratio_of_works": float(ratio.max()),
    }


def c102(context: Context, contact: Contact) -> dict[str, float]:
    """Return (1 - R^2) v^2/2, R from impacts without adhesion, over the simulated material loss."""
    speed = np.array(context.params.losses.speeds_m_per_s)
    body = 0.5 * (1.0 - np.square(body_restitution(contact, speed))) * np.square(speed)
    ratio = body / works(contact, speed).material
    return {
        "least_ratio_of_material_losses": float(ratio.min()),
        "greatest_ratio_of_material_losses": float(ratio.max()),
    }


def body_restitution(contact: Contact, speed: FloatArray) -> FloatArray:
    """Return R, the restitution of the same contact without ring force."""
    return simulate(contact.replace(work_of_adhesion=0.0), speed).coefficient_of_restitution


class Works(NamedTuple):
    """Energy lost per unit mass to the damping of adhesion and of the material, m2/s2."""

    adhesion: FloatArray
    material: FloatArray


def works(contact: Contact, speed: FloatArray) -> Works:
    """Return the losses of normal impacts."""
    ledger = normal_impact(contact, speed, ledger=True).ledger
    assert ledger is not None
    return Works(ledger.adhesion_work / contact.mass, ledger.hertz_work / contact.mass)


def c103(context: Context) -> dict[str, float]:
    """Return r/T_H over the group of Eqs. (23) and (24), for an elastic sphere."""
    contact = context.ridge[0].contact
    speed = context.params.losses.speed_m_per_s
    elastic = contact.replace(
        work_of_adhesion=0.0, hertz_damping=0.0, adhesion_damping=0.0, reference_velocity=speed
    )
    ratio = elastic.hertz_radius / hertz_period(elastic, speed) * elastic.damping_unit
    return {"ratio_of_expressions": float(ratio)}


def hertz_period(elastic: Contact, speed: float) -> Real:
    """Return the duration of an elastic impact without adhesion, s."""
    return float(simulate(elastic, speed).contact_time)


def c104(context: Context, contact: Contact) -> dict[str, float]:
    """Return the width of the interval of v_c by Eq. (34), over v_c; the median of some sets."""
    losses = context.params.losses
    limit = float(capture_velocity(contact))
    speed = limit * np.geomspace(losses.fitted_from, losses.fitted_to, losses.rebounds)
    e = simulate(contact, speed).coefficient_of_restitution
    sigma = restitution_noise(context, speed, e)
    rng = generator(context.params.seed, ANALYSIS)
    measured = np.maximum(e + sigma * rng.standard_normal((losses.data_sets, e.size)), 0.0)
    sets = data_sets(speed, measured, (measured > 0.0) / sigma)
    ends = interval_batch(sets, fit_batch(sets), scipy.special.chdtri(1, 1.0 - CONFIDENCE))
    return {"relative_width_of_profile_interval": float(np.median(np.diff(ends)) / limit)}


def restitution_noise(context: Context, speed: FloatArray, e: FloatArray) -> FloatArray:
    """Return the standard deviation of e of one event: noise of both speeds by the analyser."""
    noise = context.params.losses.instrument.velocity_noise
    return np.asarray(np.hypot(noise(e * speed), e * noise(speed)) / speed)


def c108(context: Context, contact: Contact) -> dict[str, float]:
    """Return the share of the loss to damped adhesion that falls on the rebound."""
    losses = context.params.losses
    damped = contact.replace(damped_attachment=losses.attachment_damped)
    path = trajectory(damped, losses.speed_m_per_s, points=INSTANTS)
    power = np.abs(path.adhesion_damping_force * path.velocity)
    leaving = path.velocity > 0.0
    rebound = np.trapezoid(np.where(leaving, power, 0.0), path.time)
    return {"rebound_share_of_adhesion_loss": float(rebound / np.trapezoid(power, path.time))}
