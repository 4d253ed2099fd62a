"""Pairs of the phase Doppler analyser: their quality, and the correction to the surface."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def tables(run_study, settings, calibration):
    correction = settings.branches["pair_search"]["correction"]
    return run_study(
        "pair_search",
        calibration,
        heights_mm=[1.0, 5.0],
        speeds_m_per_s=[0.3, 0.5, 0.75, 1.66],
        experiments=8,
        correction={**correction, "speeds_m_per_s": [0.2, 0.5, 1.6], "particles": 500},
    )


def test_pairs_are_right_and_slow_rebounds_do_not_reach_a_high_probe(tables):
    quality = tables["pairing_quality"].set_index(["probe_height_mm", "speed_m_per_s"])
    assert (quality.loc[1.0, ["precision", "recall"]] > 0.95).all(axis=None)
    for name in ("precision", "recall", "recall_of_seen_rebounds"):
        assert (quality[f"{name}_low"] <= quality[name]).loc[1.0].all()
        assert (quality[name] <= quality[f"{name}_high"]).loc[1.0].all()
    found = quality["recall_of_seen_rebounds"]
    assert found[5.0, 0.5] < 0.5 < found[1.0, 0.5]


def test_correction_follows_its_closed_form(tables):
    table = tables["surface_correction"].set_index(["speed_m_per_s", "restitution"])
    assert table.loc[(1.6, 0.7), "closed_form"] + 0.7 == pytest.approx(0.722, abs=0.0005)
    assert table.loc[(0.5, 0.4), "closed_form"] + 0.4 == pytest.approx(0.456, abs=0.0005)
    seen = table[(table["events"] > 300) & (table.index.get_level_values(0) > 0.2)]
    assert len(seen) >= 4
    for form, expected in (("printed", seen["closed_form"]), ("exact", 0.0)):
        pull = (seen[form] - expected) / seen[f"{form}_standard_error"]
        assert (pull.abs() < 4).all()


def test_a_rebound_below_the_probe_volume_leaves_no_event(tables):
    """At 0.2 m/s and e = 0.4 it climbs 0.33 mm, below the probe at 1 mm."""
    hidden = tables["surface_correction"].query("speed_m_per_s == 0.2 and restitution == 0.4")
    assert (hidden["events"] == 0).all()
    assert hidden["closed_form"].isna().all()
