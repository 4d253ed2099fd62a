"""What all rules share: the checked configuration, declared rows, and source files.

Makes no file. A configuration, declared table or registry with problems ends the run here,
with one line per problem, before anything is written.
"""

import copy
import os
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import update_config

# workflow/Snakefile includes the one of the project.
PROJECT = Path(workflow.basedir)
PROJECT = PROJECT.parent if PROJECT.name == "workflow" else PROJECT


wildcard_constraints:
    chunk=r"\d+-of-\d+",


# A project that was copied or cloned uses its own package, here and in its jobs.
sys.path.insert(0, str(PROJECT / "src"))
os.environ.update(
    PYTHONPATH=os.pathsep.join(filter(None, [str(PROJECT / "src"), os.environ.get("PYTHONPATH")])),
    # Jobs run beside each other; more threads in each would only wait for one another.
    OPENBLAS_NUM_THREADS="1",
)

from microimpact import studies
from microimpact.run import closure
from microimpact.run import digitised as digitized
from microimpact.run import prefork
from microimpact.run.config import load
from microimpact.run.inputs import read_inputs
from microimpact.run.remembered import validated
from microimpact.run.stamp import run_date, write_stamp

STARTED = run_date()
CONFIGURATION = Path("config/config.yaml")
RUN_STUDY = PROJECT / "workflow/scripts/run_study.py"
DRAW_FIGURE = PROJECT / "workflow/scripts/draw_figure.py"
JUDGE_LEDGER = PROJECT / "workflow/scripts/judge_ledger.py"

try:
    SHIPPED = load(PROJECT / CONFIGURATION)
    own = CONFIGURATION.exists() and not CONFIGURATION.samefile(PROJECT / CONFIGURATION)
    for path in workflow.overwrite_configfiles:
        load(path)  # stricter than the engine, which lets a repeated key pass
    # The engine's own reader (`configfile:`) takes ten times as long for the same values.
    overlay = copy.deepcopy(config)
    update_config(config, load(CONFIGURATION) if own else copy.deepcopy(SHIPPED))
    update_config(config, overlay)
    SETTINGS = validated(config, SHIPPED, Path(".snakemake/validated.json"))
    INPUTS = read_inputs(SETTINGS)
    DECLARED, ROWS, DIGITIZED = INPUTS.tables, INPUTS.rows, INPUTS.digitized
    FIGURES, FIGURE_ENTRIES = INPUTS.figures, INPUTS.figure_entries
except (ValueError, OSError) as error:
    raise WorkflowError(f"problems in the declared inputs:\n{error}") from None


# Code comes as a parameter and not as input, since the engine asks for the state of all inputs of
# all waiting jobs, some forty files of code each, whenever a job has ended.
def digest(files):
    """Return a word that changes with the content or the names of files, but not with their dates."""
    return closure.digest(files, PROJECT)


def study_code(study):
    """Return a digest of the files that decide what a study computes."""
    return digest(closure.source_files(studies.homes()[study], scripts=[RUN_STUDY]))


def chunk_files(study):
    """Return the files of the parts that a heavy study is split into."""
    count = SETTINGS.general.chunks
    return [f"<results>/chunks/{study}-{n}-of-{count}.json" for n in range(1, count + 1)]


def figure_code(name):
    """Return a digest of the files that decide how a figure is drawn."""
    return digest(closure.source_files(FIGURES[name].module, scripts=[DRAW_FIGURE]))


def ledger_code(ledger):
    """Return a digest of the files that decide what a ledger says."""
    return digest(closure.source_files(f"microimpact.ledgers.{ledger}", scripts=[JUDGE_LEDGER]))


def digitised_file(name):
    """Return the file of digitised points of a figure as a named input, if there is one."""
    return {"digitised": DIGITIZED[name].path} if name in DIGITIZED else {}


def digitised_rows(*figures):
    """Return the digitised points of figures as declared rows of a study."""
    return digitized.as_rows(DIGITIZED, figures)


def sample_files(node):
    """Return the files of measured values that a branch draws from."""
    if isinstance(node, list):
        return [path for item in node for path in sample_files(item)]
    if not isinstance(node, dict):
        return []
    own = [node["path"]] if node.get("kind") == "sample_file" else []
    return own + sample_files(list(node.values()))


def everything():
    """Return every output of every rule that makes files without wildcards."""
    # Bare paths: a report flag on an input of `all` would hide that of the figure's own rule.
    return [str(path) for rule in workflow.rules if not rule.wildcard_names for path in rule.output]
