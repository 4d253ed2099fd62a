"""The list of wrong forms keeps pace with the code; `make mutants` lets the tests find them."""

from __future__ import annotations

import pytest
from tests.mutation.mutants import MUTANTS
from tests.shared import ROOT


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_the_right_form_stands_there_once_and_its_tests_exist(mutant):
    text = (ROOT / mutant.path).read_text(encoding="utf-8")
    assert mutant.apply(text) != text
    assert bool(mutant.tests) != bool(mutant.table)
    for name in mutant.tests:
        assert (ROOT / f"tests/{name}.py").is_file()
    if mutant.table:
        assert (ROOT / f"tests/reference/tables/{mutant.table}.csv").is_file()


def test_names_tell_the_wrong_forms_apart():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) >= 25


def test_a_form_that_is_gone_is_told():
    with pytest.raises(ValueError, match="occurs 0 times in"):
        MUTANTS[0].apply("")
