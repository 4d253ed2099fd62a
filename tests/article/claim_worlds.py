"""What tests of the numbers behind claims share: worlds that breaks change, and what must hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import pytest
from tests.article.conftest import ROOT

from microimpact.ledgers.claims import NUMBER_COLUMNS, verdicts

STEEL = ("steel-silicon, n = 0", "steel-silicon, n = 1")


def merged(base, changes):
    """Return a mapping with changes, key by key at every depth."""
    both = dict(base)
    for key, value in changes.items():
        deeper = isinstance(value, Mapping) and isinstance(base.get(key), Mapping)
        both[key] = merged(base[key], value) if deeper else value
    return both


def to(new):
    return lambda _: new


nothing = to(0.0)


def by(factor):
    return lambda old: old * factor


@dataclass
class ClaimWorld:
    """All that a break may change before the numbers of its claim are computed again."""

    study: ClassVar[str]

    run_study: Any
    settings: Any
    tables: dict[str, pd.DataFrame]
    patch: pytest.MonkeyPatch

    def numbers(self, claim, tables=None, /, **changes):
        """Run the study for one claim, with changes of its branch at any depth."""
        branch = {**self.settings.branches[self.study], "claims": [claim]}
        given = {**self.tables, **(tables or {})}
        return self.run_study(self.study, given, **merged(branch, changes))[self.study]

    def calibration(self, cases=STEEL, **changes):
        """Return the calibrated cases with parameters changed; functions of the old value."""
        table = self.tables["calibration"].copy()
        for case in cases:
            for quantity, change in changes.items():
                own = (table["case"] == case) & (table["role"] == "parameter")
                here = own & (table["quantity"] == quantity)
                if not here.any():
                    row = table[own].iloc[[0]].assign(quantity=quantity, value=np.nan)
                    table = pd.concat([table, row], ignore_index=True)
                    here = (table["case"] == case) & (table["quantity"] == quantity)
                table.loc[here, "value"] = table.loc[here, "value"].map(change)
        return {"calibration": table}

    def inputs(self, tables=None):
        """Return all declared materials and the tables, or some changed."""
        materials = pd.read_csv(ROOT / self.settings.general.materials)
        return {**self.tables, "materials": materials, **(tables or {})}


def changed(claim, world, **changes):
    return world.numbers(claim, **changes)


def verdict_of(claims, name, numbers):
    found = verdicts({name: claims[name]}, numbers[numbers["claim"] == name])
    return found["verdict"].iloc[0]


def require_complete(claims, numbers, wanted):
    """Every number is there in its unit, and called calibrated where agreement proves nothing."""
    assert list(numbers.columns) == list(NUMBER_COLUMNS)
    # verdicts refuses a number that is missing, not finite, twice there or of another unit
    verdicts({name: claims[name] for name in wanted}, numbers)
    for name, evidence in numbers.groupby("claim")["evidence"]:
        assert (set(evidence) == {"calibrated"}) == (claims[name].positive == "calibrated")


def require_changed_verdict(claims, name, numbers, broken):
    """A break brings the verdict that it should, which was not there without it."""
    expected = claims[name].break_.expect
    assert verdict_of(claims, name, numbers) != expected
    assert verdict_of(claims, name, broken) == expected


def require_code(numbers):
    """Every number names the function, of that claim, that computed it."""
    for name, code in zip(numbers["claim"], numbers["code"], strict=True):
        module, _, function = code.rpartition(".")
        assert module.startswith("microimpact.studies.claims.")
        assert function == name.lower()
