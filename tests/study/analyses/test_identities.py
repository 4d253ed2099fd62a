"""Identities that the plain figures obey: a row per figure, identity and tolerance."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from matplotlib import rc_context

from study.figures.style import context, save

E, F = 0.70, 0.15  # Section 2.4.1
MASS = 1350 * np.pi / 6 * 4.9e-6**3  # Of the sphere of Fig. 20, kg
SPEED = 5.2  # Of its impact, m/s


@pytest.fixture(scope="module")
def force_history(run_study, calibration):
    """The function that runs the analysis of Fig. 20."""
    return partial(run_study, "fig20_force_history", calibration)


@pytest.fixture(scope="module")
def tables(run_study, force_history):
    return {
        **run_study("fig14_restitution_trends"),
        **run_study("fig17_coulomb_friction"),
        **force_history(),
    }


def curve(tables, figure, series, panel=None):
    """Both coordinates of a series."""
    table = tables[figure]
    rows = table[(table["series"] == series) & (table["panel"] == (panel or table["panel"]))]
    assert len(rows), (figure, series)
    return rows.iloc[:, 3].to_numpy(), rows.iloc[:, 4].to_numpy()


def at_and_below_capture(tables, series):
    (v_c, *_), _ = curve(tables, "fig14", "capture velocity")
    speed, y = curve(tables, "fig14", series)
    assert v_c in speed
    return y[speed <= v_c]


def coulomb(tables, friction, part):
    """Impulse ratio where a sphere slides throughout, or leaves rolling, and by hand."""
    angle, ratio = curve(tables, "fig17", f"{friction:g}", "friction")
    end = np.degrees(np.arctan(2 / (7 * friction * (1 + E))))  # cot(alpha) = 7 f (1 + e) / 2
    if part == "sliding":
        return ratio[angle < end], friction
    steep = angle > end
    return ratio[steep], 2 / (7 * (1 + E)) / np.tan(np.radians(angle[steep]))


def at_normal_incidence(tables, spin):
    return curve(tables, "fig17", f"{spin:g}", "spin")[1][-1], -2 * spin / (7 * (1 + E))


def greatest_ratio(tables):
    return tables["fig17"].query("panel == 'spin'")["y_1"].abs().max(), F


def forces(tables):
    """Total force of Fig. 20 and its four terms, uN."""
    names = ("total", "hertz", "hertz damping", "adhesion", "adhesion damping")
    return [curve(tables, "fig20", name)[1] for name in names]


def terms(tables):
    total, *parts = forces(tables)
    return sum(parts), total


def adhesion_damping_of_approach(tables):
    _, hertz, _, _, damping = forces(tables)
    return damping[: int(np.argmax(hertz)) - 1], 0.0


def change_of_momentum(tables):
    time, total = curve(tables, "fig20", "total")
    return np.trapezoid(total * 1e-6, time * 1e-9), MASS * SPEED * (1 + ratio(tables, "e"))


def ratio(tables, name):
    names = {"e": "coefficient_of_restitution", "adhesion": "peak_adhesion_over_peak_hertz"}
    names["dissipation"] = "peak_adhesion_dissipation_over_adhesion"
    return tables["force_ratios"].set_index("quantity")["value"][names[name]]


IDENTITIES = [
    ("14: adhesion takes all of a slow sphere",
     lambda t: (at_and_below_capture(t, "adhesion"), 1.0), 0.0),
    ("14: no slow sphere rebounds, as it would by the absolute value in the printed Eq. 33",
     lambda t: (at_and_below_capture(t, "overall restitution"), 0.0), 0.0),
    ("14: the body alone gives all back at no speed",
     lambda t: (curve(t, "fig14", "body restitution")[1][0], 1.0), 0.0),
    *((f"17: f = {f:g}, {part}", lambda t, f=f, part=part: coulomb(t, f, part), 1e-9)
      for f in (0.05, 0.1, 0.15, 0.2) for part in ("sliding", "rolling")),
    *((f"17: r omega = {spin:g} v at normal incidence, Eq. 12",
       lambda t, spin=spin: at_normal_incidence(t, spin), 1e-12)
      for spin in (-0.4, -0.2, 0.0, 0.2, 0.4)),
    ("17: the printed point",
     lambda t: (t["fig17"].query("evidence == 'printed'")[["x_deg", "y_1"]], [[90.0, 0.0]]), 0.0),
    ("17: no ratio exceeds the friction coefficient", greatest_ratio, 1e-6),
    ("20: the terms add up", terms, 1e-9),
    ("20: no adhesion dissipation during approach", adhesion_damping_of_approach, 0.0),
    ("20: the impulse is the change of momentum", change_of_momentum, 1e-3),
    ("20: adhesion over Hertz is about 1/3", lambda t: (ratio(t, "adhesion"), 1 / 3), 0.1),
    ("20: dissipation over adhesion is 1/5, which fixed the damping",
     lambda t: (ratio(t, "dissipation"), 1 / 5), 1e-3),
]  # fmt: skip


@pytest.mark.parametrize(
    ("identity", "tolerance"), [pytest.param(*row, id=name) for name, *row in IDENTITIES]
)
def test_the_figure_obeys_the_identity(tables, identity, tolerance):
    computed, exact = identity(tables)
    np.testing.assert_allclose(computed, exact, rtol=tolerance, atol=1e-9 if tolerance else 0.0)


def test_restitution_has_the_shape_that_the_article_draws(tables):
    _, body = curve(tables, "fig14", "body restitution")
    assert (np.diff(body) < 0).all()
    (v_c, *_), _ = curve(tables, "fig14", "capture velocity")
    speed, e = curve(tables, "fig14", "overall restitution")
    top = int(np.argmax(e))
    assert v_c < speed[top] < speed[-1]
    assert (np.diff(e[(speed >= v_c) & (speed <= speed[top])]) > 0).all()
    assert (np.diff(e[top:]) < 0).all()
    assert (e <= body).all()


def test_sliding_ends_near_50_deg_and_earlier_with_forward_spin(tables):
    ends = []
    for spin in ("-0.4", "-0.2", "0", "0.2", "0.4"):
        angle, ratios = curve(tables, "fig17", spin, "spin")
        ends.append(angle[ratios >= F * (1 - 1e-12)].max())
    assert ends[2] == pytest.approx(50, rel=0.1)
    assert (np.diff(ends) < 0).all()


def test_the_force_dips_near_both_ends_and_more_on_rebound(tables):
    total, hertz, _, adhesion, damping = forces(tables)
    assert (hertz >= 0).all()
    assert (adhesion <= 0).all()
    signs = np.sign(total[np.abs(total) > 1e-9])
    assert (np.diff(signs) != 0).sum() == 2, "one compressive stretch between two dips"
    assert signs[0] == signs[-1] == -1
    turn = int(np.argmax(hertz))
    assert total[turn:].min() < total[:turn].min() < 0
    assert (damping[turn + 1 :] <= 0).all()


def test_a_faster_sphere_is_compressed_more_and_has_no_printed_ratios(tables, force_history):
    # adhesion over Hertz goes as one over the compression
    faster = force_history(speed_m_per_s=10.4)
    assert ratio(faster, "adhesion") < 0.7 * ratio(tables, "adhesion")
    assert tables["force_ratios"]["printed"].notna().sum() == 2
    assert faster["force_ratios"]["printed"].isna().all()


def test_a_captured_sphere_is_drawn_too(force_history, draw):
    captured = force_history(speed_m_per_s=0.5)
    assert ratio(captured, "e") == 0.0
    draw("fig20", captured)


def test_settings_of_matplotlib_of_a_user_change_no_figure(draw, tables, tmp_path):
    def drawn():
        with context():
            save(draw("fig14", tables), tmp_path / "one.svg")
        return (tmp_path / "one.svg").read_bytes()

    plain = drawn()
    with rc_context({"lines.linewidth": 9.0, "axes.grid": True, "font.size": 20.0}):
        assert drawn() == plain
