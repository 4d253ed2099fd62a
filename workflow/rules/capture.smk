"""Capture velocity by competing laws: table of ratios, data of the figure over diameter."""


rule capture_velocities:
    """tables/capture_laws.csv: v_c per pair and law, data/capture_law_curves.csv: over diameter."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        capture_laws="<results>/tables/capture_laws.csv",
        capture_law_curves="<results>/data/capture_law_curves.csv",
    log:
        "<results>/logs/capture_velocities.log",
        benchmark="<results>/benchmarks/capture_velocities.tsv",
    params:
        branch=SETTINGS.branches["capture_velocities"],
        rows=ROWS["capture_velocities"],
        code=study_code("capture_velocities"),
    script:
        "../scripts/run_study.py"
