"""The explorer: the page that integrates impacts in a browser."""


rule explorer:
    """report/explorer.html: any impact computed in a browser; its look comes with the report."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        [f"<results>/report/explorer/{name}" for name in explorer.FILES],
        page="<results>/report/explorer.html",
    log:
        "<results>/logs/explorer.log",
        benchmark="<results>/benchmarks/explorer.tsv",
    params:
        rows=DECLARED.contact_rows(),
        code=explorer_code(),
    script:
        "../scripts/write_explorer.py"
