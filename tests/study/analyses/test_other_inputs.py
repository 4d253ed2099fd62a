"""Other inputs than the shipped: no printed mark beside another impact, wrong ones refused."""

from __future__ import annotations

import pytest

MICA = "ammonium-fluorescein-mica"
FLUORESCEIN = "ammonium-fluorescein"


@pytest.fixture
def run(run_study, calibration):
    """The function that runs a study from the calibration, with changes of its parameters."""
    return lambda study, changes: run_study(study, calibration, **changes)


@pytest.mark.parametrize(
    ("study", "changes", "drawn"),
    [
        (
            "pile_up",
            {"case": "steel-mirror front", "spheres": 50, "speeds_m_per_s": [0.3, 1.0]},
            ("pile_up_onset",),
        ),
        (
            "fig04_05_normal_experiments",
            {
                "case": MICA,
                "populations": {key: {"particle": FLUORESCEIN} for key in ("SST65", "SST125")},
                "speeds_m_per_s": [3.0, 6.0],
                "points": 20,
            },
            ("fig04", "fig05"),
        ),
    ],
)
def test_beside_another_pair_nothing_printed_is_drawn(run, draw, study, changes, drawn):
    tables = run(study, changes)
    for name in drawn:
        assert "printed" not in set(tables[name]["evidence"])
        assert "article" not in "".join(t.get_text() for t in draw(name, tables).axes[0].texts)


def test_printed_restitution_is_not_drawn_of_another_particle(run, settings):
    spore = settings.branches["mechanisms"]["spore"]
    steel = {"spore": {**spore["spore"], "case": "steel-silicon, n = 1"}, "seen_deg": [38.0]}
    few = {"impacts": 60, "spore": {**spore, **steel, "seen_events": 2, "seen_dropped": 600}}
    assert "printed" not in set(run("mechanisms", few)["causes"]["evidence"])


SET_UPS, OBLIQUE = "fig01_03_13_19_22_schematics", "fig06_12_oblique_experiments"
# A study, a key of its branch, a wrong value and what is said of it.
WRONG = [
    ("pile_up", "speeds_m_per_s", [0.3, 0.2], "must ascend"),
    ("pile_up", "drawn_radius_mm", 4.0, "must be one of"),
    ("mechanisms", "spore.angles_deg", [85, 45, 20, 15, 10, 5], "angles_deg: must hold 38"),
    ("interval_coverage", "experiments", 1, r"interval_coverage\.experiments: "),
    ("interval_coverage", "level", 1.0, r"interval_coverage\.level: "),
    ("interval_coverage", "events", 1, r"interval_coverage\.events: "),
    ("interval_coverage", "cases",
     dict.fromkeys(("smooth, oblique", "rough, oblique", "slow, oblique")), "one at another angle"),
    ("pair_search", "dispenser.lateral_position_mm", 1e4, r"particles: at .* fall through the pro"),
    (SET_UPS, "wavy_surface", {"place_um": 25.0, "angle_deg": 10.0},
     r"place_um: 25\.0 has a slope of -20"),
    (SET_UPS, "wavy_surface.diameter_um", 200.0, r"diameter_um: a sphere of 200\.0 um"),
    ("particle_separation", "silica_diameter_nm", [30, 10], r"\[30, 10\] must ascend"),
    ("particle_separation", "patch_share", [0.5, 1.5], "patch_share: 1.5 must be at most 1"),
    ("particle_separation", "compared_silica_fraction", 0.5, "0.5 must be at most largest"),
    ("particle_separation", "breakdown_field_V_per_um", [0.1, 1.0], "patches would cover more"),
    ("rolling_dissipation", "angles_deg", [45.0, 90.0],
     r"^rolling_dissipation.angles_deg\[1\]: 90.0 must be .* 90$"),
    ("rolling_dissipation", "angles_deg", [45.0, 30.0], "must ascend"),
    ("capture_velocities", "pairs", {"nothing": {}}, "'nothing' is not declared in cases"),
    (OBLIQUE, "compared_series", "2 m/s", "'2 m/s' must be one of silicon front"),
    (OBLIQUE, "compared_with_all", ["2 m/s"], "'2 m/s' must be one of silicon front"),
    (OBLIQUE, "series.silicon front.figures", ["fig99"], "'fig99' must be one of fi"),
    ("oblique_data", "external", "wall1990", r"quantity must be one of .*got 'd"),
    ("inference", "pairs.steel-silicon.diameter_um", 50.0, "one of classes_um"),
    ("inference", "pairs.steel-silicon.laws.ring force, n free.ranges.friction", [0.2, 0.1],
     "friction.* must ascend"),
    ("inference", "pairs.steel-silicon.scenarios.with the printed v_c.without", ["nothing"],
     "'nothing' must be one of the statements"),
    ("inference", "pairs.steel-silicon.statements.printed capture velocity.quantity", "v",
     "quantity"),
]  # fmt: skip


@pytest.mark.parametrize(("study", "key", "value", "message"), WRONG)
def test_wrong_parameters_are_refused_by_name(run, study, key, value, message):
    changes = value
    for part in reversed(key.split(".")):
        changes = {part: changes}
    with pytest.raises(ValueError, match=message):
        run(study, changes)
