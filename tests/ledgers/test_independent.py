"""Facts found by others, beside the claims that name them."""

import pandas as pd
import pytest
from tests.ledgers.test_claims import claim

from microimpact.ledgers.claims.criteria import ClaimsError
from microimpact.ledgers.claims.independent import AGREES, DISAGREES, independent

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
    ("facts", "told"),
    [
        (["no target"], f"{AGREES} | no target: yes for a"),
        (["half is lost"], f"{DISAGREES} | half is lost: no for b"),
        (
            ["falls with size"],
            "agrees in part with independent data | falls with size: yes for a; no for b",
        ),
        (
            ["no target", "half is lost"],
            "agrees in part with independent data | no target: yes for a | half is lost: no for b",
        ),
        (["never computed"], ""),
    ],
)
def test_what_independent_data_say(facts, told):
    assert independent({"C01": claim(external=facts)}, TABLE) == {"C01": told}


def test_a_claim_that_names_no_fact_has_none():
    assert independent({"C01": claim()}, TABLE) == {}


def test_a_fact_that_nobody_found_is_refused():
    with pytest.raises(ClaimsError, match=r"C01.external: 'no targt' .* 'no target'"):
        independent({"C01": claim(external=["no targt"])}, TABLE)
