"""Virtual experiments: data of Figs. 4 to 12, their tables."""


rule normal_experiments:
    """data/fig04.csv, data/fig05.csv: normal impacts seen by the PDPA; tables of the same."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        fig04="<results>/data/fig04.csv",
        fig05="<results>/data/fig05.csv",
        normal_experiments="<results>/tables/normal_experiments.csv",
        size_effects="<results>/tables/size_effects.csv",
    log:
        "<results>/logs/normal_experiments.log",
        benchmark="<results>/benchmarks/normal_experiments.tsv",
    params:
        branch=SETTINGS.branches["normal_experiments"],
        rows=ROWS["normal_experiments"],
        code=study_code("normal_experiments"),
    script:
        "../scripts/run_study.py"


rule oblique_experiments:
    """data/fig06.csv to fig12.csv: oblique impacts seen by the PTIS; table of the experiments."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        **{f"fig{n:02d}": f"<results>/data/fig{n:02d}.csv" for n in range(6, 13)},
        fig23_points="<results>/data/fig23_points.csv",
        oblique_experiments="<results>/tables/oblique_experiments.csv",
    log:
        "<results>/logs/oblique_experiments.log",
        benchmark="<results>/benchmarks/oblique_experiments.tsv",
    params:
        branch=SETTINGS.branches["oblique_experiments"],
        rows=ROWS["oblique_experiments"],
        code=study_code("oblique_experiments"),
    script:
        "../scripts/run_study.py"
