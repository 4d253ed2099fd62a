"""Made-up points of a user, laid over figures."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import same_color

from study.figures import style
from study.figures.declaration import Figure
from study.run.digitised import overlaid

TOP = "# source: made up\n# digitised_by: nobody\nseries,x,y,y_low,y_high\n"


@pytest.fixture(scope="module")
def coulomb(run_study):
    return run_study("fig17_coulomb_friction")


@pytest.fixture
def drawn(coulomb, figures, draw, tmp_path):
    """Return a function that draws Fig. 17 with points."""

    def of(*lines):
        path = tmp_path / "fig17.csv"
        path.write_text(TOP + "\n".join(lines))
        return draw("fig17", overlaid(coulomb, figures["fig17"], str(path)))

    return of


def legend_texts(figure):
    """Return all texts of the legends of a figure, those of its panels included."""
    legends = [*figure.legends, *(ax.get_legend() for ax in figure.axes)]
    present = [legend for legend in legends if legend is not None]
    return [text.get_text() for legend in present for text in legend.get_texts()]


def crosses(ax):
    return [line for line in ax.lines if line.get_marker() in style.POINT_MARKS["digitised"]]


def test_points_lie_over_the_panel_they_name(drawn):
    figure = drawn(
        "friction: 0.15,30,0.14,0.12,0.17", "friction: 0.15,60,0.10,,", "friction: other,45,0.24,,"
    )
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


def test_the_key_tells_the_distance_from_the_curve_of_the_name(drawn, coulomb):
    curves = coulomb["fig17"]
    own = curves[(curves["panel"] == "friction") & (curves["series"] == "0.15")].iloc[5::8]
    signs = np.resize([1.0, -1.0], len(own))
    lines = [
        f"friction: 0.15,{x},{y},,"
        for x, y in zip(own.iloc[:, 3], own.iloc[:, 4] + 0.031 * signs, strict=True)
    ]
    # one beyond the curve does not count, one of another name has no distance
    texts = legend_texts(drawn(*lines, "friction: 0.15,95,0.3,,", "friction: 0.1500,30,0.1,,"))
    new = ["digitised: 0.15, rms 0.031", "digitised: 0.1500"]
    assert [text for text in texts if text.startswith("digitised")] == new


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ("a,0,0.2,,", "points of fig14: 0 must be positive, as its axis is"),
        ("a,1,200,,", "points of fig14: 200 is far off the axis, 0.1 to 1"),
    ],
)
def test_a_point_that_an_axis_cannot_show_is_refused(tmp_path, point, message):
    words = Figure(print, "fig14", "Trends", "Curves.", {"p": ""}, data=("fig14",))
    columns = ["panel", "series", "evidence", "x_m", "y_1", "y_low", "y_high"]
    curve = pd.DataFrame([("p", "a", "computed", 1.0, 1.0, None, None)], columns=columns)
    path = tmp_path / "fig14.csv"
    path.write_text(f"{TOP}{point}\n")
    with style.context():
        sheet = style.Sheet(words, overlaid({"fig14": curve}, words, str(path)), {}, {})
        (ax,) = sheet.panels(xscale="log", xlim=(0.1, 10.0), ylim=(0.1, 1.0))
        with pytest.raises(ValueError, match=message):
            sheet.draw(ax, {})


def test_a_name_is_no_markup(drawn, tmp_path):
    names = ["$x", "$x^2$", r"a\$b$", "<script>", "_x", "a -- b", "100 %", "{"]
    figure = drawn(*(f'"spin: {name}",{i},0.1,,' for i, name in enumerate(names)))
    (key,) = figure.legends
    # Matplotlib takes a dollar for its own unless it is escaped
    texts = [text.get_text().replace(r"\$", "$") for text in key.get_texts()]
    assert texts[-len(names) :] == [f"digitised: {name}" for name in names]
    marks = [handle.get_marker() for handle in key.legend_handles[-len(names) :]]
    assert len(set(marks[:5])) == 5
    with style.context():
        style.save(figure, tmp_path / "one.svg")
    assert "<script" not in (tmp_path / "one.svg").read_text(encoding="utf-8")
