"""Dynamic simulation: data of Figs. 18, 20 and 21; tables of contacts and of single numbers."""


rule contact_properties:
    """tables/contact_properties.csv: stiffness, mass, forces and capture of every contact."""
    output:
        contact_properties="<results>/tables/contact_properties.csv",
    log:
        "<results>/logs/contact_properties.log",
        benchmark="<results>/benchmarks/contact_properties.tsv",
    params:
        branch=SETTINGS.branches["contact_properties"],
        rows=DECLARED.contact_rows(),
        code=study_code("contact_properties"),
    script:
        "../scripts/run_study.py"


rule oblique_impact:
    """data/fig18.csv: impulse ratio, data/fig21.csv: energy loss."""
    output:
        fig18="<results>/data/fig18.csv",
        fig21="<results>/data/fig21.csv",
    log:
        "<results>/logs/oblique_impact.log",
        benchmark="<results>/benchmarks/oblique_impact.tsv",
    params:
        branch=SETTINGS.branches["oblique_impact"],
        rows=ROWS["oblique_impact"],
        code=study_code("oblique_impact"),
    script:
        "../scripts/run_study.py"


rule force_history:
    """data/fig20.csv: normal force and its terms (Eq. 25), tables/force_ratios.csv: its peaks."""
    output:
        fig20="<results>/data/fig20.csv",
        force_ratios="<results>/tables/force_ratios.csv",
    log:
        "<results>/logs/force_history.log",
        benchmark="<results>/benchmarks/force_history.tsv",
    params:
        branch=SETTINGS.branches["force_history"],
        rows=ROWS["force_history"],
        code=study_code("force_history"),
    script:
        "../scripts/run_study.py"
