"""Imaging system: its range, its error model against its frames, and the figures."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.lab.ptis import errors
from microimpact.lab.ptis.observation import photographed
from study.declared.parameters import build
from study.studies.experiments.track_imaging import Params, agreement, error_cases

SMALL = {
    "speeds_m_per_s": [0.1, 0.3, 3.0, 30.0],
    # Where the shares observed lie far from the least that counts.
    "angles_deg": [60.0],
    "drawn_angle_deg": 60.0,
    "pixels_um": [10.0, 100.0],
    "dash_pitches_px": [25.0, 40.0],
    "modelled_events": 12,
    "rendered_events": 6,
    "experiments": 1,
    "events": 24,
}


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("track_imaging", **SMALL)


@pytest.fixture(scope="module")
def ranges(tables):
    return tables["ptis_range"]


def test_the_chopper_stays_within_its_limit(ranges):
    assert ranges["chop_per_s"].max() <= 5000.0
    assert np.allclose(ranges["disk_rev_per_min"], 6.0 * ranges["chop_per_s"])


def test_the_lowest_speed_falls_half_a_millimetre_and_is_never_seen(ranges):
    slow = ranges[ranges["speed_m_per_s"] == 0.1]
    assert slow["fall_height_mm"].iloc[0] == pytest.approx(0.1**2 / (2 * 9.80665) * 1e3)
    assert (slow["fraction_observed"] == 0.0).all()


@pytest.fixture(scope="module")
def held(settings):
    """Return a function that holds the error model against frames, in some of the cases."""
    branch = settings.branches["track_imaging"]

    def hold(cases=slice(None), **changes):
        chosen = dict(list(branch["error_cases"].items())[cases])
        params = build(Params, {**branch, "error_cases": chosen, **changes})
        errors, agreement, _ = error_cases(params)
        return errors, agreement.set_index("quantity")

    return hold


def test_error_model_agrees_with_the_frames_of_twelve_experiments(held, settings):
    branch = settings.branches["track_imaging"]
    assert branch["experiments"] * len(branch["error_cases"]) >= 10
    errors, agreement = held()
    assert set(agreement["verdict"]) == {"agrees"}
    assert (agreement["value"] < agreement["tolerance"]).all()
    # 64 to 103 events per case: a standard deviation of 1 is known to 7 to 9 %.
    assert errors["events"].min() > 60
    assert errors["normalised_sd"].between(0.75, 1.3).all()
    assert (errors["normalised_mean"].abs() < 4.0 / np.sqrt(errors["events"])).all()
    assert (errors["mean_relative_residual"].abs() < 2e-4).all()


def joined_from_afar(event, path, light, height, edge, alone=errors._alone):
    """Dashes run together from 16 pixels on in place of 2, and not nearer to the surface."""
    return alone(event, path, light, height + 7.0, edge + 7.0)


@pytest.mark.parametrize(
    ("place", "name", "wrong", "quantity"),
    [
        (errors, "CENTROID_NOISE", 2.5, "scatter of frames over model, logarithm"),
        (errors, "_alone", joined_from_afar, "share with another outcome"),
        (
            agreement,
            "observe",
            lambda *given: photographed(*given).reduced(given[1], with_gravity=False),
            "largest bias of speed",
        ),
    ],
    ids=["noise", "detection", "bias"],
)
def test_a_wrong_error_model_differs_from_the_frames(
    held, monkeypatch, place, name, wrong, quantity
):
    monkeypatch.setattr(place, name, wrong)
    assert held(slice(3, 4), experiments=1)[1].loc[quantity, "verdict"] == "differs"


def test_a_value_too_near_to_its_tolerance_is_undecided():
    values = {0.5: "agrees", 0.85: "undecided", 1.15: "undecided", 1.5: "differs"}
    for value, expected in values.items():
        found = [(0.1, 0.0), (value, 0.1), (np.nan, np.nan)]
        assert agreement.verdict("any", "1", found, 1.0)["verdict"] == expected
    assert agreement.verdict("any", "1", [(np.nan, np.nan)], 1.0)["verdict"] == "undecided"


def test_losses_add_up(tables):
    keys = ["speed_m_per_s", "angle_deg", "pixel_um", "method"]
    for _, rows in tables["ptis_losses"].groupby(keys):
        assert rows["fraction"].sum() == pytest.approx(1.0)
