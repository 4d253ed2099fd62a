"""Digitised points dropped into the folder `digitized` of the configuration, and what is computed."""


rule digitised_comparison:
    """tables/digitised_residuals.csv: digitised points against the series of their panels."""
    input:
        **{
            table: f"<results>/data/{table}.csv"
            for figure in DIGITIZED
            for table in FIGURES[figure].data
        },
    output:
        digitised_residuals="<results>/tables/digitised_residuals.csv",
    log:
        "<results>/logs/digitised_comparison.log",
        benchmark="<results>/benchmarks/digitised_comparison.tsv",
    params:
        branch=SETTINGS.branches["digitised_comparison"],
        rows=digitised_rows(*DIGITIZED),
        code=study_code("digitised_comparison"),
    script:
        "../scripts/run_study.py"
