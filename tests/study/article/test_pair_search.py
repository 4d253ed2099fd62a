"""Pair search: quality over height and speed, controls, correction, and slow rebounds."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture(scope="module")
def tables(run_study, settings, calibration):
    correction = settings.branches["pair_search"]["correction"]
    small = {
        "heights_mm": [1.0, 5.0],
        "speeds_m_per_s": [0.3, 0.5, 0.75, 1.66],
        "experiments": 8,
        "correction": {**correction, "speeds_m_per_s": [0.2, 0.5, 1.6], "particles": 500},
        "slow": {"speeds_m_per_s": [0.2, 0.3, 0.35, 0.5], "particles": 1500},
    }
    return run_study("pair_search", calibration, **small)


def test_shares_and_losses_agree(tables):
    quality, losses = tables["pairing_quality"], tables["pairing_losses"]
    place = ["probe_height_mm", "speed_m_per_s"]
    assert (losses.groupby(place)["impacts"].sum() == 8 * 60).all()
    for _, row in quality.dropna().iterrows():
        for share in ("precision", "recall", "recall_of_seen_rebounds", "recall_of_rebounds"):
            assert row[f"{share}_low"] <= row[share] <= row[f"{share}_high"]
        assert row["recall_of_rebounds"] <= row["recall_of_seen_rebounds"]


def test_the_height_is_found(tables):
    found = tables["pairing_quality"].query("converged == 1")
    bias = found["height_bias_um"] / found["height_bias_standard_error_um"]
    assert (bias.abs() < 4).all()
    assert found["height_error_rms_in_standard_errors"].between(0.4, 1.8).all()


def test_no_pairs_where_there_are_none(tables):
    controls = tables["pairing_controls"].set_index("stream")
    right = controls.loc["as recorded"]
    assert right["precision"] > 0.99
    assert controls.loc["times of rebounds permuted", "precision"] < 0.3
    assert controls.loc["times of rebounds permuted", "pairs"] < 0.35 * right["pairs"]
    assert controls.loc["rebounds left out", "pairs_per_incident"] < 0.005
    assert controls.loc["10 times the arrivals", "recorded_pairs"] < right["recorded_pairs"]


def test_correction_follows_its_closed_form(tables):
    table = tables["surface_correction"].set_index(["quantity", "speed_m_per_s", "restitution"])
    assert table.loc[("v", 1.6, 0.7), "closed_form"] + 1.6 == pytest.approx(1.73, abs=0.005)
    assert table.loc[("e", 1.6, 0.7), "closed_form"] + 0.7 == pytest.approx(0.722, abs=0.0005)
    assert table.loc[("e", 0.5, 0.4), "closed_form"] + 0.4 == pytest.approx(0.456, abs=0.0005)
    seen = table[(table["events"] > 300) & (table.index.get_level_values(1) > 0.2)]
    assert len(seen) >= 12
    for form, expected in (("printed", seen["closed_form"]), ("exact", 0.0)):
        pull = (seen[form] - expected) / seen[f"{form}_standard_error"]
        assert (pull.abs() < 4).all()


def test_a_rebound_below_the_probe_volume_leaves_no_event(tables):
    table = tables["surface_correction"]
    hidden = table[table["true"].where(table["quantity"] == "V") < np.sqrt(2 * 9.80665e-3)]
    assert len(hidden) > 0
    assert (hidden["events"] == 0).all()
    assert hidden["closed_form"].isna().all()


def test_the_slowest_rebound_seen_reaches_the_probe_volume(tables):
    slow = tables["slow_rebounds"].set_index("speed_m_per_s")
    least = np.sqrt(2 * 9.80665e-3) / slow.index.to_numpy()
    assert slow["least_observable_e"].to_numpy() == pytest.approx(least, abs=0.005)
    assert slow.loc[0.2, "observable_fraction"] == 0.0
    assert abs(slow.loc[0.5, "bias_observable"]) < 0.005
