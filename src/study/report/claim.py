"""One claim in words: its statement, criterion, numbers and their source."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from microimpact.core.materials import declared_file
from microimpact.core.nearest import nearest
from study import studies
from study.declared.parameters import build
from study.declared.references import merged
from study.ledgers.claims import verdicts, words
from study.ledgers.claims.changed import Changed, with_inputs
from study.ledgers.claims.criteria import Claim, ContactProperty, read_claims
from study.ledgers.claims.independent import independent
from study.ledgers.claims.shares import shares
from study.report.check.results import ResultsError
from study.report.site.pages import render
from study.report.site.record import read_record
from study.run.changed import changed_inputs
from study.run.config import study_rows
from study.run.study import Made, settings_as_shipped
from study.studies.claims.claim_numbers import CLAIMS, Params, draws_of, numbers_of
from study.studies.claims.claim_numbers.context import Common
from study.studies.contacts import DRAWN
from study.tables import Row, parse_table, read_table

STUDY = "claim_numbers"


# Columns of tables that hold properties of contacts, by property.
COLUMNS = {name: column for column, name in DRAWN.items()} | {"friction_basis": "friction_basis"}
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
    contacts: Mapping[ContactProperty, float | str] = UNCHANGED,
    folder: Path | None = None,
) -> Judged:
    """Compute and judge one claim, with the studies that it needs; nothing is written.

    Parameters
    ----------
    name
        Such as ``C58``.
    changes
        Declared values in place of the shipped ones, at every depth.
    contacts
        Factors on properties of all contacts that the claim's own numbers are computed with, or
        another basis of their friction.
    folder
        Results of the shipped configuration, from which tables are taken; without one, all are
        computed.

    Raises
    ------
    ValueError
        If a key is unknown or a value not allowed.
    """
    made = Made(STUDY, changes, folder)
    branch = made.settings.branches[STUDY]
    claim = read_claims(declared_file("claims.yaml"), branch)[name]
    if folder and not changes and not contacts:
        tables = (read_table(folder / f"tables/{table}.csv") for table in (STUDY, "claim_draws"))
        numbers, draws = (table[table["claim"] == name] for table in tables)
    else:
        if contacts:
            made.update({table: with_contacts(made[table], contacts) for table in CONTACTS})
        numbers, draws = _computed(claim, build(Params, branch), made)
    drawn = shares({name: claim}, draws, made["posterior_contacts"]) if len(draws) else {}
    ledger, results = verdicts({name: claim}, numbers, drawn)
    inputs = changed_inputs(made.settings, settings_as_shipped()) if changes else {}
    return Judged(
        claim=claim, numbers=numbers, ledger=ledger.iloc[0], changed=inputs, results=results
    )


def with_contacts(
    table: pd.DataFrame, changes: Mapping[ContactProperty, float | str]
) -> pd.DataFrame:
    """Multiply properties of the contacts of a table by factors, or replace their basis.

    Contacts by a law without the property are left out.
    """
    table = table.copy()
    for name, change in changes.items():
        column = COLUMNS[name]
        if column in table:
            table = table[table[column].notna()].copy()
            table[column] = change if isinstance(change, str) else table[column] * change
        elif "role" in table and not isinstance(change, str):
            rows = (table["role"] == "parameter") & (table["quantity"] == name)
            table.loc[rows, "value"] *= change
    return table


def tell(name: str, changes: Mapping[str, Any], results: Path, *, broken: bool = False) -> str:
    """Return a claim in words, its numbers from a run or computed now.

    Parameters
    ----------
    name
        Such as ``C58``.
    changes
        Declared values to be changed, at every depth; the claim alone is then computed.
    results
        Results folder. Tables are taken from it if it holds a run of the shipped configuration.
    broken
        Whether the change that must alter the verdict is made, too.

    Raises
    ------
    ValueError
        If there is no such claim or key, or a value is not allowed, or the change is not data.
    """
    claims = read_claims(declared_file("claims.yaml"))
    if name not in claims:
        raise ValueError(f"{name!r} is no claim{nearest(name, claims)}")
    control = claims[name].break_
    if not control:
        return _page(claims[name], {"verdict": claims[name].verdicts[0]}, evidence=[], broken=False)
    if broken and not control.is_data:
        raise ValueError(f"{name}: its break is a wrong form of the code: {control.change}")
    contacts = control.contacts if broken else UNCHANGED
    changes = merged(control.set, changes) if broken else changes
    folder = results if _shipped(results) else None
    claim = judged(name, changes, contacts, folder)
    facts = folder / "tables/external_evidence.csv" if folder else None
    evidence = independent({name: claim.claim}, read_table(facts)) if facts else pd.DataFrame()
    function = CLAIMS[name].function
    where = f"{inspect.getsourcefile(function)}:{inspect.getsourcelines(function)[1]}"
    makers = studies.needs(STUDY)
    source = str(folder or "computed now")
    if changes or contacts:
        source = f"computed now{f'; what rests on no change from {folder}' if folder else ''}"
    settings = yaml.safe_dump(dict(changes), default_flow_style=True).strip() if changes else ""
    row = with_inputs(claim.ledger, {} if broken else claim.changed)
    factors = f"contacts by {dict(contacts)}" if contacts else ""
    return _page(
        claim.claim,
        {key: value for key, value in row.items() if value != "" and pd.notna(value)},
        results=claim.results,
        evidence=evidence.to_dict("records"),
        problems=[each for each in dict.fromkeys(claim.numbers["problem"].dropna()) if each],
        code=f"{row['code']}, {where}",
        inputs=[f"{n} (of {makers[n]})" if n in makers else n for n in row["inputs"].split()],
        broken=broken,
        changes="; ".join(filter(None, (settings, factors))),
        source=source,
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
    rows = study_rows(STUDY, made.settings, {})
    made.update({key: parse_table(text) for key, text in rows.items()})
    numbers = numbers_of(claim.id, params, made)
    drawn = CLAIMS[claim.id].by_contact
    return numbers, draws_of(params, made, claim.id) if drawn else pd.DataFrame()
