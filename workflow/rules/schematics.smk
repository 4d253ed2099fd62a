"""Schematic figures: what stands where, and the states that are drawn to scale."""


rule schematics:
    """data/fig01.csv ... fig22.csv: Figs. 1, 2, 3, 13, 19, 22; tables/schematic_values.csv."""
    output:
        fig01="<results>/data/fig01.csv",
        fig02="<results>/data/fig02.csv",
        fig03="<results>/data/fig03.csv",
        fig13="<results>/data/fig13.csv",
        fig19="<results>/data/fig19.csv",
        fig19_pressure="<results>/data/fig19_pressure.csv",
        fig19_ring="<results>/data/fig19_ring.csv",
        fig22="<results>/data/fig22.csv",
        schematic_values="<results>/tables/schematic_values.csv",
    log:
        "<results>/logs/schematics.log",
        benchmark="<results>/benchmarks/schematics.tsv",
    params:
        branch=SETTINGS.branches["schematics"],
        rows=ROWS["schematics"],
        code=study_code("schematics"),
    script:
        "../scripts/run_study.py"
