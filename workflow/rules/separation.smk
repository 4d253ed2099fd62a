"""Separation of a charged particle with silica on it: an analysis beyond the article."""


rule particle_separation:
    """data/separation.csv: forces against silica, tables/particle_separation.csv: what holds."""
    output:
        separation="<results>/data/separation.csv",
        particle_separation="<results>/tables/particle_separation.csv",
    log:
        "<results>/logs/particle_separation.log",
        benchmark="<results>/benchmarks/particle_separation.tsv",
    params:
        branch=SETTINGS.branches["particle_separation"],
        rows=ROWS["particle_separation"],
        code=study_code("particle_separation"),
    script:
        "../scripts/run_study.py"
