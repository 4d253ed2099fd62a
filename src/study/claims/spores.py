"""Numbers of the claims of Sections 2.4.3 and 2.4.4: spores on silicon, and on Formica."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from microimpact.core.arrays import FloatArray
from microimpact.core.computable import NotComputable
from microimpact.statistics.intervals import ERROR_BAR
from study.claims.claim import RIDGE, Claim, Number, untestable
from study.claims.context import (
    AngleRange,
    Context,
    Estimate,
    Numbers,
    SteepToShallow,
)
from study.declared.parameters import AngleDegrees, Name
from study.samples import Dropped


@Claim(
    "C17",
    (
        "Between 48 and 38° the normal speed of the spores is 1.10 to 0.91 m/s, both from one "
        "total speed."
    ),
    says=(
        "The total speeds that belong to the two printed normal speeds differ by "
        "{difference_of_total_speeds}, about {total_speed}."
    ),
    where="2.4.3, Fig. 11",
    quote="the normal incoming velocity component ranged from about 1.10 m/s to 0.91 m/s",
    article="1.10 at 48 deg, 0.91 at 38 deg",
    unit="m/s",
    numbers={
        "difference_of_total_speeds": Number(unit="m/s", within=(0.0, 0.0149)),
        "total_speed": Number(unit="m/s"),
    },
    reason="Half a unit of the last digit of both normal speeds, each over the sine of its angle.",
    figures="fig11",
)
def c17(context: Context, *, angles_deg: AngleRange) -> Numbers:
    """Total speeds that the two printed normal speeds of the spores mean."""
    angles = np.radians(angles_deg)
    keys = ("normal_speed_lycopodium_48deg", "normal_speed_lycopodium_38deg")
    speeds = np.array([context.printed(key) for key in keys]) / np.sin(angles)
    return {"difference_of_total_speeds": speeds[0] - speeds[1], "total_speed": speeds.mean()}


@Claim(
    "C81",
    (
        "From 90 to 55° restitution of spores and of steel on silicon is the same, so the "
        "materials matter little."
    ),
    says=(
        "Spores and steel differ by {largest_difference_over_half_width} half-widths of the error "
        "bar; equal is {largest_difference_over_half_width:bound}."
    ),
    where="2.4.3, Fig. 11",
    quote="appear to have little effect on the impact response in this region",
    kind="virtual experiment",
    article="equal",
    numbers={
        "largest_difference_over_half_width": Number(
            "largest difference at [[angles_deg:g]]° / half-width", at_most=1.0
        ),
    },
    reason=(
        "Two very different contacts, each calibrated only near normal incidence, must agree "
        "within the error bar at [[angles_deg:g]]°. Calibrated, since one printed restitution "
        "determined both."
    ),
    if_met="calibrated",
    cases=RIDGE,
    figures="fig11",
    by_case=True,
)
def c81(context: Context, *, angles_deg: tuple[AngleDegrees, ...]) -> Numbers:
    """Largest difference of restitution, steel less spores, each calibrated at 85 deg alone."""
    name = "restitution_difference_over_half_width"
    difference = context.column("spore_comparison", name, angles_deg)
    return {"largest_difference_over_half_width": difference.abs().max()}


untestable(
    Claim(
        "C82",
        (
            "With the capture velocity of 1.30 m/s quoted for spores, spores would rebound from 48 to "
            "38°, and their restitution would go on falling at smaller angles."
        ),
        where="2.4.3, Fig. 11",
        quote="the capture velocity was 1.30 m/s when impacting American elm leaves",
        kind="contradiction",
        article="1.30",
        unit="m/s",
        figures="fig11",
        reason=("The 1.30 m/s are of American elm leaves; none is printed for spores on silicon."),
    )
)


@Claim(
    "C83",
    (
        "Slopes of the spore, repeated contacts or off-centre collisions raise the measured "
        "restitution below 38°."
    ),
    says=(
        "The most effective mechanism raises restitution by {greatest_rise_over_half_width} "
        "half-widths of its error bar from [[angles_deg.0:g]] to [[angles_deg.1:g]]°; a rise is "
        "{greatest_rise_over_half_width:bound}."
    ),
    where="2.4.3, Fig. 11",
    quote=(
        "multi-collisions and/or non-central collisions due to the irregular Lycopodium spore "
        "surface"
    ),
    kind="virtual experiment",
    article="sign",
    numbers={
        "greatest_rise_over_half_width": Number(
            "greatest rise from [[angles_deg.0:g]] to [[angles_deg.1:g]]° / half-width",
            at_least=1.0,
        ),
        "rise_by_slopes_over_half_width": Number(
            "rise from [[angles_deg.0:g]] to [[angles_deg.1:g]]° due to slopes / half-width"
        ),
        "rise_by_second_contacts_over_half_width": Number(
            "rise from [[angles_deg.0:g]] to [[angles_deg.1:g]]° due to second contacts / half-width"
        ),
        "rise_by_collisions_off_centre_over_half_width": Number(
            "rise from [[angles_deg.0:g]] to [[angles_deg.1:g]]° due to off-centre impacts / half-width"
        ),
    },
    reason=(
        "A minimum at 38° needs a rise below that angle beyond the error bar, by one of the "
        "mechanisms; each acts alone."
    ),
    figures="fig11",
    equations="35",
)
def c83(context: Context, *, angles_deg: SteepToShallow, off_centre: Name) -> Numbers:
    """Rise of restitution from 38 to 15 deg by each cause alone, and the greatest."""
    causes = {
        "slopes": "slopes, first contacts",
        "second_contacts": "second contacts, added to slopes",
        "collisions_off_centre": off_centre,
    }
    rises = {
        words: trend(context, name, "restitution_rise", angles_deg)
        for words, name in causes.items()
    }
    return {"greatest_rise_over_half_width": max(rises.values())} | {
        f"rise_by_{words}_over_half_width": rise.value for words, rise in rises.items()
    }


def trend(context: Context, mechanism: str, quantity: str, angles: tuple[float, float]) -> Estimate:
    """Return a trend that a supposed cause gives, over its half-width.

    The sample is large: its error is about that of means of as many events as rebound at 15 deg.

    Raises NotComputable if the table has no trend between these angles, or so few rebound at one of
    them that there is none to see.
    """
    row = context.table("spore_trends", mechanism=mechanism).iloc[0]
    column = "{}_{:g}_to_{:g}".format(quantity, *angles)
    if f"{column}_over_half_width" not in row:
        raise ValueError(f"spore_trends: no column {column}_over_half_width")
    value, rebounds = row[f"{column}_over_half_width"], row["rebounds_at_15_deg"]
    if not np.isfinite(value):
        raise NotComputable(f"spore_trends: too few rebounds for {column}, {mechanism}")
    return Estimate(value, np.sqrt(context.params.sampling.events / rebounds) / ERROR_BAR)


@Claim(
    "C84",
    (
        "The impulse ratio of the spores rises from 90 to 20° without a constant region and falls "
        "below 15°."
    ),
    says=(
        "The impulse ratio of the spores rises by {rise_over_half_width} half-widths of its error "
        "bar from [[rise_deg.0:g]] to [[rise_deg.1:g]]° and by {later_rise_over_half_width} from "
        "[[later_rise_deg.0:g]]° on; from [[fall_deg.0:g]] to [[fall_deg.1:g]]° it falls by "
        "{fall_over_half_width}, where {fall_over_half_width:bound} is a fall."
    ),
    where="2.4.3, Fig. 11",
    quote="There is no clear constant region.",
    kind="virtual experiment",
    article="rise, then fall",
    numbers={
        "rise_over_half_width": Number(
            "rise from [[rise_deg.0:g]] to [[rise_deg.1:g]]° / half-width", at_least=1.0
        ),
        "later_rise_over_half_width": Number(
            "rise from [[later_rise_deg.0:g]] to [[later_rise_deg.1:g]]° / half-width", at_least=1.0
        ),
        "fall_over_half_width": Number(
            "fall from [[fall_deg.0:g]] to [[fall_deg.1:g]]° / half-width", at_least=1.0
        ),
    },
    reason=(
        "Each beyond the error bar; the second is tested where a smooth sphere has its constant "
        "region. Slopes, second contacts and the loss of unseen rebounds are included."
    ),
    assumed="slopes and friction of the spores",
    figures="fig11",
    equations="36",
)
def c84(
    context: Context,
    *,
    rise_deg: SteepToShallow,
    later_rise_deg: SteepToShallow,
    fall_deg: SteepToShallow,
) -> Numbers:
    """Rises and fall of the impulse ratio as the camera sees them."""
    trends = {"rise": rise_deg, "later_rise": later_rise_deg, "fall": fall_deg}
    return {
        f"{name}_over_half_width": trend(
            context,
            "slopes, seen by the camera",
            f"impulse_ratio_{name.removeprefix('later_')}",
            angles,
        )
        for name, angles in trends.items()
    }


@Claim(
    "C85",
    "The energy losses of spores and steel hardly differ where their restitutions do.",
    says=(
        "Losses tell the particles apart {resolution_by_losses_over_that_by_restitutions} times "
        "as well as restitutions do, from equal error bars to those of the virtual laboratory; "
        "claimed is {resolution_by_losses_over_that_by_restitutions:bound}."
    ),
    where="2.4.3, Fig. 11",
    quote="shows no substantial difference between these two cases",
    article="no clear difference",
    numbers={
        "resolution_by_losses_over_that_by_restitutions": Number(
            "resolution by losses / by restitutions", at_most=0.999
        ),
    },
    reason=(
        "With the printed restitutions of both, the difference of the losses over its error bar "
        "must be less than that of the restitutions. Error bars of the losses are not printed, so "
        "those of the virtual laboratory and equal ones of both are cases."
    ),
    cases=("error bars of the virtual laboratory", "equal error bars"),
    figures="fig11",
    equations="3 14",
)
def c85(context: Context) -> Numbers:
    """Ratio of the difference of the losses at 40 deg to the difference of printed restitutions."""
    row = context.table("loss_resolution").iloc[0]
    endings = {"error bars of the virtual laboratory": "_over_half_width", "equal error bars": ""}
    return {
        name: {
            "resolution_by_losses_over_that_by_restitutions": abs(
                row[f"difference_of_losses{ending}"] / row[f"difference_of_restitutions{ending}"]
            )
        }
        for name, ending in endings.items()
    }


@Claim(
    "C86",
    (
        "On Formica the restitution of steel is significantly higher than that of spores, both "
        "rise as the angle falls, and that of steel exceeds one below 20°."
    ),
    says=(
        "Restitution of steel exceeds that of spores by "
        "{least_difference_steel_less_spore_over_half_width} half-widths of the error bar, where "
        "{least_difference_steel_less_spore_over_half_width:bound} is significant; the smaller of "
        "the rises is {lesser_rise_over_half_width} half-widths, and steel has "
        "{measured_restitution_of_steel} at [[steel_deg.0:g]]° and "
        "{measured_restitution_of_steel_below} at [[steel_deg.1:g]]°."
    ),
    where="2.4.4, Fig. 12",
    quote="are significantly higher than those for the spore case",
    kind="virtual experiment",
    article="1 at 20 deg",
    numbers={
        "least_difference_steel_less_spore_over_half_width": Number(
            "smallest difference steel minus spore / half-width", at_least=1.0
        ),
        "lesser_rise_over_half_width": Number(
            "smaller rise from [[trend_deg.0:g]] to [[trend_deg.1:g]]° / half-width", at_least=1.0
        ),
        "measured_restitution_of_steel": Number(
            "measured restitution of steel at [[steel_deg.0:g]]°", within=(1.0, 0.1)
        ),
        "measured_restitution_of_steel_below": Number(
            "measured restitution of steel at [[steel_deg.1:g]]°", at_least=1.001
        ),
    },
    reason=(
        "Differences beyond the error bar from the steepest angle to [[from_deg:g]]°, about one "
        "at 20°, and above one below. Calibrated, since the value at 20° determined the spread of "
        "slopes, and the order of both particles the contact of the spore."
    ),
    if_met="calibrated",
    cases=("slopes of spores as supposed", "spores without slopes"),
    figures="fig12",
    equations="35",
)
def c86(
    context: Context,
    *,
    steel: Dropped,
    spore: Dropped,
    trend_deg: AngleRange,
    from_deg: AngleDegrees,
    steel_deg: AngleRange,
) -> Numbers:
    """Restitution of steel less the spores', rises of both, and restitution of steel.

    With the slopes that are supposed of the spores, and without any.
    """
    alternatives = {
        "slopes of spores as supposed": spore,
        "spores without slopes": replace(spore, particle_slope=0.0),
    }
    measured, below = formica(context, "steel_restitution", steel_deg)
    return {
        name: {
            "least_difference_steel_less_spore_over_half_width": min(
                compared(context, "restitution", steel, each, from_deg)
            ),
            "lesser_rise_over_half_width": lesser_rise(
                context, "restitution", (steel, each), trend_deg
            ),
            "measured_restitution_of_steel": measured,
            "measured_restitution_of_steel_below": below,
        }
        for name, each in alternatives.items()
    }


def rise(context: Context, quantity: str, dropped: Dropped, trend: tuple[float, float]) -> Estimate:
    """Return the rise of a mean on Formica from steep to shallow, over its half-width."""
    steep, shallow = trend
    return context.over_half_width(quantity, (dropped, shallow), (dropped, steep))


def lesser_rise(
    context: Context, quantity: str, samples: tuple[Dropped, Dropped], trend: tuple[float, float]
) -> Estimate:
    """Return the lesser rise of a mean, of steel and of one sort of spores."""
    return min(rise(context.series, quantity, sample, trend) for sample in samples)


def formica(context: Context, column: str, angles: ArrayLike | None = None) -> pd.Series:
    """Return a column of steel and spores on Formica, by angle."""
    return context.column("formica_mechanism", column, angles)


def compared(
    context: Context, quantity: str, steel: Dropped, spore: Dropped, least: float
) -> list[Estimate]:
    """Return differences of a mean from an angle up, steel less spores, over half-widths."""
    angles = formica(context, f"{quantity}_difference").index
    return [
        context.series.over_half_width(quantity, (steel, angle), (spore, angle))
        for angle in angles[angles >= least]
    ]


@Claim(
    "C87",
    (
        "On Formica steel and spores have nearly equal impulse ratios, and neither ratio becomes "
        "constant."
    ),
    says=(
        "The impulse ratios differ by up to "
        "{largest_difference_of_impulse_ratios_over_half_width} half-widths of the error bar, "
        "where {largest_difference_of_impulse_ratios_over_half_width:bound} is nearly equal, and "
        "rise by {lesser_rise_over_half_width}."
    ),
    where="2.4.4, Fig. 12",
    quote="The impulse ratio for these two cases is roughly the same.",
    kind="virtual experiment",
    article="equal",
    numbers={
        "largest_difference_of_impulse_ratios_over_half_width": Number(
            "largest difference of impulse ratios / half-width", at_most=1.0
        ),
        "lesser_rise_over_half_width": Number(
            "smaller rise from [[trend_deg.0:g]] to [[trend_deg.1:g]]° / half-width", at_least=1.0
        ),
    },
    reason=(
        "Roughly the same means within the error bar at the declared angles, and never constant a "
        "rise beyond it. Friction of spores is not published: taken as that of steel."
    ),
    assumed="friction of the spores",
    figures="fig12",
    equations="36",
)
def c87(
    context: Context,
    *,
    steel: Dropped,
    spore: Dropped,
    trend_deg: AngleRange,
    from_deg: AngleDegrees,
) -> Numbers:
    """Largest difference of the impulse ratios over its half-width, and the lesser rise."""
    both = steel, spore
    return {
        "largest_difference_of_impulse_ratios_over_half_width": max(
            map(abs, compared(context, "impulse_ratio", *both, from_deg))
        ),
        "lesser_rise_over_half_width": lesser_rise(context, "impulse_ratio", both, trend_deg),
    }


@Claim(
    "C88",
    (
        "Below 45° the energy losses on Formica approach each other although the restitutions "
        "still differ."
    ),
    says=(
        "From [[angles_deg.1:g]] to [[angles_deg.0:g]]° the losses approach each other by "
        "{shrinking_of_difference_of_losses_over_half_width} half-widths of the error bar, while "
        "restitutions still differ by {difference_of_restitutions_over_half_width}; each must be "
        "{difference_of_restitutions_over_half_width:bound}."
    ),
    where="2.4.4, Fig. 12",
    quote="the difference of T_L between these two cases becomes smaller",
    kind="virtual experiment",
    article="inequality",
    numbers={
        "shrinking_of_difference_of_losses_over_half_width": Number(
            "decrease of the difference of losses from [[angles_deg.1:g]] to [[angles_deg.0:g]]° / half-width",
            at_least=1.0,
        ),
        "ratio_of_differences_of_losses": Number(
            "ratio of the differences of losses at [[angles_deg.0:g]]° and [[angles_deg.1:g]]°"
        ),
        "difference_of_restitutions_over_half_width": Number(
            "difference of restitutions at [[angles_deg.0:g]]° / half-width", at_least=1.0
        ),
    },
    reason=(
        "The losses approach each other if error bars show that their difference shrinks; "
        "restitutions still differ if their error bars show it."
    ),
    figures="fig12",
    equations="3 14",
)
def c88(context: Context, *, angles_deg: AngleRange) -> Numbers:
    """How far the difference of the losses shrinks from 80 to 30 deg, over its half-width.

    Beside it the ratio of both, and the difference of the restitutions at 30 deg.
    """
    angles = list(angles_deg)
    losses, widths, errors = differences(context, "energy_loss", angles)
    apart, width, error = (values[0] for values in differences(context, "restitution", angles[:1]))
    change = Estimate(abs(losses[1]) - abs(losses[0]), np.hypot(*errors))
    return {
        "shrinking_of_difference_of_losses_over_half_width": change / np.hypot(*widths),
        "ratio_of_differences_of_losses": losses[0] / losses[1],
        "difference_of_restitutions_over_half_width": Estimate(apart, error) / width,
    }


def differences(context: Context, quantity: str, angles: list[float]) -> list[FloatArray]:
    """Return differences of means on Formica by angle, their half-widths, and their errors."""

    def column(name: str) -> FloatArray:
        return formica(context, name, angles).to_numpy(float)

    difference = column(f"{quantity}_difference")
    width = np.abs(difference / column(f"{quantity}_difference_over_half_width"))
    errors = (
        column(f"{who}_{quantity}_sd") / np.sqrt(column(f"{who}_rebounds"))
        for who in ("steel", "spore")
    )
    return [difference, width, np.hypot(*errors)]


@Claim(
    "C89",
    (
        "Since only rebounds are analysed, a rise of restitution at shallow angles does not "
        "exclude capture."
    ),
    says=(
        "At [[trend_deg.1:g]]° {captured_share:%} of the particles are captured, although the "
        "mean of the rebounds has risen by {rise_over_half_width} half-widths of its error bar."
    ),
    where="2.4.4",
    quote="does not necessarily mean that there was no capture in the experiments",
    kind="virtual experiment",
    article="no exclusion",
    numbers={
        "captured_share": Number("captured share at [[trend_deg.1:g]]°", at_least=0.025),
        "rise_over_half_width": Number(
            "rise from [[trend_deg.0:g]] to [[trend_deg.1:g]]° / half-width", at_least=1.0
        ),
        "bias_of_conditional_mean": Number("bias of the conditional mean at [[trend_deg.1:g]]°"),
    },
    reason=(
        "At least one capture in the printed number of events of an experiment, together with a "
        "rise beyond the error bar, for spores on Formica."
    ),
    figures="fig12",
)
def c89(context: Context, *, spore: Dropped, trend_deg: AngleRange) -> Numbers:
    """Share of spores captured while restitution rises."""
    shallow = trend_deg[1]
    captured, bias = (
        formica(context, f"spore_{name}", shallow)[shallow]
        for name in ("captured_share", "bias_of_conditional_mean")
    )
    return {
        "captured_share": captured,
        "rise_over_half_width": rise(context.series, "restitution", spore, trend_deg),
        "bias_of_conditional_mean": bias,
    }


untestable(
    Claim(
        "C90",
        "A statistical analysis of the oblique impacts of spores follows later in the article.",
        where="2.4.4",
        quote="is presented later and examines some of those effects",
        kind="virtual experiment",
        article="announced",
        reason=(
            "Section 4.2 treats only steel spheres; nothing is printed for spores that could be "
            "compared with a computation."
        ),
    )
)
