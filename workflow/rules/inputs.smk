"""Declared inputs: results/tables/inputs.csv."""


rule declared_inputs:
    """tables/inputs.csv: every declared number with unit, evidence class and source."""
    output:
        inputs="<results>/tables/inputs.csv",
    log:
        "<results>/logs/declared_inputs.log",
        benchmark="<results>/benchmarks/declared_inputs.tsv",
    params:
        branch=SETTINGS.branches["declared_inputs"],
        rows=DECLARED.everything(SETTINGS.declared),
        code=study_code("declared_inputs"),
    script:
        "../scripts/run_study.py"
