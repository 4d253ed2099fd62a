"""Figures of fit_coverage."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import TWO_STAGES, Figure, Series

if TYPE_CHECKING:
    from study.figures.style import Sheet

LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34 = {
    "noise 0.01, q free": Series(r"$\sigma_e$ = 0.01, $q$ free", 1, mark="square", open=True),
    "noise 0.01, q fixed": Series(r"$\sigma_e$ = 0.01, $q$ = [[fixed_exponent]]", 1, mark="square"),
    "noise 0.03, q free": Series(r"$\sigma_e$ = 0.03, $q$ free", 2, mark="triangle", open=True),
    "noise 0.03, q fixed": Series(
        r"$\sigma_e$ = 0.03, $q$ = [[fixed_exponent]]", 2, mark="triangle"
    ),
    "nominal": Series("nominal coverage", 6, line="dotted"),
}
LOOKS_AVERAGED_COVERAGE_TAKEN_AS_EXACT = {
    "Eq. 34": Series("Eq. 34", 0),
    "steel-silicon, n = 0": Series("ring force, $n$ = 0", 1, mark="square"),
    "steel-silicon, n = 1": Series("ring force, $n$ = 1", 2, mark="triangle"),
    "viscous JKR": Series("JKR, viscous bulk", 3, mark="square", open=True),
    "Thornton-Ning": Series("Thornton and Ning", 4, open=True),
    "foreign curve": Series("curve of no model", 5, mark="triangle", open=True),
    "nominal": Series("nominal", 6, line="dotted"),
}


@Figure(
    "capture_recovery",
    "Capture velocity that Eq. 34 finds from data that never reach capture",
    """
        Error of v_c by Eq. 34, and coverage of its [[confidence:.0%]] profile likelihood
        interval, from [[sets]] virtual experiments per mark that do not reach capture; q free
        (open) and fixed at [[fixed_exponent]] (filled). Left: the truth is Eq. 34. Right: the
        truth is the simulation of [[case]].
    """,
    {
        "bias, Eq. 34": "bias, true curve Eq. 34",
        "bias, simulation": "bias, true curve simulated",
        "rms, Eq. 34": "rms error, true curve Eq. 34",
        "rms, simulation": "rms error, true curve simulated",
        "coverage, Eq. 34": "coverage, true curve Eq. 34",
        "coverage, simulation": "coverage, true curve simulated",
    },
    data=("capture_recovery",),
    equations="34",
    finding="""
        With the exponent q fixed, data close to capture give an interval of the capture
        velocity that nearly always misses the truth.
    """,
    method="""
        Each set has [[points]] speeds between the lowest one and [[highest_speed_in_v_c:g]] v_c
        and normal noise of standard deviation sigma_e in e, taken as known. On the left the
        constants of Eq. 34 are a fit to the simulation with q fixed. Bars are 95 % intervals of
        the share; marks of coverage are moved sideways, and thin lines guide the eye.
    """,
    contact=TWO_STAGES,
    tables={
        "fit_coverage": "Bias, error and coverage of the capture velocity in every cell of the design.",
    },
    height_mm=200.0,
    columns=2,
)
def draw_capture_recovery(sheet: Sheet) -> None:
    """Draw it (was study.figures.models.curves.draw)."""
    bias_Eq_34, bias_simulation, rms_Eq_34, rms_simulation, coverage_Eq_34, coverage_simulation = (
        sheet.panels(xscale="log", xlim=(0.98, 3.3), xlabel="Lowest speed over $v_c$")
    )
    bias_Eq_34.set(ylim=(-0.4, 0.5), ylabel="Mean error of $v_c$, over $v_c$")
    bias_simulation.set(ylim=(-0.4, 0.5), ylabel="Mean error of $v_c$, over $v_c$")
    rms_Eq_34.set(yscale="log", ylim=(0.001, 2.0), ylabel="Rms error of $v_c$, over $v_c$")
    rms_simulation.set(yscale="log", ylim=(0.001, 2.0), ylabel="Rms error of $v_c$, over $v_c$")
    coverage_Eq_34.set(ylim=(0.85, 1.01), ylabel="Coverage")
    coverage_simulation.set(ylim=(0.0, 1.05), ylabel="Coverage")
    for ax in (
        bias_Eq_34,
        bias_simulation,
        rms_Eq_34,
        rms_simulation,
        coverage_Eq_34,
        coverage_simulation,
    ):
        sheet.ticks(ax.xaxis, (1.05, 1.2, 1.5, 2.0, 3.0))
    for ax in (bias_Eq_34, bias_simulation):
        sheet.level(ax, 0.0)
    sheet.draw(bias_Eq_34, LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34, joined=True)
    sheet.draw(bias_simulation, LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34, joined=True)
    sheet.draw(rms_Eq_34, LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34, joined=True)
    sheet.draw(rms_simulation, LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34, joined=True)
    sheet.draw(coverage_Eq_34, LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34, joined=True, apart=1.035)
    sheet.draw(coverage_simulation, LOOKS_CAPTURE_RECOVERY_BIAS_EQ_34, joined=True, apart=1.035)
    sheet.keys()


@Figure(
    "averaged_coverage",
    "Interval of the capture velocity averaged over models",
    """
        How often the interval that `microimpact fit` recommends, averaged over its models,
        contains the true v_c (nominally [[confidence:.0%]]), against the scatter of sizes and
        speeds. Left: these are taken as exact. Middle: their scatter is given, or found in the
        data. Right: `microimpact calibrate` predicts other sizes, nominally 90 %. Bars: 95 %
        intervals.
    """,
    {
        "taken as exact": "taken as exact",
        "allowed for": "given or found",
        "at other sizes": "predicted at other sizes",
    },
    data=("averaged_coverage",),
    equations="25, 34",
    finding="""
        The recommended interval holds the true capture velocity about as often as it says, if
        the scatter of sizes and speeds is given.
    """,
    method="""
        Data sets of [[points]] speeds with noise of 0.01 in e, of Eq. 34, of the laws of
        contact, and of a curve that no model has: designs of config/fit_coverage.csv, of which
        a run computes some again. Scatter of sizes and speeds is added in squares; marks of the
        same scatter are moved apart. Predictions are intervals of contacts by four laws, from
        data of one size: config/capture_predictions.csv.
    """,
    contact=TWO_STAGES,
    tables={
        "averaged_intervals": "Coverage, width and warnings of the averaged interval in the designs that were computed.",
        "capture_predictions": "Coverage and width of capture velocities predicted at other sizes.",
    },
    height_mm=85.0,
    columns=3,
)
def draw_averaged_coverage(sheet: Sheet) -> None:
    """Draw it (was study.figures.models.curves.draw)."""
    taken_as_exact, allowed_for, at_other_sizes = sheet.panels(
        ylabel="Share of intervals with $v_c$"
    )
    taken_as_exact.set(
        xlim=(-1.8, 11.0), ylim=(0.3, 1.02), xlabel="Scatter of sizes and speeds (%)"
    )
    allowed_for.set(xlim=(-1.8, 11.0), ylim=(0.3, 1.02), xlabel="Scatter of sizes and speeds (%)")
    at_other_sizes.set(
        xscale="log", xlim=(0.28, 2.4), ylim=(0.7, 1.02), xlabel="Diameter over that measured"
    )
    sheet.ticks(at_other_sizes.xaxis, (0.33, 0.5, 1, 2))
    sheet.draw(taken_as_exact, LOOKS_AVERAGED_COVERAGE_TAKEN_AS_EXACT)
    sheet.draw(allowed_for, LOOKS_AVERAGED_COVERAGE_TAKEN_AS_EXACT)
    looks_at_other_sizes = {
        "ring force, n = 0.7": Series("ring force, $n$ = 0.7", 2),
        "viscous JKR": Series("JKR, viscous bulk", 3, mark="square", open=True),
        "nominal": Series("nominal", 6, line="dotted"),
    }
    sheet.draw(at_other_sizes, looks_at_other_sizes)
    sheet.keys()
