"""Made-up digitised points: laid over figures, fitted by Eq. (34), compared with the computed."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import same_color
from study.ledgers.claims.digitised import digitised_rows, read_digitised
from tests.shared import ROOT

from microimpact.model.empirical.equations import restitution
from study.figures import style
from study.run.digitised import as_rows, overlaid, read_points
from study.studies.analyses.digitised_comparison import is_named
from study.tables import parse_table, series_frame

TOP = "# source: made up\n# licence: CC0-1.0\n# digitised_by: nobody\nseries,x,y,y_low,y_high\n"
CASE = "steel-silicon, n = 0"
OTHER = "steel-silicon, n = 1"
# k, p, kappa, q, v_c of Eq. (34)
TRUTH = (40.0, 1.0, 0.1, 0.6, 0.2)


@pytest.fixture
def points(figures, tmp_path):
    """Return a function that makes digitised points of a figure from lines."""

    def made(name, *lines):
        path = tmp_path / f"{name}.csv"
        path.write_text(TOP + "\n".join(lines))
        return read_points(str(path), figures[name])

    return made


@pytest.fixture
def drawn_over(figures):
    """Return a function that draws a figure with digitised points, and saves nothing."""

    def drawn(name, tables, points):
        spec = figures[name]
        function = getattr(import_module(spec.module), spec.function)
        return function(overlaid({key: tables[key] for key in spec.data}, spec, points), spec)

    return drawn


@pytest.fixture(scope="module")
def coulomb(run_study):
    return run_study("coulomb_friction")


def legend_texts(figure):
    """Return all texts of the legends of a figure, those of its panels included."""
    legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes)]
    present = [legend for legend in legends if legend is not None]
    return [text.get_text() for legend in present for text in legend.get_texts()]


def crosses(ax):
    return [line for line in ax.lines if line.get_marker() in style.POINT_MARKS["digitised"]]


def test_points_lie_over_the_panel_they_name(coulomb, figures, points, draw):
    own = points(
        "fig17",
        "friction: 0.15,30,0.14,0.12,0.17",
        "friction: 0.15,60,0.10,,",
        "friction: other,45,0.24,,",
    )
    figure = draw("fig17", overlaid(coulomb, figures["fig17"], own))
    friction, spin = figure.axes
    assert not crosses(spin)
    named, other = crosses(friction)
    np.testing.assert_array_equal(named.get_xydata(), [[30, 0.14], [60, 0.10]])
    np.testing.assert_array_equal(other.get_xydata(), [[45, 0.24]])
    # a series named as a computed one has its colour
    assert same_color(named.get_color(), "C2")
    # one bar, for the one point that has one
    segments = [np.reshape(s, (-1, 2)) for bar in friction.collections for s in bar.get_segments()]
    heights = [segment[:, 1] for segment in segments if len(segment) and np.isfinite(segment).all()]
    np.testing.assert_allclose(heights, [[0.12, 0.17]])
    texts = legend_texts(figure)
    new = ["digitised: 0.15", "digitised: other"]
    assert [text for text in texts if text.startswith("digitised")] == new


def test_a_name_is_no_markup(coulomb, figures, points, draw, tmp_path):
    names = ["$x", "$x^2$", r"a\$b$", "<script>", "_x", "a -- b", "100 %", "{"]
    lines = [f'"spin: {name}",{i},0.1,,' for i, name in enumerate(names)]
    figure = draw("fig17", overlaid(coulomb, figures["fig17"], points("fig17", *lines)))
    (key,) = figure.legends
    # Matplotlib takes a dollar for its own unless it is escaped
    texts = [text.get_text().replace(r"\$", "$") for text in key.get_texts()]
    assert texts[-len(names) :] == [f"digitised: {name}" for name in names]
    marks = [handle.get_marker() for handle in key.legend_handles[-len(names) :]]
    assert len(set(marks[:5])) == 5
    style.save(figure, tmp_path / "one.svg")
    assert "<script" not in (tmp_path / "one.svg").read_text(encoding="utf-8")


def test_every_plot_of_the_article_takes_points(figures):
    plots = [spec for name, spec in figures.items() if name[3:].isdigit() and not spec.is_schematic]
    assert len(plots) == 19
    for spec in plots:
        # the points are compared with all tables of the figure
        assert all(name.partition("_")[0] == spec.name for name in spec.data)
    # and has a bound for those without bars
    bounds = read_digitised(ROOT / "config/claims.yaml").rms_difference
    assert set(bounds) == {spec.name for spec in plots}


def eq_34(case, speeds, noise=0.0):
    k, p, kappa, q, v_c = TRUTH
    e = restitution(np.asarray(speeds), k, p, kappa, q, v_c)
    e = np.where(e > 0, e + noise * (-1.0) ** np.arange(e.size), 0.0)
    return [f'"{case}",{v},{y!r},,' for v, y in zip(speeds, e.tolist(), strict=True)]


def rows_of(points):
    return parse_table(as_rows({points.figure: points}, [points.figure])["digitised"])


SPEEDS = [0.15, 0.19, 0.21, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 1.7, 2.0]


def test_points_of_a_case_are_fitted(run_study, calibration, settings, points, drawn_over):
    lines = [*eq_34(CASE, SPEEDS, noise=1e-4), f'"{OTHER}",1.0,0.6,,', "unknown,1,0.5,,"]
    cases = settings.branches["restitution_fits"]["cases"]
    few = {n: None for n, c in cases.items() if c["figure"] != "fig16" and c["fitted"]}
    inputs = calibration | {"digitised": rows_of(points("fig16", *lines))}
    tables = run_study("restitution_fits", inputs, cases=few)
    fits = tables["restitution_fits"]
    assert "unknown" not in set(fits["case"])
    digitised = fits[fits["evidence"] == "digitised"]
    # simulated fits come first, as others take them by case
    assert list(digitised.index) == list(fits.index[-4:])
    own = digitised[digitised["case"] == CASE].set_index("exponent")
    free = own.loc["free"]
    assert free["v_c_m_per_s"] == pytest.approx(TRUTH[-1], rel=0.01)
    assert free["v_c_low_m_per_s"] < TRUTH[-1] < free["v_c_high_m_per_s"]
    assert free["rms_residual"] < 1e-4
    assert own.loc["fixed", "q"] == 0.5
    assert set(own["note"]) == {""}
    # too few points: a row that says so, and no curve
    other = digitised[digitised["case"] == OTHER]
    assert list(other["exponent"]) == ["free", "fixed"]
    assert other["v_c_m_per_s"].isna().all()
    assert other["note"].str.startswith("not fitted: v must hold at least").all()
    curves = tables["fig16"][tables["fig16"]["series"].str.endswith("fit of points")]
    assert set(curves["series"]) == {f"{CASE}, fit of points"}
    assert curves["y_1"].iloc[0] == 0.0
    # and it is drawn
    figure = drawn_over("fig16", tables, points("fig16", *lines))
    assert {"$n$ = 0, fit of the points", f"digitised: {CASE}"} <= set(legend_texts(figure))
    assert len(crosses(figure.axes[0])) == 3
    # a logarithmic axis grows on its own scale
    slow = drawn_over("fig16", tables, points("fig16", "slow,0.02,0,,"))
    assert 0.01 < slow.axes[0].get_xlim()[0] < 0.02


def curve(series, x, y, evidence="computed"):
    return series_frame(
        panel="friction", series=series, evidence=evidence, x=x, y=y, x_unit="deg", y_unit="1"
    )


def test_differences_from_a_curve(run_study, points):
    own = points(
        "fig17",
        "friction: 5,10,0.2,0.05,0.3",  # 0.1 above the line, bar holds it
        "friction: 5,20,0.1,0.05,0.15",  # 0.1 below, bar does not
        "friction: 5,30,0.4,,",  # 0.1 above, no bar
        "friction: 5,95,0.1,,",  # beyond
    )
    table = pd.concat(
        [
            curve("line", [0, 90], [0.0, 0.9]),
            curve("falling", [90, 0], [0.9, 0.0], "virtual experiment"),
            curve("gap", [0, 15, 25, 90], [0.0, np.nan, np.nan, 0.9], "calibrated"),
            curve("upright", [5, 5], [0.0, 1.0]),
            curve("loop", [0, 20, 10], [0.0, 1.0, 2.0]),
            curve("printed", [0, 90], [0.0, 0.9], "printed"),
        ]
    )
    other = curve("measured", [0, 50], [0.2, 0.2], "virtual experiment")
    inputs = {"digitised": rows_of(own), "fig17": table, "fig17_points": other, "fig18": other}
    found = run_study("digitised_comparison", inputs)["digitised_residuals"]
    assert list(found["series"]) == ["line", "falling", "gap", "measured"]
    assert set(found["points"]) == {"5"}
    line = found.iloc[0]
    assert (line["figure"], line["panel"], line["unit"]) == ("fig17", "friction", "1")
    assert (line["n"], line["beyond"], line["bars"]) == (3, 1, 2)
    assert line["bias"] == pytest.approx(0.1 / 3)
    assert line["rms_difference"] == pytest.approx(0.1)
    assert line["within_bars"] == 0.5
    # bars of 0.25 and 0.1 are four standard uncertainties long
    assert line["normalised_rms"] == pytest.approx(np.sqrt((1.6**2 + 4.0**2) / 2))
    # the direction in which a curve is written is nothing to it
    numbers = ["n", "beyond", "bias", "rms_difference", "bars", "within_bars", "normalised_rms"]
    assert line[numbers].to_list() == pytest.approx(found.iloc[1][numbers].to_list())
    # nothing is bridged: no computed value, no difference
    assert (found.iloc[2]["n"], found.iloc[2]["beyond"]) == (0, 4)
    assert np.isnan(found.iloc[2]["bias"])


@pytest.fixture(scope="module")
def ledger_of(run_study, coulomb):
    """Return a function that judges points of Fig. 17."""

    def judged(points):
        tables = {"digitised": rows_of(points), "fig17": coulomb["fig17"]}
        residuals = run_study("digitised_comparison", tables)["digitised_residuals"]
        # as the workflow hands it on: names that are numbers come back as numbers
        again = parse_table(residuals.to_csv(index=False))
        return digitised_rows(read_digitised(ROOT / "config/claims.yaml"), again)

    return judged


@pytest.mark.parametrize("sd", [0.02, None], ids=["with bars", "without"])
@pytest.mark.parametrize(("shift", "verdict"), [(0.0, "reproduced"), (0.1, "not reproduced")])
def test_points_drawn_from_a_curve_agree_with_it_and_others_do_not(
    sd, shift, verdict, coulomb, points, ledger_of
):
    curves = coulomb["fig17"]
    own = curves[(curves["panel"] == "friction") & (curves["series"] == "0.15")].iloc[::8]
    noise = np.random.default_rng(np.random.PCG64(17)).normal(0.0, 0.02, len(own))
    lines = []
    for x, y in zip(own.iloc[:, 3], own.iloc[:, 4] + noise + shift, strict=True):
        bar = "," if sd is None else f"{y - 2 * sd:.6f},{y + 2 * sd:.6f}"
        lines.append(f"friction: 0.15,{x:.6f},{y:.6f},{bar}")
    ((row,), _) = ledger_of(points("fig17", *lines))
    assert row["id"] == "D17-friction-0.15"
    assert row["evidence"] == "digitised"
    assert row["criterion"].startswith("rms difference" if sd is None else "normalised rms")
    assert row["verdict"] == verdict


def test_a_series_is_named_alone_or_before_a_comma():
    assert is_named("0.15", "0.15")
    assert is_named("0.15, slow", "0.15")
    assert not is_named("0.151", "0.15")
    assert not is_named("slow, 0.15", "0.15")


def test_a_bar_without_length_agrees_with_its_own_point_alone(run_study, points):
    own = points("fig17", "friction: 5,10,0.1,0.1,0.1", "friction: 6,20,0.3,0.3,0.3")
    inputs = {"digitised": rows_of(own), "fig17": curve("line", [0, 90], [0.0, 0.9])}
    found = run_study("digitised_comparison", inputs)["digitised_residuals"]
    assert found["normalised_rms"].tolist() == pytest.approx([0.0, np.inf])
