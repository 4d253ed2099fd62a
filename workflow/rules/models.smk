"""Models: data of Figs. 14 and 17 in results/data.

One rule per analysis, of the name of its study and of its branch in the configuration.
"""


rule restitution_trends:
    """data/fig14.csv: R, rho and e against the impact speed (Eqs. 32-34)."""
    output:
        fig14="<results>/data/fig14.csv",
    log:
        "<results>/logs/restitution_trends.log",
        benchmark="<results>/benchmarks/restitution_trends.tsv",
    params:
        branch=SETTINGS.branches["restitution_trends"],
        rows=ROWS["restitution_trends"],
        code=study_code("restitution_trends"),
    script:
        "../scripts/run_study.py"


rule coulomb_friction:
    """data/fig17.csv: impulse ratio against angle for Coulomb friction (Eqs. 1-12)."""
    output:
        fig17="<results>/data/fig17.csv",
    log:
        "<results>/logs/coulomb_friction.log",
        benchmark="<results>/benchmarks/coulomb_friction.tsv",
    params:
        branch=SETTINGS.branches["coulomb_friction"],
        rows=ROWS["coulomb_friction"],
        code=study_code("coulomb_friction"),
    script:
        "../scripts/run_study.py"
