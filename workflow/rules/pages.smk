"""What the pages share: the results they show, and the files that decide them.

Makes no file.
"""

from microimpact.report import explorer, site
from microimpact.report.site import record as site_record

WRITE_REPORT = PROJECT / "workflow/scripts/write_report.py"
SITE = PROJECT / "src/microimpact/report/site"
SHOWN = ("tables", "data", "figures")
WRITE_EXPLORER = PROJECT / "workflow/scripts/write_explorer.py"
EXPLORER = PROJECT / "src/microimpact/report/explorer"
FRAME = PROJECT / "src/microimpact/report/site/templates/base.html"


def shown_files():
    """Return all results that stand on a page, relative to the results folder."""
    return [file for made in result_rules() for file in made.outputs]


def result_rules():
    """Return what makes tables and figures as the report tells them."""
    found = []
    for each in workflow.rules:
        outputs = [_relative_result(path) for path in each.output]
        if outputs and all(file.split("/")[0] in SHOWN for file in outputs):
            inputs = [_relative_result(path) for path in each.input]
            found.append(
                site_record.Rule(
                    name=each.name,
                    purpose=" ".join((each.docstring or "").split()),
                    inputs=tuple(file for file in inputs if file.split("/")[0] in SHOWN),
                    outputs=tuple(outputs),
                    declared=site_record.row_names(dict(each.params.items()).get("rows")),
                )
            )
    return found


def _relative_result(path):
    return workflow.pathvars.apply(str(path)).removeprefix(workflow.pathvars.apply("<results>/"))


def report_code():
    """Return a digest of what decides what the pages say: the code of the studies is read, too."""
    modules = studies.homes().values()
    files = closure.source_files(*modules, scripts=[WRITE_REPORT])
    folders = [SITE / "templates", SITE / "assets"]
    return digest([*files, *(path for folder in folders for path in sorted(folder.iterdir()))])


def registry_words():
    """Return of each figure what the report tells: not how its panels are drawn."""
    told = ("title", "caption", "article", "study", "data", "tables")
    return {
        name: {key: entry[key] for key in told if key in entry}
        for name, entry in FIGURE_ENTRIES.items()
    }


def explorer_code():
    """Return a digest of the files that decide what the explorer's page is."""
    files = closure.source_files("microimpact.report.explorer.build", scripts=[WRITE_EXPLORER])
    folders = [EXPLORER / "templates", EXPLORER / "assets"]
    parts = [path for folder in folders for path in sorted(folder.iterdir())]
    return digest([*files, *parts, FRAME])
