"""The campaign of 187 experiments, and what the intervals of their means hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from study.analyses.campaign import compute as study
from study.analyses.campaign.compute import FATES
from study.declared.parameters import build
from study.tables import NotComputedError, computed, parse_table

QUANTITIES = ("restitution", "impulse_ratio", "energy_loss")


@pytest.fixture(scope="module")
def campaign(run_study, calibration):
    return run_study("campaign", calibration)


@pytest.fixture(scope="module")
def rows(campaign):
    return campaign["campaign"]


@pytest.fixture(scope="module")
def coverage(run_study, calibration):
    fewer = {"cases": {"smooth, normal": {"simulated": 100000}}}
    return run_study("interval_coverage", calibration, **fewer)


def test_the_campaign_has_the_printed_numbers_of_experiments_and_levels(campaign, rows):
    assert len(rows) == 187
    assert rows["particles"].nunique() == 5
    assert rows["surface"].nunique() == 11
    assert rows["angle_deg"].nunique() == 14
    assert rows["nominal_speed_m_per_s"].nunique() == 14


def test_every_particle_has_one_fate(rows):
    assert (rows[list(FATES)].sum(axis=1) == rows["dropped"]).all()
    imaged = rows[rows["instrument"] == "PTIS"]
    assert (imaged["events"] <= imaged["measured"]).all()


def test_experiments_end_with_enough_events_or_all_particles_dropped(rows):
    short = rows[rows["events"] < 40]
    assert (short["dropped"] == 64000).all()
    few = rows["events"] < 10
    assert rows.loc[few, "restitution"].isna().all()
    assert rows.loc[~few, "restitution"].notna().all()
    # Captured, or beside the sheet at the shallowest angle.
    assert ((rows.loc[few, "captured_share"] > 0.5) | (rows.loc[few, "angle_deg"] <= 5)).all()


def test_intervals_hold_what_they_should_about_as_often_as_they_should(rows):
    for name in QUANTITIES:
        own = rows[rows[name].notna()]
        inside = own[f"true_{name}"].between(own[f"{name}_low"], own[f"{name}_high"])
        # Of the events themselves: the sampling error, a part of the interval, is not in play.
        assert inside.mean() > 0.9


@pytest.mark.parametrize("name", ["mirror back", "ground silica"])
def test_an_experiment_is_the_same_alone_and_among_the_others(settings, calibration, rows, name):
    declared = settings.rows["campaign"].items()
    inputs = {**calibration, **{name: parse_table(text) for name, text in declared}}
    params = build(study.Params, settings.branches["campaign"])
    block = replace(params.blocks[name], angles_deg=(45.0,))
    (alone,) = study.experiments(params, block, inputs)
    (among,) = rows[(rows["surface"] == name) & (rows["angle_deg"] == 45.0)].to_dict("records")
    assert alone == among


def test_intervals_hold_the_mean_of_measurable_events_as_often_as_they_say(coverage):
    table = coverage["interval_coverage"]
    assert (table["experiments"] >= 2000).all()
    # Each repetition has its own height of the probe, which decides what can be measured: not so
    # where all rebounds rise above it.
    plain = (table["instrument"] == "PTIS") | (table["speed_m_per_s"] > 0.4)
    found, error = table.loc[plain, "coverage_observable"], np.sqrt(0.95 * 0.05 / 2000)
    # Where one normal error shared by all events is the interval, t(39) makes it 95.7 %.
    assert found.max() < 0.957 + 3.3 * error
    assert found.median() == pytest.approx(0.9515, abs=0.004)
    # The t distribution is for events that are not too skew, which cost a little.
    assert found.min() > 0.92


def test_repetitions_are_like_the_experiments_of_the_campaign(coverage, rows):
    """Same speed and surface: means agree within the interval of the single experiment."""
    repeated = coverage["interval_coverage"].set_index(["case", "angle_deg"])
    own = rows.query("particles == 'SST76' and nominal_speed_m_per_s == 1.66")
    for surface, case in (("silicon front", "smooth"), ("silicon back", "rough")):
        for angle in (60, 30, 15):
            one = own[(own["surface"] == surface) & (own["angle_deg"] == angle)].iloc[0]
            many = repeated.loc[(f"{case}, oblique", float(angle))]
            half = 0.5 * (one["restitution_high"] - one["restitution_low"])
            assert abs(one["restitution"] - many["mean_observable"]) < 2.0 * half
            assert half == pytest.approx(many["half_width"], rel=0.7)


def test_a_class_that_nothing_meets_costs_no_other(settings, run_study, calibration):
    normal, oblique, *others = settings.branches["interval_coverage"]["cases"]
    cases = {oblique: {"angles_deg": [2.0]}, normal: {"speeds_m_per_s": [1.25]}}
    cases |= dict.fromkeys(others)
    tables = run_study("interval_coverage", calibration, cases=cases)
    table = tables["interval_coverage"].set_index("angle_deg")
    assert table["coverage_observable"].notna().to_dict() == {2.0: False, 90.0: True}
    why = r"interval_coverage.cases.smooth, oblique, 1.66 m/s, 2 deg: no event .* 40 are wanted"
    with pytest.raises(NotComputedError, match=why):
        computed(tables["coverage_by_angle"])
    assert len(tables["coverage_by_speed"])


@pytest.mark.parametrize(("speed", "angle"), [(1.05, 90), (1.66, 45)])
def test_the_same_experiment_gives_the_same_number_in_every_study(
    settings, run_study, calibration, speed, angle
):
    """Of one speed class and spin: by Fig. 4 or Fig. 6, and in the campaign."""
    branch = settings.branches["campaign"]
    window = 0.1 if angle == 90 else 0.036
    ends = [speed * (1 - window), speed * (1 + window)]
    speeds = [{"speed_m_per_s": speed, "speed_range_m_per_s": ends}]
    size = "SST125" if angle == 90 else "SST76"
    block = branch["blocks"]["normal impacts of SST125" if angle == 90 else "fast impacts"]
    own = {"one": {**block, "speeds": speeds, "angles_deg": [angle]}}
    params = build(study.Params, {**branch, "blocks": own})
    declared = settings.rows["campaign"].items()
    inputs = {**calibration, **{name: parse_table(text) for name, text in declared}}
    (one,) = study.experiments(params, params.blocks["one"], inputs)
    if angle == 90:
        found = run_study(
            "fig04_05_normal_experiments", calibration, speeds_m_per_s=[speed], points=10
        )
        rows = found["normal_experiments"].set_index("population")
    else:
        size = "silicon front"
        changes = {
            "series": {size: {"speed_range_m_per_s": ends}},
            "angles_deg": [angle],
            "reference_angle_deg": angle,
        }
        found = run_study("fig06_12_oblique_experiments", calibration, points=10, **changes)
        rows = found["oblique_experiments"].set_index("series")
    names = ("dropped", "events", "restitution", "restitution_low", "restitution_high")
    assert [rows.loc[size, name] for name in names] == [one[name] for name in names]
