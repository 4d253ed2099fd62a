"""Monte Carlo analysis of impacts on a rough surface (Section 4.2)."""


rule monte_carlo_part:
    """chunks/monte_carlo-*.json: what one part of the study gives, until all are gathered."""
    input:
        samples=sample_files(SETTINGS.branches["monte_carlo"]),
        calibration="<results>/tables/calibration.csv",
    output:
        temp("<results>/chunks/monte_carlo-{chunk}.json"),
    log:
        "<results>/logs/monte_carlo-{chunk}.log",
        benchmark="<results>/benchmarks/monte_carlo-{chunk}.tsv",
    params:
        branch=SETTINGS.branches["monte_carlo"],
        rows=ROWS["monte_carlo"],
        code=study_code("monte_carlo"),
    script:
        "../scripts/run_study.py"


rule monte_carlo:
    """data/fig23.csv; tables/monte_carlo*.csv and slope_inference.csv."""
    input:
        parts=chunk_files("monte_carlo"),
        samples=sample_files(SETTINGS.branches["monte_carlo"]),
        calibration="<results>/tables/calibration.csv",
    output:
        fig23="<results>/data/fig23.csv",
        monte_carlo="<results>/tables/monte_carlo.csv",
        monte_carlo_sampling="<results>/tables/monte_carlo_sampling.csv",
        monte_carlo_ablation="<results>/tables/monte_carlo_ablation.csv",
        slope_inference="<results>/tables/slope_inference.csv",
    log:
        "<results>/logs/monte_carlo.log",
        benchmark="<results>/benchmarks/monte_carlo.tsv",
    params:
        branch=SETTINGS.branches["monte_carlo"],
        rows=ROWS["monte_carlo"],
        code=study_code("monte_carlo"),
    script:
        "../scripts/run_study.py"
