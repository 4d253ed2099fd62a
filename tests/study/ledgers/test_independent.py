"""Facts found by others, beside the claims that name them."""

import pandas as pd
import pytest
from tests.study.ledgers.test_claims import claim

from study.ledgers.claims.criteria import ClaimsError
from study.ledgers.claims.independent import AGREES, DISAGREES, SPLIT, agreements, independent
from study.ledgers.claims.words import agreement as in_words

TABLE = pd.DataFrame(
    [
        ("falls with size", "a", AGREES),
        ("falls with size", "b", DISAGREES),
        ("no target", "a", AGREES),
        ("half is lost", "b", DISAGREES),
        ("never computed", "b", "not computed"),
    ],
    columns=["fact", "contact", "agreement"],
)


@pytest.mark.parametrize(
    ("facts", "agreement", "words"),
    [
        (["no target"], AGREES, ["no target: yes for a"]),
        (["half is lost"], DISAGREES, ["half is lost: no for b"]),
        (["falls with size"], SPLIT, ["falls with size: yes for a; no for b"]),
        (["never computed"], None, []),
        ([], None, []),
    ],
)
def test_what_independent_data_say(facts, agreement, words):
    evidence = independent({"C01": claim(external=facts)}, TABLE)
    assert agreements(evidence).get("C01") == agreement
    assert list(map(in_words, evidence.to_dict("records"))) == words


def test_a_fact_that_nobody_found_is_refused():
    with pytest.raises(ClaimsError, match=r"C01.external: 'no targt' .* 'no target'"):
        independent({"C01": claim(external=["no targt"])}, TABLE)
