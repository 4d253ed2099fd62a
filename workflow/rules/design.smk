"""Designed experiments and global sensitivity: data of Figs. 24 and 25, and of Sobol' indices."""


rule doe:
    """data/fig24.csv, data/fig25.csv: effects drawn; tables/doe_*.csv: designs and their analysis."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        doe_levels="<results>/tables/doe_levels.csv",
        doe_design="<results>/tables/doe_design.csv",
        doe_aliases="<results>/tables/doe_aliases.csv",
        doe_effects="<results>/tables/doe_effects.csv",
        doe_bd_aliasing="<results>/tables/doe_bd_aliasing.csv",
        doe_elasticities="<results>/tables/doe_elasticities.csv",
        fig24="<results>/data/fig24.csv",
        fig25="<results>/data/fig25.csv",
    log:
        "<results>/logs/doe.log",
        benchmark="<results>/benchmarks/doe.tsv",
    params:
        branch=SETTINGS.branches["doe"],
        rows=ROWS["doe"],
        code=study_code("doe"),
    script:
        "../scripts/run_study.py"


rule sensitivity:
    """data/sobol.csv: indices drawn; tables/sensitivity_*.csv: indices, groups, convergence."""
    input:
        calibration="<results>/tables/calibration.csv",
        doe_levels="<results>/tables/doe_levels.csv",
        doe_effects="<results>/tables/doe_effects.csv",
    output:
        sensitivity_indices="<results>/tables/sensitivity_indices.csv",
        sensitivity_convergence="<results>/tables/sensitivity_convergence.csv",
        sensitivity_groups="<results>/tables/sensitivity_groups.csv",
        sensitivity_parameters="<results>/tables/sensitivity_parameters.csv",
        sobol="<results>/data/sobol.csv",
    log:
        "<results>/logs/sensitivity.log",
        benchmark="<results>/benchmarks/sensitivity.tsv",
    params:
        branch=SETTINGS.branches["sensitivity"],
        rows=ROWS["sensitivity"],
        code=study_code("sensitivity"),
    script:
        "../scripts/run_study.py"
