"""Estimation of parameters: tables of the calibrations and data of their figure."""


rule calibration:
    """tables/calibration.csv, calibration_family.csv and molybdenum_capture.csv; data/ridge*.csv."""
    output:
        calibration="<results>/tables/calibration.csv",
        calibration_family="<results>/tables/calibration_family.csv",
        molybdenum_capture="<results>/tables/molybdenum_capture.csv",
        ridge="<results>/data/ridge.csv",
        ridge_curves="<results>/data/ridge_curves.csv",
    log:
        "<results>/logs/calibration.log",
        benchmark="<results>/benchmarks/calibration.tsv",
    params:
        branch=SETTINGS.branches["calibration"],
        rows=ROWS["calibration"],
        code=study_code("calibration"),
    script:
        "../scripts/run_study.py"


rule restitution_fits:
    """data/fig15.csv, data/fig16.csv: simulated e and its fits; tables/restitution_fits.csv."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        fig15="<results>/data/fig15.csv",
        fig16="<results>/data/fig16.csv",
        restitution_fits="<results>/tables/restitution_fits.csv",
    log:
        "<results>/logs/restitution_fits.log",
        benchmark="<results>/benchmarks/restitution_fits.tsv",
    params:
        branch=SETTINGS.branches["restitution_fits"],
        rows=ROWS["restitution_fits"] | digitised_rows("fig15", "fig16"),
        code=study_code("restitution_fits"),
    script:
        "../scripts/run_study.py"
