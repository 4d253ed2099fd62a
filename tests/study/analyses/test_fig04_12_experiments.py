"""Figs. 4 to 12: virtual experiments against what they measure, and what the article prints."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from microimpact.model.contact import resized
from microimpact.model.dynamics.impact import simulate
from study.analyses.campaign import compute as campaign
from study.contacts import calibrated_contact
from study.declared.parameters import build
from study.tables import parse_table


@pytest.fixture(scope="module")
def oblique(run_study, calibration):
    return run_study(
        "oblique_experiments", calibration, angles_deg=[85, 60, 45, 30, 20, 10], points=90
    )


@pytest.fixture(scope="module")
def angles(oblique):
    return oblique["oblique_experiments"].set_index(["series", "angle_deg"])


def test_energy_loss_is_one_minus_the_mean_square(run_study, calibration):
    tables = run_study("fig04_05_normal_experiments", calibration, speeds_m_per_s=[1.25], points=60)
    row = tables["normal_experiments"].set_index("population").loc["SST125"]
    # The mean of e^2 exceeds the square of the mean by the variance alone.
    assert row["energy_loss"] == pytest.approx(1.0 - row["restitution"] ** 2, abs=2e-3)


def test_an_experiment_without_enough_events_has_no_point(run_study, calibration):
    stop = {"events": 40, "fewest_events": 10, "most_dropped": 4000}
    tables = run_study(
        "normal_experiments", calibration, speeds_m_per_s=[0.25, 1.0], points=20, stop=stop
    )
    table = tables["normal_experiments"].set_index(["population", "nominal_speed_m_per_s"])
    assert np.isnan(table.loc[("SST65", 0.25), "restitution"])
    marks = tables["fig04"].query("series == 'SST65' and evidence == 'virtual experiment'")
    assert (marks["x_m_per_s"] > 0.9).all()


def test_coulomb_curves_roll_with_the_restitution_of_their_own_contact(
    settings, run_study, calibration
):
    """Another sphere in Fig. 6 leaves steel on the mirror and on Formica as they are."""
    light = {"silicon front": {"case": "polystyrene-latex-fused-silica", "figures": ["fig06"]}}
    tables = run_study(
        "fig06_12_oblique_experiments", calibration, angles_deg=[85], points=90, series=light
    )
    inputs = {**calibration, "materials": pd.DataFrame(settings.tables.materials.rows)}
    contacts = {
        "fig06": "polystyrene-latex-fused-silica",
        "fig07": "steel-mirror front",
        "fig11": "steel-silicon, n = 1",
    }
    for figure, case in contacts.items():
        rows = tables[figure].query("series == 'Coulomb friction' and 70 < x_deg < 90")
        contact = resized(calibrated_contact(inputs, case), 62e-6)
        e = simulate(contact, 1.66).coefficient_of_restitution
        rolling = 2.0 / 7.0 / np.tan(np.radians(rows["x_deg"])) / (1.0 + e)
        assert rows["y_1"].to_numpy() == pytest.approx(rolling.to_numpy(), rel=1e-4)


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
    params = build(campaign.Params, {**branch, "blocks": own})
    declared = settings.rows["campaign"].items()
    inputs = {**calibration, **{name: parse_table(text) for name, text in declared}}
    (one,) = campaign.experiments(params, params.blocks["one"], inputs)
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


def test_the_mean_of_all_rebounds_shows_what_the_imaging_leaves_out(oblique, angles):
    """At 0.45 m/s slow rebounds at steep angles; of rough surfaces those that leave flat."""
    chosen = angles.loc[[("0.45 m/s", 85), ("silicon back", 10), ("steel on Formica", 20)]]
    assert (chosen["true_restitution"] > chosen["true_restitution_of_rebounds"] + 0.01).all()
    fast = angles.loc["silicon front"].loc[[85, 60, 45, 30]]
    assert np.allclose(fast["true_restitution_of_rebounds"], fast["true_restitution"], atol=0.01)
    # Where hardly any sphere rebounds there is no mean.
    assert np.isnan(angles.loc[("0.45 m/s", 10), "true_restitution_of_rebounds"])
    drawn = oblique["fig08"].query("series == '0.45 m/s, all rebounds'")
    column = angles.loc["0.45 m/s", "true_restitution_of_rebounds"].dropna()
    assert dict(zip(drawn["x_deg"], drawn["y_1"], strict=True)) == column.to_dict()


@pytest.mark.parametrize(
    "impact",
    [
        {"case": "ammonium-fluorescein-mica"},
        {"speed_m_per_s": 3.0, "speed_range_m_per_s": [2.9, 3.1]},
        {"diameter_um": {"kind": "constant", "at": 30.0}},
    ],
)
def test_marks_vanish_where_their_series_is_of_another_impact(run_study, calibration, impact):
    marks = {}
    for name, changes in {"shipped": {}, "changed": {"silicon front": impact}}.items():
        tables = run_study(
            "oblique_experiments", calibration, series=changes, angles_deg=[85], points=10
        )
        marks[name] = {
            figure: set(tables[figure].query("evidence == 'printed'")["series"])
            for figure in ("fig06", "fig07", "fig08", "fig11")
        }
    lost = {"printed, smooth", "printed, smooth, shallow", "printed plateau"}
    assert marks["shipped"]["fig06"] == {*lost, "printed, exceeded below"}
    assert marks["changed"] == marks["shipped"] | {"fig06": marks["shipped"]["fig06"] - lost}
