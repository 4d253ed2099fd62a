"""Estimation of parameters: tables of the calibrations and data of their figure."""


rule calibration:
    """tables/calibration.csv, calibration_family.csv and molybdenum_capture.csv; data/ridge*.csv."""
    input:
        code=study_code("calibration"),
    output:
        calibration="<results>/tables/calibration.csv",
        calibration_family="<results>/tables/calibration_family.csv",
        molybdenum_capture="<results>/tables/molybdenum_capture.csv",
        ridge="<results>/data/ridge.csv",
        ridge_curves="<results>/data/ridge_curves.csv",
    log:
        "<results>/logs/calibration.log",
    benchmark:
        "<results>/benchmarks/calibration.tsv"
    params:
        branch=lookup(dpath="calibration", within=SETTINGS.branches),
        rows=ROWS["calibration"],
    script:
        "../scripts/run_study.py"
