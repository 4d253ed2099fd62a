"""Figs. 6 to 12: virtual experiments at oblique incidence, and what the article prints."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from microimpact.model.contact import resized
from microimpact.model.dynamics.impact import simulate
from study.contacts import calibrated_contact


@pytest.fixture(scope="module")
def oblique(run_study, calibration):
    return run_study(
        "fig06_12_oblique_experiments", calibration, angles_deg=[85, 60, 45, 30, 20, 10], points=90
    )


@pytest.fixture(scope="module")
def angles(oblique):
    return oblique["oblique_experiments"].set_index(["series", "angle_deg"])


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
            "fig06_12_oblique_experiments", calibration, series=changes, angles_deg=[85], points=10
        )
        marks[name] = {
            figure: set(tables[figure].query("evidence == 'printed'")["series"])
            for figure in ("fig06", "fig07", "fig08", "fig11")
        }
    lost = {"printed, smooth", "printed, smooth, shallow", "printed plateau"}
    assert marks["shipped"]["fig06"] == {*lost, "printed, exceeded below"}
    assert marks["changed"] == marks["shipped"] | {"fig06": marks["shipped"]["fig06"] - lost}
