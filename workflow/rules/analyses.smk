"""A rule per analysis, under its name: it reads the tables of its `NEEDS`, and makes those listed here."""

MADE = {
    "fig01_03_13_19_22_schematics": data(
        "fig01", "fig02", "fig03", "fig13", "fig19", "fig19_pressure", "fig19_ring", "fig22"
    ),
    "fig04_05_normal_experiments": {
        **tables("normal_experiments", "size_effects"),
        **data("fig04", "fig05"),
    },
    "fig06_12_oblique_experiments": {
        **tables("oblique_experiments"),
        **data("fig06", "fig07", "fig08", "fig09", "fig10", "fig11", "fig12", "fig23_points"),
    },
    "fig14_restitution_trends": data("fig14"),
    "fig15_16_restitution_fits": {**tables("restitution_fits"), **data("fig15", "fig16")},
    "fig17_coulomb_friction": data("fig17"),
    "fig18_21_oblique_impact": data("fig18", "fig21"),
    "fig20_force_history": {**tables("force_ratios"), **data("fig20")},
    "fig24_25_doe": {
        **tables("doe_levels", "doe_design", "doe_effects", "doe_bd_aliasing", "doe_elasticities"),
        **data("fig24", "fig25"),
    },
    "calibration": {
        **tables("calibration", "calibration_family", "molybdenum_capture"),
        **data("ridge", "ridge_curves"),
    },
    "campaign": {**tables("campaign"), **data("campaign_map")},
    "capture_velocities": {**tables("capture_laws"), **data("capture_law_curves")},
    "contact_properties": tables("contact_properties"),
    "declared_inputs": tables("inputs"),
    "edge_speed": {**tables("edge_speed"), **data("edge_speed_plateau", "edge_speed_curves")},
    "external_evidence": tables("external_evidence"),
    "inference": {
        **tables("evidence_summary", "evidence_statements", "posterior_contacts"),
        **data(
            "evidence_limits",
            "evidence_works",
            "capture_velocity_summary",
            "capture_velocity_profile",
            "posterior_bands",
        ),
    },
    "interval_coverage": {
        **tables("interval_coverage"),
        **data("coverage_by_speed", "coverage_by_angle"),
    },
    "mechanisms": {
        **tables(
            "spin_mechanism",
            "spin_needed",
            "spin_or_tilt",
            "slope_mechanism",
            "surface_pairs",
            "formica_mechanism",
            "spore_mechanism",
            "spore_trends",
            "spore_comparison",
            "smooth_spore",
            "adhesion_or_roughness",
            "loss_slopes",
            "loss_resolution",
        ),
        **data("causes", "causes_slope", "causes_shallow"),
    },
    "oblique_data": {
        **tables("oblique_comparison", "oblique_residuals"),
        **data("oblique_velocity", "oblique_spin", "contact_point"),
    },
    "pair_search": {
        **tables("pairing_quality", "surface_correction"),
        **data("doppler_stream", "pairing_curves", "correction_curves"),
    },
    "particle_separation": {**tables("particle_separation"), **data("separation")},
    "pile_up": {**tables("pile_up", "pile_up_onsets"), **data("pile_up_onset")},
    "rival_explanations": {
        **tables("rival_explanations", "capture_evidence", "rival_forces"),
        **data("rival_restitution"),
    },
    "rolling_dissipation": {**tables("rolling_dissipation"), **data("rolling")},
    "roughness_expansions": data("roughness"),
    "sensitivity": {**tables("sensitivity_indices", "sensitivity_convergence"), **data("sobol")},
    "size_law": {
        **tables("size_law_exponents", "size_law_design"),
        **data("size_law_curves", "size_law_impacts"),
    },
    "track_imaging": {**tables("ptis_range"), **data("ptis_frame", "ptis_pixels", "ptis_accuracy")},
}

for analysis, files in MADE.items():

    rule:
        name:
            analysis
        input:
            **tables(*analyses.needs(analysis)),
        output:
            **files,
        log:
            f"<results>/logs/{analysis}.log",
        benchmark:
            f"<results>/benchmarks/{analysis}.tsv"
        params:
            **parameters(analysis),
        script:
            "../scripts/run_analysis.py"


# Another number of parts, each a job: `snakemake --set-scatter fig23_monte_carlo=64`.
scattergather:
    fig23_monte_carlo=1,


MONTE_CARLO_PARTS = gather.fig23_monte_carlo("<results>/parts/fig23_monte_carlo-{scatteritem}.csv")


rule fig23_monte_carlo_part:
    """parts/*.csv: estimates of some of the variants and angles, until all are gathered."""
    input:
        **tables("calibration"),
        samples=sample_files(SETTINGS.branches["fig23_monte_carlo"]),
    output:
        part=temp("<results>/parts/fig23_monte_carlo-{scatteritem}.csv"),
    log:
        "<results>/logs/fig23_monte_carlo-{scatteritem}.log",
    benchmark:
        "<results>/benchmarks/fig23_monte_carlo-{scatteritem}.tsv"
    params:
        **parameters("fig23_monte_carlo"),
    script:
        "../scripts/run_analysis.py"


rule fig23_monte_carlo:
    """data/fig23.csv; tables/monte_carlo.csv, slope_inference.csv."""
    input:
        **tables("calibration"),
        samples=sample_files(SETTINGS.branches["fig23_monte_carlo"]),
        # A single part is made at once.
        parts=MONTE_CARLO_PARTS[1:] and MONTE_CARLO_PARTS,
    output:
        **tables("monte_carlo", "slope_inference"),
        **data("fig23"),
    log:
        "<results>/logs/fig23_monte_carlo.log",
    benchmark:
        "<results>/benchmarks/fig23_monte_carlo.tsv"
    params:
        **parameters("fig23_monte_carlo"),
    script:
        "../scripts/run_analysis.py"
