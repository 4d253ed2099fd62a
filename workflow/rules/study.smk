"""What the rules of all studies have in common; each says what it needs and what it makes."""


rule study:
    """No file: what the rules of all studies have in common."""
    log:
        "<results>/logs/<name>.log",
    pathvars:
        name="study",
    script:
        "../scripts/run_study.py"


rule study_part:
    """chunks/*.json: what one part of a study gives, until all are gathered."""
    output:
        temp("<results>/chunks/<name>-{chunk}.json"),
    log:
        "<results>/logs/<name>-{chunk}.log",
    pathvars:
        name="study",
    script:
        "../scripts/run_study.py"
