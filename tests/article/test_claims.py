"""Numbers behind the claims: complete, right where physics says so, and breakable one by one."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from tests.article.claim_breaks import (
    BREAKS,
    MUTE,
    SECTIONS,
    STEEL,
    World,
    coverage,
    effects,
    merged,
    pairing,
    pile_up,
    ptis_range,
)
from tests.shared import tables_made_once

from microimpact.core.tables import parse_table
from microimpact.declared.parameters import build
from microimpact.ledgers.claims import verdicts
from microimpact.studies.analyses.doe.factors import elasticities
from microimpact.studies.claims import NUMBER_COLUMNS, claim_numbers
from microimpact.studies.claims.claim_numbers import CLAIMS, NOT_COMPUTED, numbers_of
from microimpact.studies.contacts import DRAWN, calibrated_contact

# All rest on tables that take long to make.
pytestmark = pytest.mark.slow

# Small samples: verdicts hang on no last digit.
SMALL = {
    "sampling": {"impacts": 1500},
    "spread": {"experiments": 8},
    "capture": {"spheres": 600},
    "fits": {"data_sets": 60},
}
# So small that verdicts may be others: only what cannot be computed is looked at.
LEAST = {
    "sampling": {"impacts": 200},
    "series_impacts": 200,
    "spread": {"experiments": 2},
    "capture": {"spheres": 50},
    "sieves": {"sizes": 50, "experiments": 20},
}


@pytest.fixture(scope="module")
def branch(settings):
    return merged(settings.branches["claim_numbers"], SMALL)


@pytest.fixture(scope="module")
def declared(settings):
    return {key: parse_table(text) for key, text in settings.rows["claim_numbers"].items()}


@pytest.fixture(scope="module")
def tables(made, run_study, settings, branch, declared, tmp_path_factory):
    """Return the tables of earlier studies, some of smaller ones."""

    def make():
        found = dict(made("calibration"))
        for study in ("force_history", "mechanisms", "rolling_dissipation", "restitution_fits"):
            found |= made(study)
        found |= smooth_surface(run_study, settings, found)
        with pytest.MonkeyPatch.context() as patch:
            world = World(run_study, settings, branch, declared, found, patch)
            found |= ptis_range(world) | pairing(world, 0.5, 2.0)
            found |= coverage(world) | pile_up(world, 5.0) | effects(world)
        return found

    return tables_made_once(tmp_path_factory, "tables of claims", make)


def smooth_surface(run_study, settings, tables):
    """Return the table of the Monte Carlo analysis; its smooth surface needs no sample."""
    branch = settings.branches["monte_carlo"]
    least = {"replicates": 4, "events": 8}
    changes = {
        "plan": least,
        "comparison": least,
        "variants": [branch["variants"][0]],
        "angles_deg": [15.0, 20.0, 45.0, 85.0],
        "slope_inference": {"plan": least},
    }
    made = run_study("monte_carlo", tables, **merged(branch, changes))
    return {"monte_carlo": made["monte_carlo"]}


@pytest.fixture(scope="module")
def numbers(branch, declared, tables, tmp_path_factory):
    def make():
        params = build(claim_numbers.Params, branch)
        return claim_numbers.gather(params, {**declared, **tables}, [])

    found = tables_made_once(tmp_path_factory, "numbers of claims", make)
    return texts_filled(found["claim_numbers"])


def texts_filled(table):
    """Return a table that was read from a file with empty cells of text as they were."""
    return table.assign(
        **{n: table[n].astype(object).fillna("") for n in ("case", "inputs", "problem")}
    )


@pytest.fixture(scope="module")
def value(numbers):
    """Return a function that gives the numbers of one quantity, in order of its cases."""

    def of(claim, quantity):
        own = (numbers["claim"] == claim) & (numbers["quantity"] == quantity)
        return numbers.loc[own, "value"].to_numpy(float)

    return of


@pytest.fixture
def world(run_study, settings, branch, declared, tables, monkeypatch):
    return World(run_study, settings, branch, declared, tables, monkeypatch)


def verdict_of(claims, name, numbers):
    found = verdicts({name: claims[name]}, numbers[numbers["claim"] == name])
    return found[0]["verdict"].iloc[0]


def test_every_number_of_every_testable_claim_is_there_in_its_unit(claims, numbers):
    assert list(numbers.columns) == list(NUMBER_COLUMNS)
    assert set(CLAIMS) == {name for name, claim in claims.items() if claim.testable}
    assert (numbers["problem"] == "").all()
    # verdicts refuses a number that is missing, not finite, twice there or of another unit
    assert list(verdicts(claims, numbers)[0]["id"]) == list(claims)


def test_evidence_says_what_was_sampled_and_what_was_fitted(claims, numbers):
    evidence = numbers.groupby("claim")["evidence"].unique()
    for name, (found,) in evidence.items():
        kind, fitted = claims[name].kind, claims[name].if_met == "calibrated"
        assert (kind == "virtual experiment") <= (found != "computed")
        # where an input was fitted to the figure, agreement proves nothing
        assert (found == "calibrated") <= fitted
        assert (fitted and kind == "model") <= (found == "calibrated")


def test_every_number_names_the_function_of_its_claim(numbers):
    for name, code in zip(numbers["claim"], numbers["code"], strict=True):
        module, _, function = code.rpartition(".")
        assert module.startswith("microimpact.studies.claims.claim_numbers.")
        assert function == name.lower()


def test_a_claim_alone_has_the_numbers_it_has_among_all(branch, declared, tables, numbers):
    params = build(claim_numbers.Params, branch)
    for name in ("C09", "C60", "C97"):
        alone = numbers_of(name, params, {**declared, **tables})
        among = numbers[numbers["claim"] == name].reset_index(drop=True)
        pd.testing.assert_frame_equal(again(alone), among, check_exact=True)


def again(table):
    """Return a table as it is read from its file."""
    return texts_filled(parse_table(table.to_csv(index=False)))


def test_a_claim_of_another_name_is_refused(branch):
    with pytest.raises(ValueError, match="no function computes a claim 'C90'"):
        numbers_of("C90", build(claim_numbers.Params, branch), {})


def test_a_draw_that_is_a_calibrated_contact_has_its_numbers(
    branch, declared, tables, numbers, monkeypatch
):
    contact = calibrated_contact(declared | tables, STEEL[1])
    row = {
        "case": "steel",
        "variant": "v",
        "draw": 3,
        "particle": contact.particle.name,
        "surface": contact.surface.name,
        "friction_basis": "compressive",
        **{name: float(getattr(contact, field)) for name, field in DRAWN.items()},
    }
    row |= {"diameter_um": 1e6 * row["diameter_um"], "friction": branch["steel"]["friction"]}
    names = ["C05", "C37", "C68"]
    draws = {"case": "steel", "variants": {"v": 1}, "claims": names}
    params = build(claim_numbers.Params, branch | {"draws": draws})
    inputs = {**declared, **tables, "admissible_contacts": pd.DataFrame([row])}
    found = claim_numbers.part(params, inputs, 0, 1)
    assert claim_numbers.part(params, inputs, 1, 2) == []
    monkeypatch.setattr(claim_numbers, "_ascending", list)  # the others
    table = claim_numbers.gather(params, inputs, [found])["claim_draws"]
    assert set(table["claim"]) == set(names)
    own = numbers[numbers["case"].str.startswith(STEEL[1]) & numbers["claim"].isin(names)]
    assert table["value"].to_numpy() == pytest.approx(own["value"].to_numpy(), rel=1e-6)


# Breaks


def test_every_claim_has_its_break_in_its_section():
    for breaks, module in zip(SECTIONS, claim_numbers.SECTIONS, strict=True):
        own = {name for name, claim in CLAIMS.items() if claim.of.__module__ == module.__name__}
        assert set(breaks) == own
    assert set(MUTE) <= set(BREAKS)


@pytest.mark.parametrize("name", [name for name in BREAKS if name not in MUTE])
def test_breaking_a_claim_changes_its_verdict(name, claims, numbers, world):
    expected = claims[name].break_.expect
    assert verdict_of(claims, name, numbers) != expected
    assert verdict_of(claims, name, BREAKS[name](name, world)) == expected


@pytest.mark.parametrize("name", MUTE)
def test_a_mute_break_finds_the_verdict_that_stands_already(name, claims, numbers, world):
    expected = claims[name].break_.expect
    broken = BREAKS[name](name, world)
    assert verdict_of(claims, name, numbers) == expected
    assert verdict_of(claims, name, broken) == expected
    own = numbers[numbers["claim"] == name]
    assert not np.array_equal(own["value"].to_numpy(), broken["value"].to_numpy())


# Claims that cannot be computed


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_slow_impacts_leave_claims_not_computed_and_the_others_alone(claims, world, numbers):
    """At 0.01 m/s steel is captured: there is no plateau and no rebound."""
    slow = {"steel": {"speed_m_per_s": 0.01}}
    params = build(claim_numbers.Params, merged(merged(world.branch, slow), LEAST))
    found = claim_numbers.gather(params, {**world.declared, **world.tables}, [])["claim_numbers"]
    problems = found[found["problem"] != ""].groupby("claim")["problem"].first()
    assert {"C07", "C10", "C59"} <= set(problems.index)
    assert problems["C10"] == ("ValueError: steel.speed_m_per_s: at 0.01 it rebounds at no angle")
    assert set(found.loc[found["problem"] != "", "quantity"]) == {NOT_COMPUTED}
    ledger = verdicts(claims, found)[0].set_index("id")
    assert (ledger["verdict"] == NOT_COMPUTED).to_dict() == {
        name: name in problems.index for name in ledger.index
    }
    assert ledger["note"]["C10"].startswith(f"{STEEL[0]}: {problems['C10']}")
    # what rests on no speed is as it was
    same = again(found[found["claim"] == "C01"])
    pd.testing.assert_frame_equal(same, numbers[numbers["claim"] == "C01"], check_exact=True)


@pytest.mark.parametrize("error", [ArithmeticError, RuntimeError, ValueError])
def test_what_the_settings_forbid_is_told_in_one_line(error, world, claims):
    def raising(context):
        raise error("one\n  two")

    world.patch.setitem(CLAIMS, "C01", claim_of("C01", raising))
    (row,) = world.numbers("C01").to_dict("records")
    assert (row["claim"], row["quantity"]) == ("C01", NOT_COMPUTED)
    assert row["problem"] == f"{error.__name__}: one two"


def test_a_number_that_is_not_finite_is_not_computed(world):
    world.patch.setitem(CLAIMS, "C01", claim_of("C01", lambda context: {"v": np.nan}))
    (row,) = world.numbers("C01").to_dict("records")
    assert row["problem"] == "ArithmeticError: v = nan is not a finite number"


@pytest.mark.parametrize("error", [AttributeError, KeyError, TypeError])
def test_errors_of_the_program_are_raised(error, world):
    def raising(context):
        raise error("wrong")

    world.patch.setitem(CLAIMS, "C01", claim_of("C01", raising))
    with pytest.raises(error, match="wrong"):
        world.numbers("C01")


def claim_of(name, function):
    own = CLAIMS[name]
    return type(own)(of=function, by_case=False, evidence=own.evidence, units=own.units)


# What physics says of some numbers


def test_an_impact_rolls_too_little_for_the_moment_of_steady_rolling(value):
    """C42: hysteresis of rolling builds up over the contact's width; here it turns a part of it."""
    assert (value("C42", "largest_distance_rolled_over_contact_radius") < 0.2).all()
    impact, steady, bound = (
        value("C42", f"largest_{name}_over_friction_moment")
        for name in ("rolling_moment", "moment_of_steady_rolling", "bound_of_moment")
    )
    assert (impact < 0.1 * steady).all()
    assert (steady < bound).all()


def test_elasticities_are_those_of_the_similarity_law(value, declared, tables):
    work, size = (
        value("C57", f"elasticity_to_{name}") for name in ("work_of_adhesion", "diameter")
    )
    for number, case in enumerate(STEEL):
        slopes = elasticities(calibrated_contact(declared | tables, case)).at_fixed_damping
        assert [work[number], size[number]] == pytest.approx([slopes[1], slopes[2]], rel=1e-4)


def test_the_work_of_adhesion_varies_too_little_to_lead(value):
    declared, needed = (
        value("C53", f"log_range_{words}")
        for words in ("of_work_of_adhesion_over_that_of_damping", "at_which_both_have_one_effect")
    )
    # of the levels of this study; the others are equal for all factors
    assert (declared[::2] < needed[::2]).all()
    assert (value("C57", "capture_velocity_of_small_and_adhesive_over_next_group") > 1.05).all()


def test_hertz_period_is_3_218_time_scales(value):
    assert 1.0 / value("C103", "ratio_of_expressions") == pytest.approx(3.2181, abs=5e-5)


def test_without_adhesion_the_impulse_ratio_is_the_friction(value):
    # all measures of the normal force: a momentum balance leaves no choice
    assert (value("C93", "largest_difference_of_impulse_ratio_from_friction") < 1e-12).all()


def test_net_friction_gives_no_rise_and_hertz_the_greatest(value):
    net, compressive, hertz = (
        value("C69", f"rise_of_impulse_ratio{ending}") for ending in ("_net", "", "_hertz")
    )
    assert net == pytest.approx(1.0, abs=1e-12)
    assert (compressive > 1.0).all()
    assert (compressive < hertz).all()


def test_rigid_work_of_adhesion_and_material_loss_share_the_loss(value):
    # W_A by Eq. (18) and 1 - R^2 add up to 1 - e^2: too much of one is too little of the other
    assert (value("C101", "greatest_ratio_of_works") > 1.0).all()
    assert (value("C102", "greatest_ratio_of_material_losses") < 1.0).all()


def test_a_facet_cannot_make_energy(value):
    # energy: no measured restitution exceeds one over the sine of the angle
    measured = value("C46", "measured_restitution")
    assert 0.70 < measured < 1.0 / np.sin(np.radians(10.0))
