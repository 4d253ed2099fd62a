"""The campaign of virtual experiments, and what the intervals of their means hold."""


rule campaign:
    """tables/campaign.csv: all 187 experiments; campaign_summary.csv; data of campaign_map."""
    input:
        calibration="<results>/tables/calibration.csv",
        code=study_code("campaign"),
    output:
        campaign="<results>/tables/campaign.csv",
        campaign_summary="<results>/tables/campaign_summary.csv",
        campaign_map="<results>/data/campaign_map.csv",
    log:
        "<results>/logs/campaign.log",
    benchmark:
        "<results>/benchmarks/campaign.tsv"
    params:
        branch=lookup(dpath="campaign", within=SETTINGS.branches),
        rows=ROWS["campaign"],
    script:
        "../scripts/run_study.py"


rule interval_coverage:
    """tables/interval_coverage.csv: how often 95 % intervals hold either mean; figure data."""
    input:
        calibration="<results>/tables/calibration.csv",
        code=study_code("interval_coverage"),
    output:
        interval_coverage="<results>/tables/interval_coverage.csv",
        coverage_by_speed="<results>/data/coverage_by_speed.csv",
        coverage_by_angle="<results>/data/coverage_by_angle.csv",
    log:
        "<results>/logs/interval_coverage.log",
    benchmark:
        "<results>/benchmarks/interval_coverage.tsv"
    params:
        branch=lookup(dpath="interval_coverage", within=SETTINGS.branches),
        rows=ROWS["interval_coverage"],
    script:
        "../scripts/run_study.py"
