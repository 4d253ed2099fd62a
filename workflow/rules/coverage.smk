"""How well Eq. 34 finds the capture velocity: tables of the statistical study, data of its figure."""


rule fit_coverage_part:
    """chunks/fit_coverage-*.json: what one part of the study gives, until all are gathered."""
    input:
        calibration="<results>/tables/calibration.csv",
        restitution_fits="<results>/tables/restitution_fits.csv",
    output:
        temp("<results>/chunks/fit_coverage-{chunk}.json"),
    log:
        "<results>/logs/fit_coverage-{chunk}.log",
        benchmark="<results>/benchmarks/fit_coverage-{chunk}.tsv",
    params:
        branch=SETTINGS.branches["fit_coverage"],
        rows=ROWS["fit_coverage"],
        code=study_code("fit_coverage"),
    script:
        "../scripts/run_study.py"


rule fit_coverage:
    """data/capture_recovery.csv; tables/fit_coverage.csv and fit_intervals.csv."""
    input:
        parts=chunk_files("fit_coverage"),
        calibration="<results>/tables/calibration.csv",
        restitution_fits="<results>/tables/restitution_fits.csv",
    output:
        fit_coverage="<results>/tables/fit_coverage.csv",
        fit_intervals="<results>/tables/fit_intervals.csv",
        capture_recovery="<results>/data/capture_recovery.csv",
    log:
        "<results>/logs/fit_coverage.log",
        benchmark="<results>/benchmarks/fit_coverage.tsv",
    params:
        branch=SETTINGS.branches["fit_coverage"],
        rows=ROWS["fit_coverage"],
        code=study_code("fit_coverage"),
    script:
        "../scripts/run_study.py"
