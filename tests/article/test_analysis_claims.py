"""Numbers behind the claims on the analyses: complete, right where physics says so, breakable."""

from __future__ import annotations

import numpy as np
import pytest
from tests.article.claim_worlds import STEEL, merged, require_code
from tests.article.conftest import ROOT

from microimpact.core.tables import parse_table
from microimpact.declared.parameters import build
from microimpact.declared.selection import read_all
from microimpact.lab.contacts import calibrated_contact
from microimpact.ledgers.claims import verdict, verdicts
from microimpact.studies.analyses.doe.factors import elasticities
from microimpact.studies.claims import analysis_claims
from microimpact.studies.claims.analysis_claims import losses
from microimpact.studies.claims.analysis_claims.context import Context

RIDGE = list(STEEL)

# Small samples: verdicts hang on no last digit.
SMALL = {
    "samples": {"impacts": 1500},
    "spread": {"experiments": 8},
    "capture": {"spheres": 600},
    "losses": {"data_sets": 60},
}


@pytest.fixture(scope="module")
def effects(run_study, settings, calibration):
    """Return a function that gives the table of effects of a changed design."""
    branch = settings.branches["doe"]
    steel = [case for case in branch["cases"] if case["case"] in RIDGE]
    quick = {**branch["sampling"], "replicates": 2, "points": 10}

    def table(levels=(), **changes):
        cases = [merged(case, {"realistic": dict(levels)}) for case in steel]
        return run_study("doe", calibration, cases=cases, sampling=quick, **changes)["doe_effects"]

    return table


@pytest.fixture(scope="module")
def smooth(run_study, settings, calibration):
    """Return the table of the Monte Carlo analysis; its smooth surface needs no sample."""
    branch = settings.branches["monte_carlo"]
    least = {"replicates": 2, "events": 2}
    changes = {
        "plan": least,
        "comparison": least,
        "variants": [branch["variants"][0]],
        "angles_deg": [15.0, 20.0, 45.0, 85.0],
        "slope_inference": {"plan": least},
    }
    return run_study("monte_carlo", calibration, **merged(branch, changes))["monte_carlo"]


@pytest.fixture(scope="module")
def tables(shipped_calibration, effects, smooth):
    names = ("calibration", "calibration_family")
    return {name: shipped_calibration[name] for name in names} | {
        "doe_effects": effects(),
        "monte_carlo": smooth,
    }


@pytest.fixture(scope="module")
def claims(claims):
    return {name: claims[name] for name in analysis_claims.CLAIMS}


@pytest.fixture(scope="module")
def small(settings):
    return merged(settings.branches["analysis_claims"], SMALL)


@pytest.fixture(scope="module")
def baseline(run_study, small, tables):
    return run_study("analysis_claims", tables, **small)["analysis_claims"]


def values(numbers):
    return {
        str(case): dict(zip(rows["quantity"], rows["value"], strict=True))
        for case, rows in numbers.groupby("case", sort=False)
    }


@pytest.fixture(scope="module")
def found(baseline, claims):
    """Return the verdicts without a break."""
    return {
        name: verdict(claim, values(baseline[baseline["claim"] == name]))[0]
        for name, claim in claims.items()
    }


@pytest.fixture(scope="module")
def rejudged(claims, small, tables, declared):
    """Return a function that judges one claim again with changed settings or tables."""

    def again(name, changes=(), **changed):
        params = build(analysis_claims.Params, merged(small, dict(changes)))
        context = Context.of(params, declared | tables | changed)
        return verdict(claims[name], values(analysis_claims.numbers_of(name, context)))[0]

    return again


@pytest.fixture(scope="module")
def declared(settings, small):
    rows = read_all(*(str(ROOT / path) for path in settings.general.tables))
    return {key: parse_table(text) for key, text in rows.named_in(small).items()}


def with_fields(calibration, cases=(*RIDGE, "steel-formica"), **factors):
    """Return the calibration with some fitted fields of some cases multiplied."""
    changed = calibration.copy()
    for name, factor in factors.items():
        own = (changed["role"] == "parameter") & (changed["quantity"] == name)
        own &= changed["case"].isin(cases)
        assert own.any()
        changed.loc[own, "value"] *= factor
    return changed


def number(baseline, claim, quantity, case=""):
    own = baseline[(baseline["claim"] == claim) & (baseline["case"] == case)]
    return float(own.set_index("quantity")["value"][quantity])


def test_every_claim_has_its_numbers_in_its_units(baseline, claims):
    ledger = verdicts(claims, baseline)
    assert list(ledger["id"]) == list(claims)
    require_code(baseline)


def test_evidence_says_what_was_sampled(baseline, claims):
    evidence = baseline.groupby("claim")["evidence"].first()
    virtual = {name for name, claim in claims.items() if claim.kind == "virtual experiment"}
    assert {name for name in claims if evidence[name] == "virtual experiment"} == virtual


def test_numbers_are_the_same_again(baseline, run_study, small, tables):
    again = run_study("analysis_claims", tables, **small)["analysis_claims"]
    assert again.equals(baseline)


def test_elasticities_are_those_of_the_similarity_law(baseline, declared, tables):
    for case in RIDGE:
        slopes = elasticities(calibrated_contact(declared | tables, case)).at_fixed_damping
        work = number(baseline, "C57", "elasticity_to_work_of_adhesion", case)
        size = number(baseline, "C57", "elasticity_to_diameter", case)
        assert [work, size] == pytest.approx([slopes[1], slopes[2]], rel=1e-4)


def test_hertz_period_is_3_218_time_scales(baseline):
    ratio = number(baseline, "C103", "ratio_of_expressions")
    assert 1.0 / ratio == pytest.approx(3.2181, abs=5e-5)


def test_without_adhesion_the_impulse_ratio_is_the_friction(baseline):
    # all measures of the normal force: a momentum balance leaves no choice
    for case in RIDGE:
        name = "largest_difference_of_impulse_ratio_from_friction"
        assert number(baseline, "C93", name, case) < 1e-12


def test_net_friction_gives_no_rise_and_hertz_the_greatest(baseline):
    for case in RIDGE:
        net, compressive, hertz = (
            number(baseline, "C69", f"impulse_ratio_8_over_15_deg{ending}", case)
            for ending in ("_net", "", "_hertz")
        )
        assert net == pytest.approx(1.0, abs=1e-12)
        assert 1.0 < compressive < hertz


def test_rigid_work_of_adhesion_and_material_loss_share_the_loss(baseline):
    # W_A by Eq. (18) and 1 - R^2 add up to 1 - e^2: too much of one is too little of the other
    for case in RIDGE:
        assert number(baseline, "C101", "greatest_ratio_of_works", case) > 1.0
        assert number(baseline, "C102", "greatest_ratio_of_material_losses", case) < 1.0


def test_a_facet_cannot_make_energy(baseline):
    measured = number(baseline, "C46", "measured_restitution")
    # energy: no measured restitution exceeds one over the sine of the angle
    assert 0.70 < measured < 1.0 / np.sin(np.radians(10.0))


# Settings of the study that stand for a break, by claim.
SETTINGS = {
    "C08": {"capture": {"mean_diameter_um": 125.0}},
    "C45": {"slopes": {"form": "printed"}},
    "C46": {"slopes": {"form": "printed"}},
    "C47": {"slopes": {"facing_slope_deg": -2.0}},
    "C48": {"slopes": {"form": "printed"}},
    "C49": {"slopes": {"spin_ratio": 0.1}},
    "C50": {"slopes": {"form": "printed"}},
    "C51": {"samples": {"formica": {"surface_slope": 0.0}}},
    "C52": {"samples": {"formica": {"surface_slope": 0.0}}},
    "C57": {"capture": {"work_size_exponent": 1.0}},
    "C60": {"samples": {"silicon_back": {"surface_slope": 0.002}}},
    "C68": {"impacts": {"speed_m_per_s": 1.75}},
    "C69": {"impacts": {"friction_basis": "net"}},
    "C93": {"impacts": {"share_without_adhesion": 1.0}},
    "C94": {"samples": {"formica": {"surface_slope": 0.40}}},
    "C95": {"impacts": {"relative_angles_deg": [60.0, 85.0]}},
    "C96": {"samples": {"pair": ["diameter"]}},
    "C97": {"capture": {"kept_share": 0.01 * 5 / 7}},
    "C98": {"capture": {"slope_sd": 0.0}},
    "C104": {"losses": {"fitted_from": 5.0}},
    "C105": {"sieve": {"diameter_um": {"low": 20.0, "high": 30.0}}},
    "C106": {"impacts": {"friction_speed_exponent": 1.0}},
    "C107": {"capture": {"work_size_exponent": 1.0}},
    "C108": {"losses": {"attachment_damped": False}},
    "C109": {"spread": {"dropped": {"spin": {"sd": 0.0}}}},
}

# Factors on fields of the calibrated contacts that stand for a break.
NO_DAMPING = {"hertz_damping": 0.0, "adhesion_damping": 0.0}
FIELDS = {
    "C70": {"adhesion_damping": 0.0},
    "C99": NO_DAMPING,
    "C100": NO_DAMPING,
    "C102": {"work_of_adhesion": 0.001},
    "C110": {"work_of_adhesion": 0.0},
}

# Breaks of the designed experiments: multiples of the nominal values, and the set to look at.
LEVELS = {"C53": ("adhesion_dissipation", 0.05), "C56": ("radius", 0.0005)}
BY_HAND = {"C54", "C55", "C101", "C103"}


def test_every_claim_is_broken_once():
    lists = (SETTINGS, FIELDS, LEVELS, BY_HAND)
    assert sorted(name for some in lists for name in some) == sorted(analysis_claims.CLAIMS)


def agrees(name, claims, found, broken):
    """Check a break: it brings the verdict that it should, which was not there without it."""
    assert broken == claims[name].break_.expect != found[name]


@pytest.mark.parametrize("name", SETTINGS)
def test_break_of_a_setting(name, claims, found, rejudged):
    agrees(name, claims, found, rejudged(name, SETTINGS[name]))


@pytest.mark.parametrize("name", FIELDS)
def test_break_of_the_contact(name, claims, found, rejudged, shipped_calibration):
    changed = {"calibration": with_fields(shipped_calibration["calibration"], **FIELDS[name])}
    if name == "C99":
        members = shipped_calibration["calibration_family"].copy()
        members[["hertz_damping_s_per_m", "adhesion_damping_s_per_m"]] = 0.0
        changed["calibration_family"] = members
    agrees(name, claims, found, rejudged(name, **changed))


@pytest.mark.parametrize("name", LEVELS)
def test_break_of_realistic_levels(name, claims, found, rejudged, effects):
    factor, half = LEVELS[name]
    table = effects({factor: [1.0 - half, 1.0 + half]})
    agrees(name, claims, found, rejudged(name, doe_effects=table))


def test_break_of_the_small_levels_of_adhesive_damping(claims, found, rejudged, effects):
    half = 0.00005
    five = [0.95, 1.05]
    names = ("stiffness", "work_of_adhesion", "radius", "hertz_dissipation")
    levels = {**dict.fromkeys(names, five), "adhesion_dissipation": [1.0 - half, 1.0 + half]}
    table = effects(levels)
    # the declared levels stand in for the printed ones, which have one width for all factors
    table = table[table["variation"] == "realistic"].assign(variation="uniform")
    agrees("C54", claims, found, rejudged("C54", doe_effects=table))


def test_break_by_a_quarter_of_the_design(claims, found, rejudged, effects):
    agrees("C55", claims, found, rejudged("C55", doe_effects=effects(generator="a b c ab ac")))


def test_break_by_the_earlier_expression_of_the_work(claims, found, rejudged, monkeypatch):
    def earlier(v_n, R, rho):
        return 0.5 * v_n**2 * R**2 * rho * (1.0 - rho)

    monkeypatch.setattr(losses, "adhesion_work", earlier)
    agrees("C101", claims, found, rejudged("C101"))


def test_break_by_the_time_scale_of_the_group(claims, found, rejudged, monkeypatch):
    def scale(elastic, speed):
        return elastic.hertz_radius * elastic.replace(reference_velocity=speed).damping_unit

    monkeypatch.setattr(losses, "hertz_period", scale)
    agrees("C103", claims, found, rejudged("C103"))
