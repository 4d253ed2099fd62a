"""The campaign of virtual experiments, and what the intervals of their means hold."""


rule campaign_part:
    """chunks/campaign-*.json: what one part of the study gives, until all are gathered."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        temp("<results>/chunks/campaign-{chunk}.json"),
    log:
        "<results>/logs/campaign-{chunk}.log",
        benchmark="<results>/benchmarks/campaign-{chunk}.tsv",
    params:
        branch=SETTINGS.branches["campaign"],
        rows=ROWS["campaign"],
        code=study_code("campaign"),
    script:
        "../scripts/run_study.py"


rule campaign:
    """tables/campaign.csv: all 187 experiments; campaign_summary.csv; data of campaign_map."""
    input:
        parts=chunk_files("campaign"),
        calibration="<results>/tables/calibration.csv",
    output:
        campaign="<results>/tables/campaign.csv",
        campaign_summary="<results>/tables/campaign_summary.csv",
        campaign_map="<results>/data/campaign_map.csv",
    log:
        "<results>/logs/campaign.log",
        benchmark="<results>/benchmarks/campaign.tsv",
    params:
        branch=SETTINGS.branches["campaign"],
        rows=ROWS["campaign"],
        code=study_code("campaign"),
    script:
        "../scripts/run_study.py"


rule interval_coverage_part:
    """chunks/interval_coverage-*.json: what one part of the study gives, until all are gathered."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        temp("<results>/chunks/interval_coverage-{chunk}.json"),
    log:
        "<results>/logs/interval_coverage-{chunk}.log",
        benchmark="<results>/benchmarks/interval_coverage-{chunk}.tsv",
    params:
        branch=SETTINGS.branches["interval_coverage"],
        rows=ROWS["interval_coverage"],
        code=study_code("interval_coverage"),
    script:
        "../scripts/run_study.py"


rule interval_coverage:
    """tables/interval_coverage.csv: how often 95 % intervals hold either mean; figure data."""
    input:
        parts=chunk_files("interval_coverage"),
        calibration="<results>/tables/calibration.csv",
    output:
        interval_coverage="<results>/tables/interval_coverage.csv",
        coverage_by_speed="<results>/data/coverage_by_speed.csv",
        coverage_by_angle="<results>/data/coverage_by_angle.csv",
    log:
        "<results>/logs/interval_coverage.log",
        benchmark="<results>/benchmarks/interval_coverage.tsv",
    params:
        branch=SETTINGS.branches["interval_coverage"],
        rows=ROWS["interval_coverage"],
        code=study_code("interval_coverage"),
    script:
        "../scripts/run_study.py"
