"""Plateau, capture velocity and size by an edge that opens by its own speed."""

from __future__ import annotations

import numpy as np
import pytest

from study.analyses.edge_speed.compute import ALLOWED, PRINTED


@pytest.fixture(scope="module")
def edges(run_study):
    return run_study("edge_speed", edge_exponents=[0.5, 0.96, 1.5], points=5)


def test_edge_and_bulk_meet_what_is_printed(edges):
    rows = edges["edge_speed"].set_index(["capture_velocity", "edge_exponent"])
    printed = rows.loc["printed"]
    assert printed["v_c_m_per_s"].to_numpy() == pytest.approx(0.18, rel=1e-6)
    assert printed["restitution"].loc[[0.5, 0.96]].to_numpy() == pytest.approx(0.70, abs=1e-6)
    # This edge alone loses more; without a bulk v_c goes by its power of the diameter.
    alone = printed.loc[1.5]
    assert alone["restitution"] < 0.7
    assert alone["adhesion_share"] == pytest.approx(1.0, abs=1e-3)
    assert alone["size_exponent"] == pytest.approx(-1 / (1.2 - 0.6 * 1.5), rel=0.2)
    # The plateau holds below the printed capture velocity alone.
    assert (printed["fall_of_restitution"] > 0.03).all()
    flat = rows.loc["plateau"]
    assert flat["fall_of_restitution"].to_numpy() == pytest.approx(0.03, abs=4e-3)
    assert (flat["v_c_m_per_s"] < 0.18).all()


def test_the_figure_has_a_curve_for_every_exponent(edges):
    falls, curves = edges["edge_speed_plateau"], edges["edge_speed_curves"]
    exponents = {"m = 0.5", "m = 0.96", "m = 1.5"}
    assert set(falls["series"]) == {ALLOWED, *exponents}
    assert set(curves["series"]) == {PRINTED, *exponents}
    slow = curves[curves["x_m_per_s"] < 0.18]
    assert not slow["y_1"].any()
    assert np.all(falls[falls["series"] == "m = 0.96"]["y_1"].diff().dropna() > 0.0)
