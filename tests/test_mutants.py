"""The list of wrong forms keeps pace with the code; `make mutants` lets the tests find them."""

from __future__ import annotations

import pytest
from tests.mutants import MUTANTS
from tests.shared import ROOT


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_the_right_form_is_there_once_and_its_tests_exist(mutant):
    text = (ROOT / "src" / mutant.path).read_text(encoding="utf-8")
    assert mutant.apply(text) != text
    assert len(mutant.modules) == len(mutant.tests.split())
