"""The explorer: tables for any impact, and the page that computes with them in a browser."""


rule explorer_tables:
    """data/explorer_*.csv: tables of any normal impact, their errors, and declared contacts."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        **{name: f"<results>/data/{name}.csv" for name in EXPLORER_TABLES},
    log:
        "<results>/logs/explorer_tables.log",
        benchmark="<results>/benchmarks/explorer_tables.tsv",
    params:
        branch=SETTINGS.branches["explorer_tables"],
        rows=DECLARED.contact_rows(),
        code=study_code("explorer_tables"),
    script:
        "../scripts/run_study.py"


rule explorer:
    """report/explorer.html: any impact computed in a browser; its look comes with the report."""
    input:
        **{name: f"<results>/data/{name}.csv" for name in EXPLORER_TABLES},
    output:
        [f"<results>/report/explorer/{name}" for name in explorer.FILES],
        page="<results>/report/explorer.html",
    log:
        "<results>/logs/explorer.log",
        benchmark="<results>/benchmarks/explorer.tsv",
    params:
        largest_damping=SETTINGS.branches["explorer_tables"]["largest_damping"],
        code=explorer_code(),
    script:
        "../scripts/write_explorer.py"
