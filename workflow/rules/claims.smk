"""Numbers behind the claims of the article."""


rule claim_numbers:
    """tables/claim_numbers.csv: per claim, case and quantity the number that decides it."""
    input:
        **{
            table: f"<results>/tables/{table}.csv"
            for table in (
                "adhesion_or_roughness",
                "calibration",
                "calibration_family",
                "doe_bd_aliasing",
                "doe_design",
                "doe_effects",
                "doe_elasticities",
                "doe_levels",
                "force_ratios",
                "formica_mechanism",
                "interval_coverage",
                "loss_resolution",
                "loss_slopes",
                "molybdenum_capture",
                "monte_carlo",
                "pairing_quality",
                "pile_up",
                "ptis_range",
                "restitution_fits",
                "rolling_dissipation",
                "smooth_spore",
                "speed_and_angle",
                "spin_needed",
                "spin_or_tilt",
                "spore_comparison",
                "spore_trends",
                "surface_pairs",
            )
        },
    output:
        claim_numbers="<results>/tables/claim_numbers.csv",
    log:
        "<results>/logs/claim_numbers.log",
        benchmark="<results>/benchmarks/claim_numbers.tsv",
    params:
        branch=SETTINGS.branches["claim_numbers"],
        rows=ROWS["claim_numbers"],
        code=study_code("claim_numbers"),
    script:
        "../scripts/run_study.py"
