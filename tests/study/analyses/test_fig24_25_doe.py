"""Figs. 24 and 25: effects of five factors on the capture velocity, by designs of experiments."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError
from tests.shared import ROOT

from microimpact.model.dynamics.capture import capture_velocity
from microimpact.statistics.effects import (
    aliases,
    defining_relation,
    effects,
    fractional_factorial,
    full_factorial,
    half_normal_positions,
    lenth,
    normal_positions,
    words,
)
from study.analyses.fig24_25_doe import compute as doe
from study.analyses.fig24_25_doe.factors import (
    LETTERS,
    Levels,
    at_levels,
    elasticities,
    factor_values,
    realistic_levels,
)
from study.claims import designs
from study.contacts import calibrated_contact
from study.declared.parameters import build, explain
from study.tables import parse_table

STEEL = ["steel-silicon, n = 0", "steel-silicon, n = 1"]


@pytest.fixture(scope="module")
def sampling(settings):
    return {**settings.branches["fig24_25_doe"]["sampling"], "replicates": 2}


@pytest.fixture(scope="module")
def tables(run_study, calibration, sampling):
    return run_study("fig24_25_doe", calibration, sampling=sampling)


@pytest.fixture(scope="module")
def percent(tables):
    table = tables["doe_effects"]
    keys = ["case", "variation", "design", "response", "effect"]
    return table.set_index(keys)["effect_percent"].sort_index()


def test_log_effects_are_elasticities_times_log_ranges(tables, percent):
    slopes = tables["doe_elasticities"].set_index(["case", "factor"])["at_fixed_zeta"]
    for case in STEEL:
        for letter in "ABCDE":
            found = percent[case, "uniform", "full", "ln v_c", letter]
            log_range = np.log(1.05 / 0.95)
            assert found == pytest.approx(100 * slopes[case, letter] * log_range, rel=0.01)


def test_quarter_fractions_show_a_factor_for_bd(tables, percent):
    table = tables["doe_bd_aliasing"]
    for (case, variation), rows in table.groupby(["case", "variation"]):
        assert len(rows) == 60
        on_factor = rows[rows["main_effect"] != "none"]
        assert len(on_factor) == 36
        assert (on_factor["main_effect"].value_counts() == 12).all()
        size = percent[case, variation, "full", "v_c"]
        assert rows["BD_percent"].to_numpy() == pytest.approx(size["BD"], rel=1e-12)
    row = table[(table["variation"] == "uniform") & (table["main_effect"] == "C")]
    assert (row["apparent_percent"].abs() > 5 * row["BD_percent"].abs()).all()


def test_work_over_radius_alone_counts(tables):
    slopes = tables["doe_elasticities"].set_index(["case", "factor"])["at_fixed_zeta"]
    for case in STEEL:
        assert slopes[case, "B"] + slopes[case, "C"] == pytest.approx(0.0, abs=1e-12)
    assert 1.25 < slopes[STEEL[0], "B"] < 1.5
    # a damping that falls with the speed of impact brings the exponent below the range
    assert slopes[STEEL[1], "B"] < 1.0


def test_fits_follow_the_capture_velocities(tables):
    design = tables["doe_design"]
    fraction = design[design["in_fraction"]]
    assert len(fraction) == 4 * 16
    ratio = fraction["fitted_capture_velocity_m_per_s"] / fraction["capture_velocity_m_per_s"]
    # data from above capture: fits of Eq. 34 come out low, by a share that hardly varies
    assert ratio.between(0.93, 1.03).all()
    assert ratio.std() < 0.02
    assert design[~design["in_fraction"]]["fitted_capture_velocity_m_per_s"].isna().all()
    centre = design[design["run"] == 0]
    assert centre["capture_velocity_m_per_s"].to_numpy() == pytest.approx(0.18, rel=1e-6)


def test_an_uncapturable_run_is_named(run_study, calibration, sampling):
    family = calibration["calibration_family"].copy()
    lowest = family.query("rate_exponent == 0 and plateau_of_e_holds == True").index[0]
    family.loc[lowest, "zeta_adhesion"] /= 100.0
    with pytest.raises(ValueError, match=r"n = 0', realistic levels: run \d+ has no finite") as e:
        run_study("fig24_25_doe", calibration | {"calibration_family": family}, sampling=sampling)
    assert "\n" not in str(e.value)


def test_another_generator(run_study, calibration, sampling):
    generator = "a b c ab ac"
    found = run_study(
        "fig24_25_doe", calibration, sampling=sampling, cases=STEEL[:1], generator=generator
    )
    table = found["doe_effects"]
    own = table[(table["variation"] == "uniform") & (table["response"] == "v_c by Eq. 34")]
    assert own["effect"].tolist() == ["A", "B", "C", "D", "E", "BC", "BE"]
    # I = ABD = ACE = BCDE: the figure says which effects are one
    drawn = found["fig24"]["series"].str.removeprefix("v_c: ")
    assert {"A+BD+CE", "B+AD", "BC+DE", "BE+CD"} <= set(drawn)
    fraction = table[(table["variation"] == "uniform") & (table["design"] == "fraction")]
    rows = fraction[fraction["response"] == "v_c"].set_index("effect")
    effects = designs.Effects(dict(rows["effect_percent"]), dict(rows["aliases"]), np.zeros(1))
    for word, mixed in {"A": "BD and CE", "BD": "A and CE"}.items():
        with pytest.raises(
            ValueError, match=f"fig24_25_doe.generator: .* tell {word} from {mixed}"
        ):
            designs.effect(effects, word)


# Designs: aliases, effects, margins, elasticities, levels


@pytest.fixture(scope="module")
def branch(settings):
    return settings.branches["fig24_25_doe"]


@pytest.fixture
def rated(contact):
    """A contact with a damping that falls with the speed of impact, and a v_N."""
    return contact.replace(adhesion_rate_exponent=0.7, reference_velocity=1.66, hertz_damping=0.5)


@pytest.mark.parametrize(
    "generator",
    [
        *("a b c d abcd", "a b c d -abcd", "a b c ab ac", "a b c -ab abc", "a b ab c ac"),
        *("a b d c abc", "b c d e bcde", "z y x w -zyxw"),
    ],
)
def test_aliases_are_columns_of_the_design(generator):
    design = fractional_factorial(generator)
    column = {w: design[:, [LETTERS.index(c) for c in w]].prod(axis=1) for w in words(LETTERS)}
    relation = defining_relation(generator, LETTERS)
    for word, sign in relation.items():
        assert np.all(column[word] == sign)
    classes = aliases(relation, LETTERS)
    assert len(classes) == len(design) - 1
    for word, others in classes.items():
        for other, sign in others.items():
            np.testing.assert_array_equal(column[other], sign * column[word])


def test_the_full_design_has_no_aliases():
    relation = defining_relation("a b c d e", LETTERS)
    assert relation == {}
    classes = aliases(relation, LETTERS)
    assert len(classes) == 31
    assert not any(classes.values())


@pytest.mark.parametrize(
    ("generator", "words_of_it"),
    [
        ("a b c d", "must have 5 words"),
        ("a b c d a", "AE"),
        ("a b c d ae", "letters e"),
        ("a b c d aab", "product of letters"),
        ("a b c d -", "product of letters"),
        ("a b c abc abc", "'DE'"),
        ("a b c d ab c", "must have 5 words"),
    ],
)
def test_impossible_generators(branch, generator, words_of_it):
    with pytest.raises(ValidationError) as caught:
        build(doe.Params, {**branch, "generator": generator})
    (line,) = explain(caught.value, doe.Params, "fig24_25_doe")
    assert words_of_it in line
    assert generator in line


def test_effects_of_a_known_polynomial_are_recovered():
    design = full_factorial(5)
    a, b, c, d, e = design.T
    response = 7.0 + 1.5 * a - 2.0 * c + 0.25 * b * d - 0.125 * a * c * e
    chosen = words(LETTERS)
    found = dict(zip(chosen, effects(design, LETTERS, chosen, response), strict=True))
    wanted = {"A": 3.0, "C": -4.0, "BD": 0.5, "ACE": -0.25}
    for word in chosen:
        assert found[word] == pytest.approx(wanted.get(word, 0.0), abs=1e-14)


def test_a_fraction_adds_aliased_effects():
    generator = "a b c -ab ac"
    whole, part = full_factorial(5), fractional_factorial(generator)
    response = np.random.Generator(np.random.PCG64(1)).random(32)
    relation = defining_relation(generator, LETTERS)
    classes = aliases(relation, LETTERS)
    chosen = words(LETTERS)
    full = dict(zip(chosen, effects(whole, LETTERS, chosen, response), strict=True))
    runs = (part > 0) @ 2 ** np.arange(5)
    np.testing.assert_array_equal(whole[runs], part)
    found = effects(part, LETTERS, list(classes), response[runs])
    for (word, others), value in zip(classes.items(), found, strict=True):
        total = full[word] + sum(sign * full[other] for other, sign in others.items())
        assert value == pytest.approx(total, abs=1e-13)


def test_lenth_by_hand():
    # median 3, s0 = 4.5; 12 >= 11.25 falls out; median of the six others 2.5, PSE 3.75
    found = lenth(np.array([1.0, -2.0, 2.0, 3.0, -4.0, 12.0, 5.0]))
    assert found.pseudo_error == pytest.approx(3.75)
    # Student's t with 7/3 degrees of freedom at 0.975: tables of m = 7 give 3.764, and 9.008
    assert found.margin / found.pseudo_error == pytest.approx(3.764, abs=1e-3)
    assert found.simultaneous / found.pseudo_error == pytest.approx(9.008, abs=1e-2)


def test_plotting_positions():
    values = np.array([0.1, -3.0, 2.0])
    # quantiles of (i - 1/2)/3: 1/6, 1/2, 5/6
    assert normal_positions(values) == pytest.approx([0.0, -0.96742, 0.96742], abs=1e-5)
    # of 1/2 + (i - 1/2)/6: 7/12, 3/4, 11/12
    assert half_normal_positions(values) == pytest.approx([0.21043, 1.38299, 0.67449], abs=1e-5)


def test_levels_move_the_factors_alone(rated):
    multiples = np.array([1.2, 0.7, 1.5, 2.0, 0.25])
    before, after = factor_values(rated), factor_values(at_levels(rated, multiples))
    for letter, multiple in zip(LETTERS, multiples, strict=True):
        assert float(after[letter] / before[letter]) == pytest.approx(multiple, rel=1e-12)


@pytest.mark.parametrize("rate", [0.0, 0.7, 1.0])
def test_elasticities_against_differences(contact, rate):
    contact = contact.replace(
        adhesion_rate_exponent=rate, reference_velocity=1.66, hertz_damping=2.0
    )
    found = elasticities(contact)
    step = 1e-4
    for i, letter in enumerate(LETTERS):
        multiples = np.ones((2, 5))
        multiples[:, i] = np.exp([step, -step])
        logs = np.log(capture_velocity(at_levels(contact, multiples)))
        assert found.at_fixed_zeta[i] == pytest.approx((logs[0] - logs[1]) / 2 / step, rel=1e-6)
        # at fixed damping coefficients: the same change, its damping put back
        held = at_levels(contact, multiples)
        if letter in "ABC":
            held = held.replace(
                hertz_damping=contact.hertz_damping, adhesion_damping=contact.adhesion_damping
            )
        logs = np.log(capture_velocity(held))
        assert found.at_fixed_damping[i] == pytest.approx((logs[0] - logs[1]) / 2 / step, rel=1e-6)


def test_small_damping_gives_five_quarters(scaled):
    found = elasticities(scaled(1e-6, 1e-6)).at_fixed_zeta
    # v_c ~ V (C_A + 2 C_H)^(1/2): K^(-1/3 - 1/6 - 1/5), (w/r)^(5/4), and 1/3 and 2/3 of a half
    assert found == pytest.approx([-0.7, 1.25, -1.25, 1 / 6, 1 / 3], abs=2e-3)


@pytest.fixture(scope="module")
def declared(settings):
    """Declared rows, and the calibration as kept for reference."""
    reference = {
        name: pd.read_csv(ROOT / f"tests/reference/tables/{name}.csv")
        for name in ("calibration", "calibration_family")
    }
    return reference | {
        name: parse_table(text) for name, text in settings.rows["fig24_25_doe"].items()
    }


def realistic(declared, n, sieve=(60.0, 125.0)):
    contact = calibrated_contact(declared, f"steel-silicon, n = {n}")
    return contact, realistic_levels(contact, sieve, declared).array


def test_levels_of_the_stiffness_come_from_the_declared_moduli(declared):
    _, levels = realistic(declared, 0)
    bodies = {"stainless-steel-316": [], "silicon": []}
    rows = declared["materials"].set_index(["material", "property"])
    for name, found in bodies.items():
        for end in ("low", "high"):
            bound = rows[end].fillna(rows["value"])[name].astype(float)
            e, nu = bound["youngs_modulus"], bound["poissons_ratio"]
            found.append((1.0 - nu**2) / e)
    # K = 4/3 E*, and 1/E* is the sum of (1 - nu^2)/E of both
    softest, stiffest = (sum(found[k] for found in bodies.values()) for k in (0, 1))
    assert levels[1, 0] == pytest.approx(math.sqrt(softest / stiffest), rel=1e-6)


def test_other_levels_come_from_the_sieve_and_from_the_level_members_of_the_family(declared):
    for n, works in ((0, (3.5, 4.5)), (1, (0.5, 1.0))):
        _, levels = realistic(declared, n)
        assert levels[1, 1] == pytest.approx(math.sqrt(works[1] / works[0]))
        assert levels[1, 2] == pytest.approx(math.sqrt(125 / 60))
        assert (levels[1, 3:] > 1.0).all()


def test_a_family_in_which_nothing_varies_is_refused(declared):
    family = declared["calibration_family"]
    few = family[family["work_of_adhesion_J_per_m2"] != 4.5]
    with pytest.raises(ValueError, match=r"two members or more with n = 0 .* gives 1"):
        realistic(declared | {"calibration_family": few}, 0)


def test_levels_may_not_be_given_for_an_empty_range():
    with pytest.raises(ValueError, match="stiffness: the low level 1 "):
        Levels(
            stiffness=(1.0, 1.0),
            work_of_adhesion=(0.9, 1.1),
            radius=(0.9, 1.1),
            adhesion_dissipation=(0.9, 1.1),
            hertz_dissipation=(0.9, 1.1),
        )


def test_half_ranges_take_the_place_of_realistic_levels(run_study, calibration, tables, sampling):
    levels = {"stiffness": 0.1, "radius": 0.05}
    made = run_study("fig24_25_doe", calibration, sampling=sampling, levels=levels)
    keys = ["case", "variation", "name"]
    rows, shipped = (each["doe_levels"].set_index(keys) for each in (made, tables))
    multiples = ["low_multiple", "high_multiple"]
    for name, share in levels.items():
        row = rows.loc[(STEEL[0], "realistic", name), multiples]
        assert row.tolist() == [1.0 - share, 1.0 + share]
    rest = rows.drop(index=list(levels), level="name")[multiples]
    assert rest.equals(shipped.loc[rest.index, multiples])
