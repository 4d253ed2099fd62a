"""One claim in words: what is stated, how it is judged, its numbers and where they come from."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from microimpact import studies
from microimpact.core.materials import declared_file
from microimpact.core.nearest import nearest
from microimpact.core.tables import parse_table, read_table
from microimpact.declared.parameters import build
from microimpact.ledgers.claims import verdicts, words
from microimpact.ledgers.claims.criteria import Claim, read_claims
from microimpact.ledgers.claims.independent import independent
from microimpact.ledgers.claims.shares import shares
from microimpact.report.check.results import ResultsError
from microimpact.report.site.pages import render
from microimpact.report.site.record import read_record
from microimpact.run.config import study_rows
from microimpact.run.study import Made
from microimpact.studies.claims.claim_numbers import CLAIMS, Params, numbers_of, part
from microimpact.studies.claims.claim_numbers.draws import COLUMNS as DRAW_COLUMNS

STUDY = "claim_numbers"


def tell(name: str, changes: Mapping[str, Any], results: Path) -> str:
    """Return a claim in words, its numbers from a run or computed anew.

    `name`: such as ``C58``; `changes`: declared values to be changed, at every depth; the claim
    alone is then computed anew, with the studies that it needs, and nothing is written; `results`:
    results folder. Tables are taken from it if it holds a run of the shipped configuration. Raises
    ValueError if there is no such claim or key, or a value is not allowed.
    """
    file = declared_file("claims.yaml")
    claims = read_claims(file)
    if name not in claims:
        raise ValueError(f"{name!r} is no claim{nearest(name, claims)}")
    claim = claims[name]
    if not claim.testable:
        return _page(claim, {"verdict": claim.verdicts[0]}, evidence=[])
    folder = results if _shipped(results) else None
    made = Made(STUDY, changes, folder)
    branch = made.settings.branches[STUDY]
    claim = read_claims(file, branch)[name]
    if folder and not changes:
        numbers, draws = (
            read_table(folder / f"tables/{table}.csv").query("claim == @name")
            for table in (STUDY, "claim_draws")
        )
    else:
        numbers, draws = _computed(claim, build(Params, branch), made)
    drawn = shares({name: claim}, draws, made["admissible_contacts"]) if len(draws) else {}
    ledger, rows = verdicts({name: claim}, numbers, drawn)
    facts = folder / "tables/external_evidence.csv" if folder else None
    evidence = independent({name: claim}, read_table(facts)).to_dict("records") if facts else []
    function = CLAIMS[name].of
    where = f"{inspect.getsourcefile(function)}:{inspect.getsourcelines(function)[1]}"
    makers = studies.needs(STUDY)
    read = sorted({name for text in numbers["inputs"].dropna() for name in text.split()})
    anew = "computed anew" if changes else "computed now"
    rest = f"{anew}; what rests on no change from {folder}" if changes else str(folder)
    return _page(
        claim,
        {key: value for key, value in ledger.iloc[0].dropna().items() if value != ""},
        results=rows,
        evidence=evidence,
        problems=[each for each in dict.fromkeys(numbers["problem"].dropna()) if each],
        code=f"{function.__module__}.{function.__qualname__}, {where}",
        inputs=[f"{name} (of {makers[name]})" if name in makers else name for name in read],
        changes=changes and yaml.safe_dump(dict(changes), default_flow_style=True).strip(),
        source=rest if folder else anew,
    )


def _page(claim: Claim, row: Mapping[Any, Any], **facts: Any) -> str:
    page = render(
        "claim.txt.jinja",
        templates=Path(__file__).parent,
        claim=claim,
        amendments=[asdict(amendment) for amendment in claim.amendments],
        row=row,
        words=words,
        **facts,
    )
    return page.rstrip()


def changed(settings: Sequence[str]) -> dict[str, Any]:
    """Return the changes that texts like ``claim_numbers.steel.friction=0.3`` mean.

    Raises ValueError if a text is none of that form.
    """
    found: dict[str, Any] = {}
    for text in settings:
        key, sign, value = text.partition("=")
        if not sign or not all(key.split(".")):
            raise ValueError(f"--set: {text!r} must be of the form key=value")
        *above, last = key.split(".")
        place = found
        for step in above:
            place = place.setdefault(step, {})
        try:
            place[last] = yaml.safe_load(value)
        except yaml.YAMLError:
            raise ValueError(f"--set: {value!r} is no value that YAML knows") from None
    return found


def _shipped(results: Path) -> bool:
    """Tell whether a folder holds a run of the shipped configuration."""
    try:
        whole = (results / "tables/claims.csv").is_file()
        return whole and not read_record(results).changes
    except ResultsError:
        return False


def _computed(claim: Claim, params: Params, made: Made) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the numbers of a claim, and those for admissible contacts if it has some."""
    rows = study_rows(STUDY, made.settings, {})
    made.update({key: parse_table(text) for key, text in rows.items()})
    numbers = numbers_of(claim.id, params, made)
    own = tuple(name for name in params.draws.claims if name == claim.id)
    alone = replace(params, draws=replace(params.draws, claims=own))
    draws = [row for _, rows in part(alone, made, 0, 1) for row in rows] if own else []
    return numbers, pd.DataFrame(draws, columns=list(DRAW_COLUMNS))
