"""The rule that all studies use; each says what it takes and what it makes."""


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
