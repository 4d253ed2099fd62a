"""The report, report/index.html, and the pages it leads to; the check against references."""

REPORT = PROJECT / "src/study/report"
# The report has copies of code.
SHOWN_SOURCES = closure.source_files(
    *analyses.homes().values(),
    "study.equations",
    *{figure.draw.__module__ for figure in FIGURES.values()},
)
PAGES = [*REPORT.glob("*/templates/*"), *REPORT.glob("*/assets/*")]


rule explorer:
    """report/explorer.html: any impact computed in a browser; its look comes with the report."""
    input:
        **tables("calibration"),
    output:
        [f"<results>/report/explorer/{name}" for name in explorer.FILES],
        page="<results>/report/explorer.html",
    log:
        "<results>/logs/explorer.log",
    benchmark:
        "<results>/benchmarks/explorer.tsv"
    params:
        **code("study.report.explorer.build", script="write_explorer.py", files=PAGES),
        rows=Digested(SETTINGS.tables.whole(("materials", "contacts"))),
    script:
        "../scripts/write_explorer.py"


rule report:
    """report/index.html and all pages it leads to: figures, ledgers, tables, run."""
    input:
        lambda wildcards: results("tables/", "data/", "figures/"),
        # The pages link to it.
        explorer="<results>/report/explorer.html",
    output:
        [f"<results>/report/{name}.html" for name in site.PAGES],
        [directory(f"<results>/report/{name}") for name in (*site.FOLDERS, "assets")],
        record="<results>/report/record.json",
    log:
        "<results>/logs/report.log",
    benchmark:
        "<results>/benchmarks/report.tsv"
    params:
        **code(*analyses.homes().values(), script="write_report.py", files=[*PAGES, *SHOWN_SOURCES]),
        record=lambda wildcards: Digested(
            site_record.record_of(
                config=config,
                shipped=SHIPPED,
                impact=filled(
                    "[[case.particle]] of [[diameter_um:g]] µm on [[case.surface]] at [[speed_m_per_s:g]] m/s",
                    SETTINGS.branches["fig18_21_oblique_impact"],
                    "report",
                    SETTINGS.pairs,
                ),
                figures={name: figure.entry() for name, figure in FIGURES.items()},
                rows=SETTINGS.rows,
                project=PROJECT,
            ).plain()
        ),
    script:
        "../scripts/write_report.py"


# Not part of `all`: a check of a finished run against the committed references.
rule check:
    """No file; fails, and shows the differences, if any table or figure differs."""
    input:
        lambda wildcards: results(),
    log:
        "<results>/logs/check.log",
    params:
        results=RESULTS,
        reference=PROJECT / "tests/reference",
    shell:
        "python -m study.report.commands check {params.results:q} --reference {params.reference:q}"
        " 2>&1 | tee {log:q}"
