"""Check of a finished run against the committed references; not part of `all`."""


rule check:
    """No file; fails, and shows the differences, if any table or figure differs."""
    input:
        lambda wildcards: everything(),
    log:
        "<results>/logs/check.log",
    params:
        results=lambda wildcards: workflow.pathvars.apply("<results>"),
        reference=PROJECT / "tests/reference",
    shell:
        "python -m microimpact.cli check {params.results:q} --reference {params.reference:q}"
        " 2>&1 | tee {log:q}"
