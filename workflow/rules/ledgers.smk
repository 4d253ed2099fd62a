"""Ledgers: what is asserted about the article, and what came of it."""


rule equations:
    """tables/equations.csv: every equation as printed and as used, checked and judged."""
    input:
        code=ledger_code("equations"),
    output:
        equations="<results>/tables/equations.csv",
    log:
        "<results>/logs/equations.log",
    benchmark:
        "<results>/benchmarks/equations.tsv"
    params:
        rows=DECLARED.named_in({"particle": "stainless-steel-316", "surface": "silicon"}),
    script:
        "../scripts/judge_ledger.py"
