"""Ledgers: what is asserted about the article, and what came of it."""


rule equations:
    """tables/equations.csv: every equation as printed and as used, checked and judged."""
    output:
        equations=report(
            "<results>/tables/equations.csv",
            caption="../report/equations.rst",
            category="Ledgers",
            labels={"ledger": "equations"},
        ),
    log:
        "<results>/logs/equations.log",
        benchmark="<results>/benchmarks/equations.tsv",
    params:
        rows=DECLARED.named_in({"particle": "stainless-steel-316", "surface": "silicon"}),
        code=ledger_code("equations"),
    script:
        "../scripts/judge_ledger.py"


rule claims:
    """tables/claims.csv: every claim of the article, the numbers behind it and the verdict.

    Digitised points, if there are any, have rows after the claims.
    """
    input:
        claim_numbers="<results>/tables/claim_numbers.csv",
        digitised_residuals="<results>/tables/digitised_residuals.csv",
        criteria=SETTINGS.general.claims,
    output:
        claims=report(
            "<results>/tables/claims.csv",
            caption="../report/claims.rst",
            category="Ledgers",
            labels={"ledger": "claims"},
        ),
    log:
        "<results>/logs/claims.log",
        benchmark="<results>/benchmarks/claims.tsv",
    params:
        rows={},
        code=ledger_code("claims"),
    script:
        "../scripts/judge_ledger.py"
