"""Slopes of rough surfaces, and couples of rolling: tables, and data of figures of our own."""


rule roughness_expansions:
    """tables/roughness_expansions.csv, roughness_ranges.csv: Eqs. 35-41; data/roughness.csv."""
    output:
        roughness_expansions="<results>/tables/roughness_expansions.csv",
        roughness_ranges="<results>/tables/roughness_ranges.csv",
        roughness="<results>/data/roughness.csv",
    log:
        "<results>/logs/roughness_expansions.log",
        benchmark="<results>/benchmarks/roughness_expansions.tsv",
    params:
        branch=SETTINGS.branches["roughness_expansions"],
        rows=ROWS["roughness_expansions"],
        code=study_code("roughness_expansions"),
    script:
        "../scripts/run_study.py"


rule rolling_dissipation:
    """tables/rolling_dissipation.csv, rolling_ranges.csv: neglected couples; data/rolling.csv."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        rolling_dissipation="<results>/tables/rolling_dissipation.csv",
        rolling_ranges="<results>/tables/rolling_ranges.csv",
        rolling="<results>/data/rolling.csv",
    log:
        "<results>/logs/rolling_dissipation.log",
        benchmark="<results>/benchmarks/rolling_dissipation.tsv",
    params:
        branch=SETTINGS.branches["rolling_dissipation"],
        rows=ROWS["rolling_dissipation"],
        code=study_code("rolling_dissipation"),
    script:
        "../scripts/run_study.py"


rule captured_rolling:
    """tables/roll_away.csv, data/roll_away_curves.csv: how far captured spheres roll."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        roll_away="<results>/tables/roll_away.csv",
        roll_away_curves="<results>/data/roll_away_curves.csv",
    log:
        "<results>/logs/captured_rolling.log",
        benchmark="<results>/benchmarks/captured_rolling.tsv",
    params:
        branch=SETTINGS.branches["captured_rolling"],
        rows=ROWS["captured_rolling"],
        code=study_code("captured_rolling"),
    script:
        "../scripts/run_study.py"
