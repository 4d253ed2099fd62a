"""Numbers of the claims of Section 3.3: capture velocities by the empirical equations."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import scipy
from pydantic import Field

from microimpact.core.computable import NotComputable
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical.data import DataSets, data_sets
from microimpact.model.empirical.fit import fit_restitution
from microimpact.model.empirical.intervals import interval_batch
from microimpact.model.empirical.search import fit_batch
from microimpact.statistics.distributions import generator
from study.claims.claim import RIDGE, Claim, Number
from study.claims.context import Context, Estimate, Numbers
from study.declared.parameters import AboveOne, Count

ANALYSIS = 104
CONFIDENCE = 0.95
# Standard error of a median over that of the mean, of a normal distribution.
MEDIAN_ERROR = 1.2533
# Fastest of the fitted rebounds in capture velocities, as for Fig. 16.
FITTED_TO = 15.0

Rebounds = Annotated[int, Field(ge=8)]


# Readings of "finds it", in standard errors of one experiment.
READINGS = {"typical experiment": 1.0, "19 of 20 experiments": 1.96}


@Claim(
    "C43",
    "A fit of the empirical equations to rebounds alone finds the capture velocity.",
    says=(
        "The fitted capture velocity is wrong by {relative_error_of_fitted_capture_velocity:%}, "
        "from a typical experiment to the worst but one of twenty; accepted is "
        "{relative_error_of_fitted_capture_velocity:bound %}."
    ),
    where="3.3, 7, Figs. 15 and 16",
    quote="using impact data from experiments where capture never actually occurs",
    article="equal",
    numbers={
        "relative_error_of_fitted_capture_velocity": Number(
            "relative error of the fitted capture velocity", at_most=0.1
        ),
        "relative_error_without_noise": Number(),
        "relative_error_from_later_data": Number(
            "relative error from data above [[late_from:g]] capture velocities"
        ),
    },
    reason=(
        "About means 10 % of the simulation's own capture velocity, over sets of [[rebounds]] "
        "rebounds from [[fitted_from:g]] capture velocities upwards, with the speed noise of the "
        "instrument and all exponents free. How many experiments must find it so is not said: the "
        "error of a typical one, the rms, and that kept by 19 of 20 are both cases."
    ),
    cases=tuple(f"{case}, {reading}" for case in RIDGE for reading in READINGS),
    figures="fig15 fig16",
    equations="32 33 34",
    by_case=True,
)
def c43(
    context: Context,
    *,
    fitted_from: AboveOne,
    late_from: AboveOne,
    rebounds: Rebounds,
    data_sets: Count,
) -> Numbers:
    """Capture velocity by Eq. (34) over the simulated one, less 1, exponents free.

    The rms over some sets of rebounds with the noise of the instrument; without noise from data
    close above capture, by the table of the fits, and from two capture velocities.
    """
    rows = context.table("restitution_fits", exponent="free")
    if len(rows) != 1:
        raise NotComputable(
            f"restitution_fits: {len(rows)} fits of case {context.case!r}, need one"
        )
    fitted, limit = rows["v_c_m_per_s"].iloc[0], rows["simulated_v_c_m_per_s"].iloc[0]
    steel_limit = float(capture_velocity(context.steel))
    ratios = np.geomspace(late_from, FITTED_TO, rebounds)
    e = simulate(context.steel, ratios * steel_limit).coefficient_of_restitution
    later = fit_restitution(ratios * steel_limit, e).v_c
    sets = noisy_sets(context, fitted_from, rebounds, data_sets)
    misfits = fit_batch(sets).parameters[:, -1] / steel_limit - 1.0
    rms = np.sqrt(np.mean(np.square(misfits)))
    scatter = np.std(np.square(misfits)) / (2.0 * rms * np.sqrt(len(misfits)))
    return {
        reading: {
            "relative_error_of_fitted_capture_velocity": Estimate(errors * rms, errors * scatter),
            "relative_error_without_noise": fitted / limit - 1.0,
            "relative_error_from_later_data": later / steel_limit - 1.0,
        }
        for reading, errors in READINGS.items()
    }


@Claim(
    "C104",
    "The empirical equations determine a unique capture velocity from rebounds.",
    says=(
        "The interval of the fitted capture velocity has a width of "
        "{relative_width_of_profile_interval:%}; unique is "
        "{relative_width_of_profile_interval:bound %}."
    ),
    where="7, Fig. 15",
    quote="automatically determine a unique value of the capture velocity",
    article="unique",
    numbers={
        "relative_width_of_profile_interval": Number(
            "relative width of the profile interval", at_most=0.2
        ),
    },
    reason=(
        'Unique means a 95 % interval no wider than 10 % to either side ("about"), for '
        "[[rebounds]] rebounds from [[fitted_from:g]] capture velocities upwards, with the speed "
        "noise of the instrument and all exponents free."
    ),
    cases=RIDGE,
    figures="fig15 fig16",
    equations="34",
    by_case=True,
)
def c104(
    context: Context, *, fitted_from: AboveOne, rebounds: Rebounds, data_sets: Count
) -> Numbers:
    """Width of the interval of v_c by Eq. (34), over v_c; the median of some sets."""
    sets = noisy_sets(context, fitted_from, rebounds, data_sets)
    ends = interval_batch(sets, fit_batch(sets), scipy.special.chdtri(1, 1.0 - CONFIDENCE)).ends
    width = np.diff(ends) / float(capture_velocity(context.steel))
    error = MEDIAN_ERROR * np.std(width) / np.sqrt(width.size)
    return {"relative_width_of_profile_interval": Estimate(np.median(width), error)}


def noisy_sets(context: Context, fitted_from: float, rebounds: int, sets: int) -> DataSets:
    """Return sets of rebounds with the noise of the instrument.

    Their speeds begin at `fitted_from` times the capture velocity.
    """
    contact = context.steel
    speed = float(capture_velocity(contact)) * np.geomspace(fitted_from, FITTED_TO, rebounds)
    e = simulate(contact, speed).coefficient_of_restitution
    # Of one event: noise of both speeds by the analyser.
    noise = context.params.analyser.velocity_noise
    sigma = np.asarray(np.hypot(noise(e * speed), e * noise(speed)) / speed)
    rng = generator(context.params.sampling.seed, ANALYSIS)
    measured = np.maximum(e + sigma * rng.standard_normal((sets, e.size)), 0.0)
    return data_sets(speed, measured, (measured > 0.0) / sigma)
