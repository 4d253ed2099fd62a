"""The checked configuration, the names of results and the stamp of a run, for all rules.

Makes no file by itself. A configuration, declared table or registry with problems ends the run
here, with one line per problem, before anything is written.
"""

import atexit
import gc
import os
import sys
import time
import traceback
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger

# All that is read and built here is kept: a collector that looks through all of it again and again, and
# once more at the end, takes a quarter of a start.
gc.set_threshold(1_000_000)
atexit.register(gc.freeze)

# The working directory may be another one, as where this workflow is a module of some other.
if not workflow.current_basedir.is_local:
    raise WorkflowError("the package is run from its sources: clone the project, and name its file")
PROJECT = Path(workflow.current_basedir).parents[1]
SCRIPTS = PROJECT / "workflow/scripts"

# A project that was copied or cloned uses its own package, here and in its jobs.
sys.path[:0] = [str(PROJECT / "src"), str(SCRIPTS)]
os.environ.update(
    PYTHONPATH=os.pathsep.join(filter(None, [str(PROJECT / "src"), os.environ.get("PYTHONPATH")])),
    # Jobs run beside each other; more threads in each would only wait for one another.
    OPENBLAS_NUM_THREADS="1",
)

import closure
import digests
from digests import Digested

from study import analyses
from study.judge.criteria import declared_claims
from study.report import explorer, site
from study.report.site import record as site_record
from study.declared.documents import filled, load
from study.figures.declaration import FORMATS as ALL_FORMATS, all_figures
from study.declared.references import merged
from study.run.changed import changed_inputs, of_other_impacts
from study.run.config import FILES, read_configuration, read_inputs, validate
from study.run import stamp
from study.run.summary import summary

STARTED, BEGAN = stamp.run_date(), time.time()
CONFIGURATION = Path("config/config.yaml")
RESULTS = Path(workflow.pathvars.apply("<results>"))

try:
    SHIPPED = read_configuration(PROJECT / CONFIGURATION.parent)
    if not CONFIGURATION.exists():
        SHIPPED |= {key: str(PROJECT / SHIPPED[key]) for key in FILES}
    for path in workflow.overwrite_configfiles:
        load(path)  # stricter than the engine, which lets a repeated key pass
    base = read_configuration(CONFIGURATION.parent) if CONFIGURATION.exists() else SHIPPED
    config |= merged(base, config)
    SETTINGS = validate(config, SHIPPED)
    stamp.require_own_root(config, base)
    CHANGED = changed_inputs(SETTINGS, validate(SHIPPED, SHIPPED)) if config != SHIPPED else {}
    INPUTS = read_inputs(SETTINGS, of_other_impacts(CHANGED))
    if workflow.is_main_process:  # not in every job
        logger.info(f"Results go to {RESULTS}", extra={"results": RESULTS})
        if Path(workflow.basedir).is_relative_to(PROJECT):  # a module writes beside other results
            stamp.require_results_folder(RESULTS)
        declared_claims(SETTINGS.branches["claim_numbers"])
except (ValueError, OSError) as error:
    raise WorkflowError(f"problems in the declared inputs:\n{error}") from None
except (ImportError, SyntaxError) as error:
    line = traceback.extract_tb(error.__traceback__)[-1]
    raise WorkflowError(
        f"an analysis cannot be imported:\n{line.filename}, line {line.lineno}: {error}"
    ) from None

FIGURES, DIGITISED = INPUTS.figures, INPUTS.digitised
# Of the pictures of a figure, beside its SVG.
DRAWN = SETTINGS.general.figures
FORMATS = sorted({*DRAWN.formats} - {"svg"}, reverse=True)


def tables(*names):
    """Return tables as named files of a rule."""
    return {name: f"<results>/tables/{name}.csv" for name in names}


def data(*names):
    """Return tables of figure data as named files of a rule."""
    return {name: f"<results>/data/{name}.csv" for name in names}


def sample_files(node):
    """Return the files of measured values that a branch of the configuration draws from."""
    if isinstance(node, dict):
        files = [node["path"]] if node.get("kind") == "sample_file" else []
        return files + sample_files(list(node.values()))
    return [path for item in node for path in sample_files(item)] if isinstance(node, list) else []


def parameters(analysis):
    """Return the parameters of an analysis' rule, a change of which runs it again.

    Its branch of the configuration, and the rows of declared tables that the branch names; whether
    they, and those of the analyses behind it, are as shipped; its code, and the versions below.
    """
    return {
        "analysis": analysis,
        "branch": Digested(SETTINGS.branches[analysis]),
        "rows": Digested(SETTINGS.rows[analysis]),
        "is_shipped": not CHANGED.get(analysis),
        **code(analyses.homes()[analysis], script="run_analysis.py"),
    }


def code(*modules, script, files=()):
    """Return the code that a rule runs, with texts that it reads, and versions of packages.

    Parameters, whatever the dates of the files: of inputs, some forty files a job, the engine would
    ask for the state whenever a job has ended.
    """
    sources = closure.source_files(*modules, scripts=[SCRIPTS / script, SCRIPTS / "digests.py"])
    return {"code": digests.of_files(PROJECT, sources, files), "versions": digests.versions()}


def result_rules():
    """Return the rules that make results; not those of a workflow that uses this one as a module."""
    named = (each for each in workflow.rules if each.output and not each.wildcard_names)
    return [each for each in named if Path(each.snakefile).is_relative_to(PROJECT)]


def results(*folders):
    """Return the files that all rules make, or those in some folders of the results."""
    # Bare paths: a report flag on an input of `all` would hide that of the figure's own rule.
    paths = [str(path) for each in result_rules() for path in each.output]
    return [path for path in paths if not folders or relative(path).startswith(folders)]


def relative(path):
    """Return the name of a file in the results folder."""
    return Path(path).relative_to(RESULTS).as_posix()


def begin_run():
    """Write the stamp of this run, and remove a report of results that are about to be made anew.

    Before a result is made, lest a killed run leave figures beside the stamp of an earlier one.
    """
    steps = [job for job in workflow.dag.needrun_jobs() if job.log]
    if not workflow.touch and any(job.output for job in steps):
        site.remove(RESULTS / "report")
        remove_pictures()
    drawings = sum(job.rule.name.endswith("_figures") for job in steps)
    logger.info(f"{len(steps)} steps", extra={"steps": (len(steps), drawings)})
    write_stamp()


def remove_pictures():
    """Remove pictures of figures, or in formats, that are no longer wanted; files of others stay."""
    wanted = {Path(path).name for path in results("figures/")}
    made = (f"{name}.{kind}" for name in all_figures() for kind in ("csv", *ALL_FORMATS))
    for name in {*made} - wanted:
        (RESULTS / "figures" / name).unlink(missing_ok=True)


def write_stamp(ended=None):
    """Write the stamp of this run."""
    stamp.write_stamp(
        RESULTS / stamp.STAMP,
        config,
        PROJECT,
        STARTED,
        ended=ended,
        files=stamp.checksums({key: getattr(SETTINGS.general, key) for key in FILES}),
    )


def end_run():
    """Write the stamp of a run that went well, and say what it has made."""
    write_stamp(ended=stamp.run_date())
    made = [path for path in map(Path, results()) if path.is_file()]
    made = [relative(path) for path in made if path.stat().st_mtime >= BEGAN]
    logger.info(summary(RESULTS, made), extra={"summary": True})
