"""Range of the imaging system."""

from __future__ import annotations

import pytest


def test_the_lowest_speed_falls_half_a_millimetre_and_is_never_seen(run_study):
    few = {"modelled_events": 12, "rendered_events": 6, "pixels_um": [10.0], "angles_deg": [45.0]}
    table = run_study("track_imaging", speeds_m_per_s=[0.1, 3.0], **few)["ptis_range"]
    slow = table[table["speed_m_per_s"] == 0.1]
    assert slow["fall_height_mm"].iloc[0] == pytest.approx(0.1**2 / (2 * 9.80665) * 1e3)
    assert (slow["fraction_observed"] == 0.0).all()
