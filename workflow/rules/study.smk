"""The rule that all studies use; each says what it takes and what it makes.

A study of many draws may be made in parts, by jobs of their own, and gathered by its own rule.
"""


wildcard_constraints:
    chunk=r"\d+-of-\d+",


rule study:
    """No file: the script, log and costs of all studies."""
    log:
        "<results>/logs/<study>.log",
    benchmark:
        "<results>/benchmarks/<study>.tsv"
    pathvars:
        study="study",
    script:
        "../scripts/run_study.py"


rule study_part:
    """chunks/*.json: one part of a study, until all are gathered."""
    output:
        temp("<results>/chunks/<study>-{chunk}.json"),
    log:
        "<results>/logs/<study>-{chunk}.log",
    benchmark:
        "<results>/benchmarks/<study>-{chunk}.tsv"
    pathvars:
        study="study",
    script:
        "../scripts/run_study.py"
