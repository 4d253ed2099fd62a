"""Numbers behind the claims that the models of impact decide."""


rule model_claims:
    """tables/model_claims.csv: per claim, case and quantity the number that decides it."""
    input:
        calibration="<results>/tables/calibration.csv",
        molybdenum_capture="<results>/tables/molybdenum_capture.csv",
        force_ratios="<results>/tables/force_ratios.csv",
        rolling_dissipation="<results>/tables/rolling_dissipation.csv",
        restitution_fits="<results>/tables/restitution_fits.csv",
    output:
        model_claims="<results>/tables/model_claims.csv",
    log:
        "<results>/logs/model_claims.log",
        benchmark="<results>/benchmarks/model_claims.tsv",
    params:
        branch=SETTINGS.branches["model_claims"],
        rows=ROWS["model_claims"],
        code=study_code("model_claims"),
    script:
        "../scripts/run_study.py"
