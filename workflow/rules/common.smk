"""What all rules share: the checked configuration, names of results, and the rule of all studies.

Makes no file. A configuration, declared table or registry with problems ends the run here,
with one line per problem, before anything is written.
"""

import atexit
import gc
import json
import os
import sys
import time
import traceback
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger

# What is read and built here is kept: a collector that looks through all of it again and again, and
# once more at the end, takes a quarter of a start.
gc.set_threshold(1_000_000)
atexit.register(gc.freeze)

# The working directory may be another one, as where this workflow is a module of some other.
if not workflow.current_basedir.is_local:
    raise WorkflowError("the package is run from its sources: clone the project, and name its file")
PROJECT = Path(workflow.current_basedir).parents[1]
SCRIPTS = PROJECT / "workflow/scripts"


wildcard_constraints:
    chunk=r"\d+-of-\d+",


# A project that was copied or cloned uses its own package, here and in its jobs.
sys.path[:0] = [str(PROJECT / "src"), str(SCRIPTS)]
os.environ.update(
    PYTHONPATH=os.pathsep.join(filter(None, [str(PROJECT / "src"), os.environ.get("PYTHONPATH")])),
    # Jobs run beside each other; more threads in each would only wait for one another.
    OPENBLAS_NUM_THREADS="1",
)

import closure

from microimpact import studies
from microimpact.core.files import of_other_inputs, recorded_since, write_checksums
from microimpact.core.tables import write_table
from microimpact.figures.registry import FORMATS
from microimpact.ledgers.claims.criteria import read_claims
from microimpact.report import explorer, site
from microimpact.report.site import record as site_record
from microimpact.declared.documents import load, located
from microimpact.declared.references import merged
from microimpact.run.config import FILES, read_configuration, read_inputs, validate
from microimpact.run import stamp
from microimpact.run.study import run_with
from microimpact.run.summary import summary

STARTED, BEGAN = stamp.run_date(), time.time()
CONFIGURATION = Path("config/config.yaml")
# A module writes beside the results of others.
IS_MODULE = not Path(workflow.basedir).is_relative_to(PROJECT)

try:
    SHIPPED = read_configuration(PROJECT / CONFIGURATION.parent)
    own = CONFIGURATION.exists() and not CONFIGURATION.samefile(PROJECT / CONFIGURATION)
    if not CONFIGURATION.exists():
        SHIPPED |= {key: str(PROJECT / SHIPPED[key]) for key in FILES}
    for path in workflow.overwrite_configfiles:
        load(path)  # stricter than the engine, which lets a repeated key pass
    base = read_configuration(CONFIGURATION.parent) if own else SHIPPED
    config |= merged(base, config)
    SETTINGS = validate(config, SHIPPED)
    stamp.require_own_root(config, base)
    INPUTS = read_inputs(SETTINGS)
    if workflow.is_main_process:  # not in every job
        if not IS_MODULE:
            stamp.require_results_folder(stamp.results_root(config))
        with located(SETTINGS.general.claims):
            read_claims(SETTINGS.general.claims, SETTINGS.branches["claim_numbers"])
except (ValueError, OSError) as error:
    raise WorkflowError(f"problems in the declared inputs:\n{error}") from None
except (ImportError, SyntaxError) as error:
    place = traceback.extract_tb(error.__traceback__)[-1]
    raise WorkflowError(
        f"an analysis cannot be imported:\n{place.filename}, line {place.lineno}: {error}"
    ) from None

RESULTS = Path(workflow.pathvars.apply("<results>"))
INPUT_TABLE = "tables/inputs.csv"
FIGURES, FIGURE_ENTRIES, DIGITISED = INPUTS.figures, INPUTS.figure_entries, INPUTS.digitised


def tables(*names):
    """Return tables as named files of a rule."""
    return {name: f"<results>/tables/{name}.csv" for name in names}


def data(*names):
    """Return tables of figure data as named files of a rule."""
    return {name: f"<results>/data/{name}.csv" for name in names}


def needs(study):
    """Return the tables of earlier studies that a study says it needs."""
    return tables(*studies.needs(study))


def parts(study):
    """Return the parts that a study is gathered from; in one part it is run at once."""
    count = SETTINGS.general.chunks
    numbers = range(1, count + 1) if count > 1 else ()
    return [f"<results>/chunks/{study}-{n}-of-{count}.json" for n in numbers]


def sample_files(study):
    """Return the files of measured values that a study draws from."""
    return list(_sample_files(SETTINGS.branches[study]))


def _sample_files(node):
    if isinstance(node, dict):
        if node.get("kind") == "sample_file":
            yield node["path"]
        node = list(node.values())
    if isinstance(node, list):
        for item in node:
            yield from _sample_files(item)


def of(study):
    """Return the parameters of a study's rule: its branch, the declared rows it names, its code."""
    return {
        "branch": SETTINGS.branches[study],
        "rows": INPUTS.rows[study],
        "rests_on": inputs_behind(study),
        "code": code_of(studies.homes()[study], script="run_study.py"),
    }


# Results bear this word, so that those made from other inputs than the present ones can be told.
@cache
def inputs_behind(*names):
    """Return a word that changes with any declared input that studies or figures rest on."""
    told = []
    for name in names:
        if name in FIGURES:
            told += [FIGURE_ENTRIES[name], inputs_behind(FIGURES[name].study)]
            told += [Path(DIGITISED[name].path).read_text()] if name in DIGITISED else []
        else:
            told += [SETTINGS.branches[name], INPUTS.rows[name]]
            told += [Path(path).read_text() for path in sample_files(name)]
            told += [inputs_behind(maker) for maker in sorted({*studies.needs(name).values()})]
    return closure.word(json.dumps(told))


# Code comes as a parameter and not as input, since the engine asks for the state of all inputs of
# all waiting jobs, some forty files of code each, whenever a job has ended.
def code_of(*modules, script, files=()):
    """Return a word that changes with the code of modules and a script, but not with its dates."""
    sources = closure.source_files(*modules, scripts=[SCRIPTS / script])
    return closure.digest([*sources, *files], PROJECT)


def own_rules():
    """Return the rules that make files without wildcards; not those of an including workflow."""
    named = (each for each in workflow.rules if each.output and not each.wildcard_names)
    return [each for each in named if Path(each.snakefile).is_relative_to(PROJECT)]


def everything():
    """Return every output of every rule that makes files without wildcards."""
    # Bare paths: a report flag on an input of `all` would hide that of the figure's own rule.
    return [str(path) for rule in own_rules() for path in rule.output]


def result_rules():
    """Return what makes tables and figures as the report tells them."""
    found = [
        site_record.Rule(
            name=rule.name,
            purpose=" ".join((rule.docstring or "").split()),
            inputs=tuple(filter(is_shown, map(relative, rule.input))),
            outputs=tuple(map(relative, rule.output)),
            declared=site_record.row_names(dict(rule.params.items()).get("rows")),
        )
        for rule in own_rules()
        if all(map(is_shown, map(relative, rule.output))) and rule.name not in FIGURE_JOBS
    ]
    return found + [
        site_record.Rule(
            name=figure,
            inputs=tuple(f"data/{table}.csv" for table in spec.data),
            outputs=tuple(f"figures/{figure}.{kind}" for kind in FORMATS),
        )
        for figure, spec in FIGURES.items()
    ]


def relative(path):
    """Return the name of a file in the results folder."""
    return str(path).removeprefix(f"{RESULTS}/")


def is_shown(file):
    """Tell whether a result stands on a page."""
    return Path(file).parts[0] in ("tables", "data", "figures")


def outdated():
    """Return the results in the results folder that were made from other inputs than the present."""
    rests_on = {
        relative(path): word
        for rule in own_rules()
        for word in [dict(rule.params.items()).get("rests_on")]
        if word
        for path in rule.output
    }
    return of_other_inputs(RESULTS, rests_on)


def begin_run():
    """Let what stands in the results folder tell the inputs of this run before a result is made.

    So no target, no failure and no kill leaves a figure beside a stamp, a table of inputs or a
    report that tells other inputs than its own.
    """
    found = outdated()
    if found:
        site.remove(RESULTS / "report")
    if INPUT_TABLE in found:
        write_inputs()
    write_stamp(ended=None, outdated=found)


def end_run(ended):
    """Write the stamp again, and tell what was made; a target alone has its inputs beside it."""
    if not (RESULTS / INPUT_TABLE).exists():
        write_inputs()
    found = outdated()
    write_stamp(ended=ended, outdated=found)
    made = [file for file in map(relative, everything()) if recorded_since(RESULTS, file, BEGAN)]
    if ended:
        logger.info(summary(RESULTS, made, found), extra={"summary": True})


def write_inputs():
    """Write the table of declared inputs, as its rule does."""
    study, table = "declared_inputs", RESULTS / INPUT_TABLE
    made = run_with(study, SETTINGS.branches[study], INPUTS.rows[study], {})
    write_table(made["inputs"], table)
    write_checksums(RESULTS, [table], inputs_behind(study))


def write_stamp(**how):
    """Write the stamp of this run."""
    stamp.write_stamp(
        RESULTS / stamp.STAMP, config, PROJECT, STARTED, declared=SETTINGS.declared, **how
    )
