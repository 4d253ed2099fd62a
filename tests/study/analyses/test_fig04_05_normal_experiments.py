"""Figs. 4 and 5: virtual experiments at normal incidence."""

from __future__ import annotations

import numpy as np
import pytest


def test_energy_loss_is_one_minus_the_mean_square(run_study, calibration):
    tables = run_study("fig04_05_normal_experiments", calibration, speeds_m_per_s=[1.25], points=60)
    row = tables["normal_experiments"].set_index("population").loc["SST125"]
    # The mean of e^2 exceeds the square of the mean by the variance alone.
    assert row["energy_loss"] == pytest.approx(1.0 - row["restitution"] ** 2, abs=2e-3)


def test_an_experiment_without_enough_events_has_no_point(run_study, calibration):
    stop = {"events": 40, "fewest_events": 10, "most_dropped": 4000}
    tables = run_study(
        "fig04_05_normal_experiments", calibration, speeds_m_per_s=[0.25, 1.0], points=20, stop=stop
    )
    table = tables["normal_experiments"].set_index(["population", "nominal_speed_m_per_s"])
    assert np.isnan(table.loc[("SST65", 0.25), "restitution"])
    marks = tables["fig04"].query("series == 'SST65' and evidence == 'virtual experiment'")
    assert (marks["x_m_per_s"] > 0.9).all()
