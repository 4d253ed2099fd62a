"""Figs. 1, 2, 3, 13, 19 and 22: the schematics say what they show, and what is to scale is."""

from __future__ import annotations

import itertools

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgba
from matplotlib.patches import FancyArrowPatch

from microimpact.model.dynamics.trajectory import trajectory
from study.contacts import calibrated_contact


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("fig01_03_13_19_22_schematics")


@pytest.fixture(scope="module")
def parameters(settings):
    return settings.branches["fig01_03_13_19_22_schematics"]


@pytest.fixture(scope="module")
def state(settings, parameters, calibration):
    """Greatest compression (m), Hertz force and ring's pull there (N), and where (m)."""
    drawn = parameters["contact"]
    inputs = {**calibration, "materials": pd.DataFrame(settings.tables.materials.rows)}
    contact = calibrated_contact(inputs, drawn["case"], diameter=drawn["diameter_um"] * 1e-6)
    path = trajectory(contact, drawn["speed_m_per_s"], drawn["angle_deg"], points=2001)
    turn = int(np.argmax(path.compression))
    return path.compression[turn], path.hertz_force[turn], path.adhesion_force[turn]


def points(table, panel, series):
    rows = table[(table["panel"] == panel) & (table["series"] == series)]
    assert len(rows), (panel, series)
    return rows.iloc[:, 3:5].to_numpy(float)


def vector(table, panel, series):
    tail, tip = points(table, panel, series)
    return tip - tail


def computed_arrows(figure):
    """Return the vectors of the arrows of the first panel that are marked as computed."""
    patches = [p for p in figure.axes[0].patches if isinstance(p, FancyArrowPatch)]
    blue = to_rgba("#0072B2")
    ends = [np.array(p._posA_posB) for p in patches if p.get_edgecolor() == blue]
    return [tip - tail for tail, tip in ends]


def test_tracks_of_fig01_follow_the_rigid_body_model(tables, parameters):
    """At 60 deg the sphere ends rolling: V_t = 5/7 v_t, whatever f; V_n = -e v_n."""
    rebound, alpha = parameters["rebound"], np.radians(60.0)
    fall, bounce = (
        points(tables["fig01"], "side", f"{leg} track").reshape(-1, 2, 2)
        for leg in ("incident", "rebound")
    )
    normal = vector(tables["fig01"], "side", "normal")
    normal /= np.hypot(*normal)
    target = vector(tables["fig01"], "side", "target")
    target /= np.hypot(*target)
    np.testing.assert_allclose(fall[:, :, 0], fall[0, 0, 0])
    assert normal @ target == pytest.approx(0.0, abs=1e-12)
    assert -target[1] == pytest.approx(np.cos(alpha)), "the fall meets the target at alpha"
    pitch = np.diff(bounce[:, 0], axis=0)[0] / np.hypot(*np.diff(fall[:, 0], axis=0)[0])
    assert pitch @ normal == pytest.approx(rebound["restitution"] * np.sin(alpha))
    assert pitch @ target == pytest.approx(5.0 / 7.0 * np.cos(alpha))


def test_drawn_rebound_has_the_stated_restitution_and_friction(draw, tables, parameters):
    rebound = parameters["rebound"]
    drawn = computed_arrows(draw("fig03", tables))
    scale = rebound["speed_m_per_s"] / max(np.hypot(*arrow) for arrow in drawn)

    def shown(series):
        wanted = vector(tables["fig03"], "impact", series)
        return any(np.allclose(scale * arrow, wanted, atol=1e-12) for arrow in drawn)

    v, V = (vector(tables["fig03"], "impact", f"{leg} velocity") for leg in ("incident", "rebound"))
    assert shown("incident velocity")
    assert shown("rebound velocity")
    for leg, whole in (("incident", v), ("rebound", V)):
        parts = [vector(tables["fig03"], "impact", f"{leg} {p}") for p in ("tangential", "normal")]
        np.testing.assert_allclose(sum(parts), whole)
    assert np.hypot(*v) == pytest.approx(rebound["speed_m_per_s"])
    assert np.degrees(np.arctan2(-v[1], v[0])) == pytest.approx(rebound["angle_deg"])
    assert -V[1] / v[1] == pytest.approx(rebound["restitution"])
    # v_t > 0 and sliding: the signed ratio is -f
    assert (V[0] - v[0]) / (V[1] - v[1]) == pytest.approx(-rebound["friction"])


def test_friction_raises_the_spin_in_the_sense_of_rolling(tables):
    """Eq. (8) as corrected: r (Omega - omega) = -(5/2) (V_t - v_t)."""
    spins = [vector(tables["fig03"], "impact", f"{leg} spin")[0] for leg in ("incident", "rebound")]
    along = [
        vector(tables["fig03"], "impact", f"{leg} tangential")[0] for leg in ("incident", "rebound")
    ]
    assert spins[1] - spins[0] == pytest.approx(-2.5 * (along[1] - along[0]))
    assert spins[1] > spins[0] > 0
    assert along[1] - spins[1] > 0, "it still slides"


def test_momentum_and_impulses_of_fig13_add_up(tables, parameters):
    table = tables["fig13"]
    for part in ("normal", "tangential"):
        before, impulse, after = (
            vector(table, panel, part) for panel in ("before", "impulse", "after")
        )
        np.testing.assert_allclose(before + impulse, after)
    normal = vector(table, "impulse", "normal")
    along = vector(table, "impulse", "tangential")
    assert along[0] / normal[1] == pytest.approx(-parameters["rebound"]["friction"])


def test_drawn_pressure_carries_the_hertz_force(tables, state):
    rho, pressure = points(tables["fig19_pressure"], "stresses", "pressure").T
    half = rho >= 0
    force = np.trapezoid(2.0 * np.pi * rho[half] * pressure[half], rho[half])  # um2 GPa = mN
    assert force * 1e-3 == pytest.approx(state[1], rel=2e-3)


def test_contact_of_fig19_follows_hertz(tables, state):
    """a and p_0 from the force alone: a^3 = F r / K, p_0 = 3 F / (2 pi a^2), K by hand."""
    k = [(1 - nu**2) / (np.pi * E) for E, nu in ((1.2e9, 0.3), (325e9, 0.31))]
    stiffness = 4.0 / (3.0 * np.pi * sum(k))
    (compression, force, pull), radius = state, 2.45e-6
    a = (force * radius / stiffness) ** (1.0 / 3.0)
    rho, pressure = points(tables["fig19_pressure"], "stresses", "pressure").T
    assert rho.max() * 1e-6 == pytest.approx(a, rel=1e-9)
    assert pressure.max() * 1e9 == pytest.approx(1.5 * force / (np.pi * a**2), rel=1e-9)
    assert compression == pytest.approx(a**2 / radius, rel=1e-9)
    edge = points(tables["fig19_ring"], "stresses", "ring tension")
    np.testing.assert_allclose(edge[:, 0] * 1e-6, [-a, a])
    assert 2.0 * np.pi * a * edge[0, 1] == pytest.approx(pull, rel=1e-9)


def test_section_of_fig19_is_a_flattened_sphere(tables, state):
    outline, free = (points(tables["fig19"], "section", part) for part in ("sphere", "free shape"))
    radius, a = 2.45, points(tables["fig19_pressure"], "stresses", "pressure")[:, 0].max()
    (centre,) = points(tables["fig19"], "section", "centre")
    assert free[:, 1].min() == pytest.approx(-state[0] * 1e6, abs=1e-3)
    # It touches over the contact alone; further out it approaches the free shape from outside.
    gap = outline[:, 1]
    assert gap.min() > -1e-3
    assert gap[np.abs(outline[:, 0]) > 1.2 * a].min() > 5e-3
    away = np.hypot(*(outline - centre).T) - radius
    assert np.abs(away).max() == pytest.approx(a**2 / (2 * radius), rel=0.02)


def turned(one, other):
    """Angle in degrees from one vector to another, counterclockwise."""
    cross = one[0] * other[1] - one[1] * other[0]
    return np.degrees(np.arctan2(cross, one @ other))


def test_angles_of_fig22(tables, parameters):
    table = tables["fig22"]
    surface = points(table, "geometry", "surface")
    wave = parameters["wavy_surface"]
    axes = {
        f"{kind} {axis}": vector(table, "geometry", f"{kind} {axis}")
        for kind, axis in itertools.product(("nominal", "local"), ("tangent", "normal"))
    }
    phi = turned(axes["nominal tangent"], axes["local tangent"])
    assert phi > 0, "the surface faces the sphere"
    slope = np.interp(0.0, surface[:, 0], np.gradient(surface[:, 1], surface[:, 0]))
    assert slope == pytest.approx(np.tan(np.radians(phi)), rel=1e-3)
    assert turned(axes["nominal normal"], axes["local normal"]) == pytest.approx(phi)
    incoming = vector(table, "geometry", "incident velocity")
    alpha = turned(incoming, axes["nominal tangent"])
    local = turned(incoming, axes["local tangent"])
    assert alpha == pytest.approx(wave["angle_deg"])
    assert local == pytest.approx(alpha + phi)


def test_sphere_of_fig22_touches_at_the_point_of_impact_alone(tables, parameters):
    circle = points(tables["fig22"], "geometry", "sphere")[:-1]
    x, z = points(tables["fig22"], "geometry", "surface").T
    centre, radius = circle.mean(axis=0), parameters["wavy_surface"]["diameter_um"] / 2
    distance = np.hypot(x - centre[0], z - centre[1])
    assert distance.min() == pytest.approx(radius, rel=1e-6)
    assert x[np.argmin(distance)] == pytest.approx(0.0, abs=1e-9)
    assert np.hypot(*centre) == pytest.approx(radius)
