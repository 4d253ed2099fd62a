"""Numbers behind the claims on what was measured, and what the means are said to show."""


rule laboratory_claims:
    """tables/laboratory_claims.csv: per claim, case and quantity the number that decides it."""
    input:
        **{
            table: f"<results>/tables/{table}.csv"
            for table in (
                "calibration",
                "ptis_range",
                "pairing_quality",
                "interval_coverage",
                "pile_up",
                "spin_needed",
                "spin_or_tilt",
                "surface_pairs",
                "formica_mechanism",
                "spore_trends",
                "spore_comparison",
                "smooth_spore",
                "adhesion_or_roughness",
                "speed_and_angle",
                "loss_slopes",
                "loss_resolution",
            )
        },
    output:
        laboratory_claims="<results>/tables/laboratory_claims.csv",
    log:
        "<results>/logs/laboratory_claims.log",
        benchmark="<results>/benchmarks/laboratory_claims.tsv",
    params:
        branch=SETTINGS.branches["laboratory_claims"],
        rows=ROWS["laboratory_claims"],
        code=study_code("laboratory_claims"),
    script:
        "../scripts/run_study.py"
