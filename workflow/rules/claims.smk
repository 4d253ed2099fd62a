"""The ledgers of claims and equations, with their numbers and verdicts."""


rule claim_numbers:
    """tables/claim_numbers.csv: the numbers that decide the claims."""
    input:
        # Each claim names those it takes.
        **tables(
            *(name for name in analyses.needs("claim_numbers") if name != "posterior_contacts")
        ),
    output:
        **tables("claim_numbers"),
    log:
        "<results>/logs/claim_numbers.log",
    benchmark:
        "<results>/benchmarks/claim_numbers.tsv"
    params:
        **parameters("claim_numbers"),
        function="numbers",
    script:
        "../scripts/run_analysis.py"


rule claim_draws:
    """tables/claim_draws.csv: numbers of claims for every contact that the printed statements admit."""
    input:
        **tables(*analyses.needs("claim_numbers", *analyses.analysis("claim_numbers").DRAWS_NEED)),
    output:
        **tables("claim_draws"),
    log:
        "<results>/logs/claim_draws.log",
    benchmark:
        "<results>/benchmarks/claim_draws.tsv"
    params:
        **parameters("claim_numbers"),
        function="drawn",
    script:
        "../scripts/run_analysis.py"


rule claims:
    """tables/claims.csv: every claim of the article, the numbers behind it and the verdict.

    tables/claim_results.csv: every number of a claim, its bounds, and whether it lies within them;
    tables/claim_shares.csv: contacts that meet a claim, by scenario, law and alternative;
    tables/claim_evidence.csv: facts found by others, for which contacts they agree with the model;
    tables/claim_amendments.csv: what of a claim was changed after first judging, and why.
    """
    input:
        **tables("claim_numbers", "claim_draws", "posterior_contacts"),
        **tables("external_evidence"),
    output:
        **tables("claim_results", "claim_shares", "claim_evidence", "claim_amendments"),
        claims=report(
            "<results>/tables/claims.csv",
            caption="../report/claims.rst",
            category="Ledgers",
            labels={"ledger": "claims"},
        ),
    log:
        "<results>/logs/claims.log",
    benchmark:
        "<results>/benchmarks/claims.tsv"
    params:
        **code("study.judge", script="judge_ledger.py", files=[PROJECT / "config/amendments.csv"]),
        ledger="claims",
        module="study.judge",
        rows={},
        branch=Digested(SETTINGS.branches["claim_numbers"]),
        changed=Digested(
            {
                name: CHANGED[name]
                for name in sorted({"claim_numbers", *analyses.needs("claim_numbers").values()})
                if CHANGED
            }
        ),
    script:
        "../scripts/judge_ledger.py"


rule equations:
    """tables/equations.csv: every equation as printed and as used, judged.

    tables/errata.csv: slips of the article's text outside its equations.
    """
    output:
        equations=report(
            "<results>/tables/equations.csv",
            caption="../report/equations.rst",
            category="Ledgers",
            labels={"ledger": "equations"},
        ),
        errata="<results>/tables/errata.csv",
    log:
        "<results>/logs/equations.log",
    benchmark:
        "<results>/benchmarks/equations.tsv"
    params:
        **code(
            "study.equations",
            script="judge_ledger.py",
            files=[PROJECT / "config/equations.yaml"],
        ),
        ledger="equations",
        module="study.equations",
        rows=Digested(SETTINGS.tables.of_pair("stainless-steel-316", "silicon")),
    script:
        "../scripts/judge_ledger.py"
