"""Regenerate the figures and tables of a study of microparticle impact from declared inputs.

snakemake                                         everything, into results/
snakemake fig17                                   one figure and what it rests on
snakemake fig17 --configfile config/examples/high-friction.yaml
snakemake --configfile config/ci.yaml             everything, small, into build/ci/

One way for the data: config branch -> study -> results/data, results/tables -> figure.
"""

from snakemake.utils import min_version

min_version("9.12")


report: "workflow/report/overview.rst"


# Read with --software-deployment-method apptainer only; the rules run in the present environment.
container: "docker://python:3.11-slim-bookworm"


include: "workflow/rules/common.smk"
include: "workflow/rules/inputs.smk"
include: "workflow/rules/models.smk"
include: "workflow/rules/impact.smk"
include: "workflow/rules/estimation.smk"
include: "workflow/rules/capture.smk"
include: "workflow/rules/coverage.smk"
include: "workflow/rules/design.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/roughness.smk"
include: "workflow/rules/laboratory.smk"
include: "workflow/rules/mechanisms.smk"
include: "workflow/rules/schematics.smk"
include: "workflow/rules/monte_carlo.smk"
include: "workflow/rules/separation.smk"
include: "workflow/rules/digitised.smk"
include: "workflow/rules/ledgers.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/campaign.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/pages.smk"
include: "workflow/rules/explorer.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/check.smk"


rule all:
    """Every file that any rule makes."""
    default_target: True
    input:
        lambda wildcards: everything(),


onstart:
    if workflow.local_exec:
        prefork.start()
        # Meant for submissions: it wakes the scheduler once a second for each job that has ended.
        workflow.scheduler.job_rate_limiter = None


onsuccess:
    write_stamp(workflow.pathvars.apply("<results>/run.json"), config, PROJECT, STARTED)
