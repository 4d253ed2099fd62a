"""Figure doppler_pairs: pairs in the records of a virtual analyser, and their correction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import (
    NOMINAL_SPEED,
    NORMAL_SPEED,
    TWO_STAGES,
    Series,
    figure,
    stated,
)

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def printed_correction_is_biased(y: Curves) -> Stated:
    """The printed correction errs ten times as much as the exact one."""
    most = {
        how: max(y(f"{how}, e = {e}").abs().max() for e in ("0.4", "0.7", "0.9"))
        for how in ("printed", "exact")
    }
    return stated(
        most["printed"] > 10.0 * most["exact"], printed=most["printed"], exact=most["exact"]
    )


@figure(
    "doppler_pairs",
    "Pairs in the records of a phase Doppler particle analyser, and their correction to the surface",
    """
        A virtual phase Doppler analyser (contact [[case]]). (a) A stretch of its records, with
        the accepted pairs. (b) Share of accepted pairs that are of one sphere. (c) Share of
        true pairs found. (d) Share of rebounds found. (e) Bias of the restitution by the
        printed correction for the probe's height, and by the exact one.
    """,
    {
        "stream": "stretch of a stream",
        "precision": "accepted pairs that are true",
        "recall": "recorded pairs that are found",
        "seen": "rebounds that are found",
        "correction": "bias of the correction",
    },
    data=("doppler_stream", "pairing_curves", "correction_curves"),
    equations="2.1 incident, 2.1 rebound, 25",
    finding="""
        The printed correction of the probe's height biases the restitution of slow rebounds
        by up to {printed:.2f}, the exact one by less than {exact:.3f}.
    """,
    holds=printed_correction_is_biased,
    method="""
        Spheres fall through a small probe volume at a height h above the surface, rebound, and
        rise through it again; in (a) h = [[instrument.probe_height_mm:g]] mm, and spheres that
        fall back pass once more, more slowly. The rebounds missing in (d) rose too slowly to
        reach the probe volume, missed it or dropped out. The printed correction adds a constant
        to both speeds; curves in (e), in closed form, begin where the rebound reaches the probe
        volume. Bars are 95 % intervals; marks of one speed are drawn side by side.
    """,
    contact=TWO_STAGES,
    tables={
        "pairing_quality": "Share of pairs that are true, and of rebounds found, by height of the probe and speed.",
        "surface_correction": "Bias of restitution corrected as printed, exactly, and by a closed form.",
    },
    height_mm=115.0,
    columns=3,
)
def draw_doppler_pairs(sheet: Sheet) -> None:
    """A stretch of the stream with its pairs as lines, and curves against speed."""
    stream, precision, recall, seen, correction = sheet.panels()
    stream.set(xlim=(0.0, 75.0), xlabel="Time (ms)")
    stream.set(ylim=(-0.9, 1.2), ylabel="Vertical velocity (m/s)")
    for number, (_, pair) in enumerate(sheet.take(stream, "pair").groupby("series")):
        label = "_pair" if number else "accepted pair"
        time, velocity = pair.iloc[:, 3], pair.iloc[:, 4]
        stream.plot(time, velocity, label=label, color="0.6", linewidth=0.8, zorder=1)
    records = {
        "falling": Series("falling record", 0),
        "rising": Series("rising record", 1, mark="triangle"),
    }
    sheet.draw(stream, records)
    sheet.legend(stream, "upper left")
    heights = {
        "h = 0.5 mm": Series("$h$ = 0.5 mm", 0, open=True),
        "h = 1 mm": Series("$h$ = 1 mm", 2, mark="square"),
        "h = 2 mm": Series("$h$ = 2 mm", 4, mark="triangle"),
        "h = 5 mm": Series("$h$ = 5 mm", 3),
    }
    for ax, share in ((precision, "Share true"), (recall, "Share found"), (seen, "Share found")):
        ax.set(xscale="log", xlim=(0.25, 2.0), xlabel=NOMINAL_SPEED)
        ax.set(ylim=(0.0, 1.05), ylabel=share)
        sheet.ticks(ax.xaxis, (0.3, 0.5, 0.75, 1.66))
        sheet.draw(ax, heights, apart=1.06)
    correction.set(xscale="log", xlim=(0.15, 6.0), xlabel=NORMAL_SPEED)
    correction.set(ylim=(-0.14, 0.08), ylabel="Bias of $e$")
    sheet.ticks(correction.xaxis, (0.2, 0.5, 1.0, 2.0, 5.0))
    corrections = {
        "closed form, e = 0.4": Series("printed, $e$ = 0.4", 0),
        "closed form, e = 0.7": Series("printed, $e$ = 0.7", 1, line="dashed"),
        "closed form, e = 0.9": Series("printed, $e$ = 0.9", 2, line="dashdot"),
        "printed, e = 0.4": Series("printed, $e$ = 0.4", 0),
        "printed, e = 0.7": Series("printed, $e$ = 0.7", 1, mark="square"),
        "printed, e = 0.9": Series("printed, $e$ = 0.9", 2, mark="triangle"),
        "exact, e = 0.4": Series("exact, any $e$", 6, open=True),
        "exact, e = 0.7": Series("_exact", 6, open=True),
        "exact, e = 0.9": Series("_exact", 6, open=True),
    }
    sheet.draw(correction, corrections, fixed=True)
    sheet.legend(correction, "lower right")
    sheet.keys()
