"""How well Eq. 34 finds the capture velocity: tables of the statistical study, data of its figure."""


rule fit_coverage:
    """data/capture_recovery.csv; tables/fit_coverage.csv, fit_intervals.csv and fit_coverage_statements.csv."""
    input:
        code=study_code("fit_coverage"),
        calibration="<results>/tables/calibration.csv",
        restitution_fits="<results>/tables/restitution_fits.csv",
    output:
        fit_coverage="<results>/tables/fit_coverage.csv",
        fit_intervals="<results>/tables/fit_intervals.csv",
        fit_coverage_statements="<results>/tables/fit_coverage_statements.csv",
        capture_recovery="<results>/data/capture_recovery.csv",
    log:
        "<results>/logs/fit_coverage.log",
    benchmark:
        "<results>/benchmarks/fit_coverage.tsv"
    params:
        branch=lookup(dpath="fit_coverage", within=SETTINGS.branches),
        rows=ROWS["fit_coverage"],
    script:
        "../scripts/run_study.py"
