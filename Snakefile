"""Regenerate the figures and tables of a study of microparticle impact from declared inputs.

snakemake                                         everything, into results/
snakemake fig17                                   one figure and what it needs
snakemake fig17 --configfile config/examples/high-friction.yaml
snakemake --configfile config/ci.yaml             everything, small, into build/ci/

One way for the data: config branch -> analysis -> results/data, results/tables -> figure.
"""

from snakemake.utils import min_version

min_version("9.12")


report: "workflow/report/overview.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/analyses.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"


digests.keep()


rule all:
    """Every file that any rule makes."""
    default_target: True
    input:
        lambda wildcards: results(),


onstart:
    begin_run()


onsuccess:
    end_run()


onerror:
    write_stamp()
