"""Numbers behind the claims on roughness, Monte Carlo, designed experiments and estimation."""


rule analysis_claims:
    """tables/analysis_claims.csv: one number per claim, case and quantity, for the ledger."""
    input:
        calibration="<results>/tables/calibration.csv",
        calibration_family="<results>/tables/calibration_family.csv",
        doe_effects="<results>/tables/doe_effects.csv",
        monte_carlo="<results>/tables/monte_carlo.csv",
    output:
        analysis_claims="<results>/tables/analysis_claims.csv",
    log:
        "<results>/logs/analysis_claims.log",
        benchmark="<results>/benchmarks/analysis_claims.tsv",
    params:
        branch=SETTINGS.branches["analysis_claims"],
        rows=ROWS["analysis_claims"],
        code=study_code("analysis_claims"),
    script:
        "../scripts/run_study.py"
