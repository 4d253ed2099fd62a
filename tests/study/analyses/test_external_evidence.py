"""What others measured: oblique rebounds against three laws, and facts of abstracts."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from study.analyses import external_evidence


@pytest.fixture(scope="module")
def tables(run_study):
    return run_study("oblique_data")


@pytest.fixture(scope="module")
def rms(tables):
    return tables["oblique_residuals"].set_index(["quantity", "branch", "law"]).sort_index()


@pytest.fixture(scope="module")
def evidence(run_study, tables):
    made = {
        "doe_levels": LEVELS,
        "doe_effects": effects(A=-5.0, B=9.0, C=-8.0, D=4.0, BC=1.0, BD=-2.0, AB=0.5),
        "monte_carlo": pd.DataFrame(
            {"variant": ["x", "y"], "angle_deg": [8.0, 8.0], "restitution": [1.4, 0.9]}
        ),
        "oblique_residuals": tables["oblique_residuals"],
    }
    return run_study("external_evidence", made)["external_evidence"]


class TestObliqueData:
    def test_angles_are_turned_into_those_from_the_surface(self, tables):
        rows = tables["oblique_comparison"].query("quantity == 'tangential_restitution'")
        first = rows.iloc[0]
        assert first["angle_deg"] == pytest.approx(90 - 1.84)
        assert first["measured"] == pytest.approx(0.79344)
        # close to the surface nearly all the velocity is left, whoever reads
        shallow = rows[rows["angle_deg"] < 10]
        assert (shallow["measured"] > 0.97).all()

    def test_where_it_slides_every_law_is_the_rigid_one_and_fits_to_a_hundredth(self, rms):
        sliding = rms.loc[("tangential_restitution", "sliding")]
        assert sliding.loc[["rigid", "mindlin", "spring"], "rms"].nunique() == 1
        assert sliding.loc["rigid", "relative_rms"] < 0.01

    def test_errors_of_friction_and_restitution_carry_over_where_it_slides(self, rms):
        error = rms["input_error"].xs("rigid", level="law")["tangential_restitution"]
        # of at most 2/7 lost, in the share of f (1 + e), where 5/7 are left
        most = 2 / 5 * np.hypot(0.002 / 0.092, 0.01 / 1.98)
        assert 0.1 * most < error["sliding"] < most
        assert error["sticking"] == 0.0

    def test_at_21_deg_from_the_normal_the_measured_spin_is_43_percent_above_rolling(self, tables):
        rows = tables["oblique_comparison"].query("quantity == 'spin' and reading == 'A'")
        row = rows[np.isclose(rows["angle_deg"], 90 - 21.251)].iloc[0]
        assert row["measured"] / row["rigid"] == pytest.approx(1.43, abs=0.005)
        assert row["measured"] / row["mindlin"] == pytest.approx(1.02, abs=0.01)

    def test_the_articles_angle_bounds_the_contact_point_and_decides_nothing(self, tables):
        rows = tables["contact_point"].set_index("series")
        own = rows.loc["article"]
        assert own["y_1"] == pytest.approx(0.064, abs=5e-4)
        assert (own["y_low"], own["y_high"]) == pytest.approx((-0.107, 0.275), abs=1e-3)
        # the rigid contact rolls, at zero; the compliant one passes the same range
        curve = rows.loc["microspheres"].sort_values("x_1")
        assert own["y_low"] < 0.0 < np.interp(own["x_1"], curve["x_1"], curve["y_1"])
        assert np.interp(own["x_1"], curve["x_1"], curve["y_1"]) < own["y_high"]
        # the laws part company above that angle, as the elastic spheres show
        assert rows.loc[rows["evidence"] == "measured", "y_1"].max() == pytest.approx(
            0.41, abs=0.01
        )
        assert curve["y_1"].max() > 0.4
        assert rows.loc["rigid", "y_1"].max() < 1e-9

    def test_friction_moves_the_residuals(self, run_study, rms):
        other = run_study("oblique_data", friction=0.12)["oblique_residuals"]
        rows = other.set_index(["quantity", "branch", "law"]).sort_index()
        place = ("tangential_restitution", "sliding", "rigid")
        assert rows.loc[place, "rms"] > 3 * rms.loc[place, "rms"]

    def test_the_printed_angle_vanishes_for_another_pair(self, run_study):
        another = {"microspheres": {"case": "ammonium-fluorescein-mica", "speed_m_per_s": 20.0}}
        made = run_study("oblique_data", **another)
        assert "printed" not in set(made["contact_point"]["evidence"])


LEVELS = pd.DataFrame(
    {
        "name": ["stiffness", "work_of_adhesion", "radius", "adhesion_dissipation"],
        "factor": list("ABCD"),
    }
)


def effects(**sizes):
    return pd.DataFrame(
        {
            "case": "one",
            "variation": "uniform",
            "design": "full",
            "response": "v_c",
            "effect": list(sizes),
            "effect_percent": list(sizes.values()),
        }
    )


class TestExternalEvidence:
    def rows(self, evidence, fact):
        found = evidence[evidence["fact"].str.contains(fact)]
        assert len(found)
        return found.set_index("contact")

    def test_a_fixed_share_lost_gives_the_classical_power_and_no_more(self, evidence):
        """Without material damping n = 1 is scale-free: v_c goes as d to the power of -5/6."""
        found = self.rows(evidence, "classical power")
        assert found.loc["fluorescein-molybdenum, nominal, n = 1", "computed"] == pytest.approx(
            5 / 6, abs=1e-4
        )
        words = found["agreement"]
        assert words["fluorescein-molybdenum, nominal, n = 1"] == external_evidence.DISAGREES
        assert words["fluorescein-molybdenum, nominal, n = 0"] == external_evidence.AGREES

    def test_ranks_come_from_the_effects(self, evidence):
        lead, rank = (
            self.rows(evidence, words)["computed"].iloc[0]
            for words in ("by far the greatest", "one interaction")
        )
        assert lead == pytest.approx(8.0 / 5.0)
        assert rank == 1.0

    def test_the_least_variant_of_the_rough_surface_counts(self, evidence):
        row = self.rows(evidence, "apparent restitution").iloc[0]
        assert row["computed"] == 0.9
        assert row["agreement"] == external_evidence.DISAGREES
