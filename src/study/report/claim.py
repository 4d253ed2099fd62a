"""One claim in words: its statement, criterion, numbers and their source."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from microimpact.core.nearest import nearest
from study import analyses
from study.analyses.claim_numbers import Params, draws_of, numbers_of
from study.claims.claim import CLAIMS, Claim
from study.claims.context import Common
from study.declared.parameters import build
from study.judge import amendments, verdicts, words
from study.judge.changed import Changed, with_inputs
from study.judge.criteria import declared_claims
from study.judge.independent import independent
from study.judge.shares import shares
from study.report.check.results import ResultsError
from study.report.site.pages import render
from study.report.site.record import read_record
from study.run.changed import changed_inputs
from study.run.study import Made, settings_as_shipped
from study.tables import Row, parse_table, read_table

STUDY = "claim_numbers"
# Tables that hold contacts.
CONTACTS = ("calibration", "calibration_family", "posterior_contacts")
UNCHANGED: Mapping[Any, Any] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A claim judged by itself."""

    claim: Claim  # Words filled in
    numbers: pd.DataFrame  # As in the table ``claim_numbers``
    ledger: pd.Series  # Its row of the table ``claims``, without a mark of changed inputs
    changed: Changed  # Inputs of the studies that are not as shipped
    results: list[Row]  # Its rows of ``claim_results``


def judged(
    name: str,
    changes: Mapping[str, Any] = UNCHANGED,
    folder: Path | None = None,
    contacts: Callable[[pd.DataFrame], pd.DataFrame] | None = None,
) -> Judged:
    """Compute and judge one claim, with the studies that it needs; nothing is written.

    Parameters
    ----------
    name
        Such as ``C58``.
    changes
        Declared values in place of the shipped ones, at every depth.
    folder
        Results of the shipped configuration, from which tables are taken; without one, all are
        computed.
    contacts
        Makes other contacts of the tables `CONTACTS`.

    Raises
    ------
    ValueError
        If a key is unknown or a value not allowed.
    """
    made = Made(STUDY, changes, folder)
    branch = made.settings.branches[STUDY]
    claim = declared_claims(branch)[name]
    if folder and not changes and not contacts:
        tables = (read_table(folder / f"tables/{table}.csv") for table in (STUDY, "claim_draws"))
        numbers, draws = (table[table["claim"] == name] for table in tables)
    else:
        if contacts:
            made.update({table: contacts(made[table]) for table in CONTACTS})
        numbers, draws = _computed(claim, build(Params, branch), made)
    drawn = shares({name: claim}, draws, made["posterior_contacts"]) if len(draws) else {}
    ledger, results = verdicts({name: claim}, numbers, drawn)
    inputs = changed_inputs(made.settings, settings_as_shipped()) if changes else {}
    return Judged(
        claim=claim, numbers=numbers, ledger=ledger.iloc[0], changed=inputs, results=results
    )


def tell(name: str, changes: Mapping[str, Any], results: Path) -> str:
    """Return a claim in words, its numbers from a run or computed now.

    Parameters
    ----------
    name
        Such as ``C58``.
    changes
        Declared values to be changed, at every depth; the claim alone is then computed.
    results
        Results folder. Tables are taken from it if it holds a run of the shipped configuration.

    Raises
    ------
    ValueError
        If there is no such claim or key, or a value is not allowed.
    """
    claims = declared_claims()
    if name not in claims:
        raise ValueError(f"{name!r} is no claim{nearest(name, claims)}")
    if not claims[name].testable:
        return _page(claims[name], {"verdict": "not testable"}, evidence=[])
    folder = results if _shipped(results) else None
    claim = judged(name, changes, folder)
    facts = folder / "tables/external_evidence.csv" if folder else None
    evidence = independent({name: claim.claim}, read_table(facts)) if facts else pd.DataFrame()
    where = ""
    if function := CLAIMS[name].function:
        where = f"{inspect.getsourcefile(function)}:{inspect.getsourcelines(function)[1]}"
    makers = analyses.needs(STUDY)
    source = str(folder or "computed now")
    if changes:
        source = f"computed now{f'; what rests on no change from {folder}' if folder else ''}"
    settings = yaml.safe_dump(dict(changes), default_flow_style=True).strip() if changes else ""
    row = with_inputs(claim.ledger, claim.changed)
    return _page(
        claim.claim,
        {key: value for key, value in row.items() if value != "" and pd.notna(value)},
        results=claim.results,
        evidence=evidence.to_dict("records"),
        problems=[each for each in dict.fromkeys(claim.numbers["problem"].dropna()) if each],
        code=f"{row['code']}, {where}",
        inputs=[f"{n} (of {makers[n]})" if n in makers else n for n in row["inputs"].split()],
        changes=settings,
        source=source,
    )


def _page(claim: Claim, row: Mapping[Any, Any], **facts: Any) -> str:
    page = render(
        "claim.txt.jinja",
        templates=Path(__file__).parent,
        claim=claim,
        amendments=[row for row in amendments() if row["id"] == claim.id],
        row=row,
        words=words,
        **facts,
    )
    return page.rstrip()


def changed(settings: Sequence[str]) -> dict[str, Any]:
    """Return the changes that texts like ``claim_numbers.steel.friction=0.3`` mean.

    Raises ValueError if a text is none of that form.
    """
    changes: dict[str, Any] = {}
    for text in settings:
        key, sign, value = text.partition("=")
        if not sign or not all(key.split(".")):
            raise ValueError(f"--set: {text!r} must be of the form key=value")
        *above, last = key.split(".")
        branch = changes
        for step in above:
            branch = branch.setdefault(step, {})
        try:
            branch[last] = yaml.safe_load(value)
        except yaml.YAMLError:
            raise ValueError(f"--set: {value!r} is no value that YAML knows") from None
    return changes


def _shipped(results: Path) -> bool:
    """Tell whether a folder holds a run of the shipped configuration."""
    try:
        whole = (results / "tables/claims.csv").is_file()
        return whole and not read_record(results).changes
    except ResultsError:
        return False


def _computed(claim: Claim, params: Common, made: Made) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the numbers of a claim, and those for drawn contacts if it has some."""
    rows = made.settings.rows[STUDY]
    made.update({key: parse_table(text) for key, text in rows.items()})
    numbers = numbers_of(claim.id, params, made)
    drawn = CLAIMS[claim.id].by_contact
    return numbers, draws_of(params, made, claim.id) if drawn else pd.DataFrame()
