"""Restitution against diffrax: an embedded Runge-Kutta method, compiled by JAX."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("diffrax", reason="diffrax is not installed; make test-peers runs this")

from benchmarks.cases import as_contact, judge, make_cases
from benchmarks.traced import Tsit5

from microimpact.model.dynamics.normal import normal_impact


def test_restitution_and_verdicts() -> None:
    cases = make_cases(60)
    own = normal_impact(*as_contact(cases))
    errors = judge(Tsit5(cases, 1e-12)(), own.coefficient_of_restitution)
    assert errors.wrong == 0
    assert errors.largest < 1e-9
    assert 0 < np.count_nonzero(own.captured) < len(cases)
