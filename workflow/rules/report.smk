"""The report: results/report/index.html and the pages it leads to, of all tables and figures."""

from microimpact.report.site import build as site
from microimpact.report.site import record as site_record

WRITE_REPORT = PROJECT / "workflow/scripts/write_report.py"
SITE = PROJECT / "src/microimpact/report/site"
SHOWN = ("tables", "data", "figures")


def shown_files():
    """Return all results that stand on a page, relative to the results folder."""
    return [file for rule in result_rules() for file in rule.outputs]


def result_rules():
    """Return the rules that make tables and figures as the report tells them."""
    found = []
    for rule in workflow.rules:
        outputs = [_relative_result(path) for path in rule.output]
        if outputs and all(file.split("/")[0] in SHOWN for file in outputs):
            inputs = [_relative_result(path) for path in rule.input]
            found.append(
                site_record.Rule(
                    name=rule.name,
                    purpose=" ".join((rule.docstring or "").split()),
                    inputs=tuple(file for file in inputs if file.split("/")[0] in SHOWN),
                    outputs=tuple(outputs),
                    declared=site_record.row_names(dict(rule.params.items()).get("rows")),
                )
            )
    return found


def _relative_result(path):
    return workflow.pathvars.apply(str(path)).removeprefix(workflow.pathvars.apply("<results>/"))


def report_code():
    """Return the files that decide what the pages say: the code of the studies is read, too."""
    modules = [f"microimpact.studies.{study}" for study in SETTINGS.branches]
    files = closure.source_files(*modules, scripts=[WRITE_REPORT])
    folders = [SITE / "templates", SITE / "assets"]
    return _relative([*files, *(path for folder in folders for path in sorted(folder.iterdir()))])


def registry_words():
    """Return of each figure what the report tells: not how its panels are drawn."""
    told = ("title", "caption", "article", "study", "data")
    return {
        name: {key: entry[key] for key in told if key in entry}
        for name, entry in FIGURE_ENTRIES.items()
    }


# The pages of single figures and the copies of results stand beside these. They are not listed:
# Snakemake keeps all parameters of a job once more for each of its outputs.
rule report:
    """report/index.html and all pages it leads to: figures, ledgers, tables, workflow, run."""
    input:
        [f"<results>/{file}" for file in shown_files()],
        # The pages link to it.
        explorer="<results>/report/explorer.html",
        code=report_code(),
    output:
        [f"<results>/report/{name}.html" for name in site.PAGES],
        record="<results>/report/record.json",
    log:
        "<results>/logs/report.log",
    benchmark:
        "<results>/benchmarks/report.tsv"
    params:
        record=lambda wildcards: site_record.record_of(
            config=config,
            shipped=SHIPPED,
            figures=registry_words(),
            rules=result_rules(),
            project=PROJECT,
        ).plain(),
    script:
        "../scripts/write_report.py"
