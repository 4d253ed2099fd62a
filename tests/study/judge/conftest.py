"""One declared claim in place of all."""

from __future__ import annotations

import pytest
from tests.study.judge.test_claims import claim

from study.claims.claim import Number


@pytest.fixture
def one(monkeypatch):
    """The only declared claim, that a number is at least 0.5; it was amended."""
    only = claim(numbers={"e": Number(at_least=0.5)}, external=("falls",))
    amended = {"id": "C01", "part": "criteria", "was": "a", "now": "b", "reason": "c"}
    monkeypatch.setattr("study.judge.declared_claims", lambda values: {"C01": only})
    monkeypatch.setattr("study.judge.amendments", lambda: [amended])
