"""The report: results/report/index.html and the pages it leads to, of all tables and figures."""


# The pages of single figures and the copies of results stand beside these. They are not listed:
# Snakemake keeps all parameters of a job once more for each of its outputs.
rule report:
    """report/index.html and all pages it leads to: figures, ledgers, tables, workflow, run."""
    input:
        [f"<results>/{file}" for file in shown_files()],
        # The pages link to it.
        explorer="<results>/report/explorer.html",
    output:
        [f"<results>/report/{name}.html" for name in site.PAGES],
        record="<results>/report/record.json",
    log:
        "<results>/logs/report.log",
        benchmark="<results>/benchmarks/report.tsv",
    params:
        record=lambda wildcards: site_record.record_of(
            config=config,
            shipped=SHIPPED,
            figures=registry_words(),
            rules=result_rules(),
            project=PROJECT,
        ).plain(),
        code=report_code(),
    script:
        "../scripts/write_report.py"
