"""What the statements say of the contact: by plain weighting, other seeds, and direct impacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy

from microimpact.core.materials import declared_file
from microimpact.model.calibration import peak_ratios
from microimpact.model.contact import resized
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.rigid_body.roughness import measured_impulse_ratio, measured_restitution
from microimpact.statistics.distributions import Constant, Normal
from microimpact.statistics.importance import drawn_size
from study.analyses.inference.compute import Judged, Params, values_at
from study.analyses.inference.statements import NODES, WEIGHTS, Statement, values_of
from study.contacts import declared_contact
from study.declared.parameters import build
from study.tables import parse_table

WITH, WITHOUT = "with the printed v_c", "without the printed v_c"
FREE, CONSTANT, JKR = "ring force, n free", "ring force, n = 0", "JKR, viscous"
STEEL, FLUORESCEIN = "steel-silicon", "fluorescein-molybdenum"
V_C = "v_c_m_per_s"


@pytest.fixture(scope="module")
def tables(made):
    return made("inference")


@pytest.fixture(scope="module")
def summary(tables):
    return (
        tables["evidence_summary"].set_index(["case", "scenario", "law", "quantity"]).sort_index()
    )


@pytest.fixture(scope="module")
def declared():
    names = ("materials", "contacts")
    return {name: parse_table(declared_file(f"{name}.csv").read_text()) for name in names}


@pytest.fixture(scope="module")
def plain(declared):
    """Contacts of fluorescein over the ranges, and their likelihoods, without and with v_c."""
    rng = np.random.default_rng(5)
    share = rng.random((1200, 3))
    c_h, c_a = 0.1 * share[:, 0], 0.01 * 30.0 ** share[:, 1]
    bare = declared_contact(declared, "ammonium-fluorescein", "molybdenum", diameter=4.9e-6)
    contacts = bare.replace(
        work_of_adhesion=bare.work_of_adhesion,
        hertz_damping=c_h,
        adhesion_damping=c_a,
        adhesion_rate_exponent=2.0 * share[:, 2],
        reference_velocity=5.2,
    )
    ratios = np.array([peak_ratios(contacts.at(i), 5.2) for i in range(len(share))])
    limits = np.array(
        [capture_velocity(resized(contacts, d)) for d in (2.58e-6, 3.44e-6, 4.9e-6, 6.89e-6)]
    )

    def log(value, low, high, tail):
        return -0.5 * (np.maximum(np.maximum(low - value, value - high), 0.0) / tail) ** 2

    logs = log(ratios[:, 0], 0.3, 0.367, 0.02) + log(ratios[:, 1], 0.18, 0.22, 0.01)
    logs = np.where(limits[2] < 5.2, logs, -np.inf)
    of_sizes = scipy.special.logsumexp(log(limits, 1.465, 1.475, 0.075), axis=0) - np.log(4)
    return limits[2], {WITHOUT: logs, WITH: logs + of_sizes}


@pytest.mark.parametrize("scenario", [WITHOUT, WITH])
def test_plain_weighting_of_the_prior_gives_the_same(summary, plain, scenario):
    limit, logs = plain
    weights = np.exp(logs[scenario])
    size = weights.sum() ** 2 / np.sum(weights**2)
    row = summary.loc[(FLUORESCEIN, scenario, "ring force", V_C)]
    error = np.hypot(row["ln_evidence_error"], np.sqrt(1 / size - 1 / len(weights)))
    assert row["ln_evidence"] == pytest.approx(np.log(weights.mean()), abs=3 * error)
    below = weights[limit < row["median"]].sum() / weights.sum()
    assert below == pytest.approx(0.5, abs=3 * np.sqrt(0.25 / size + 0.25 / row["effective_size"]))


@pytest.mark.parametrize(
    ("name", "scenario", "draws"),
    [(JKR, WITHOUT, 1000), (CONSTANT, WITHOUT, 6000), (FREE, WITHOUT, 10000), (JKR, WITH, 2000)],
    ids=["JKR", "n = 0", "n free", "JKR with v_c"],
)
def test_uniform_draws_over_a_box_give_the_same_for_steel(
    tables, summary, declared, settings, name, scenario, draws
):
    """Its share of the posterior is known from the drawn contacts; the prior is far too broad."""
    case = build(Params, settings.branches["inference"]).pairs[STEEL]
    law, row = case.laws[name], summary.loc[(STEEL, scenario, name, V_C)]
    drawn = tables["posterior_contacts"].set_index(["case", "scenario", "law"]).sort_index()
    drawn = drawn.loc[(STEEL, scenario, name)]
    points = np.stack([[law.share(key, v) for v in drawn[key]] for key in law.ranges], axis=1)
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    held = np.mean(np.all((points >= low) & (points <= high), axis=1))
    box = low + (high - low) * np.random.default_rng(4).random((draws, len(low)))
    values = values_at(case, law, declared, box)
    logs = Judged(case, law, values).likelihood(case.scenarios[scenario]).total
    weights = np.exp(logs)
    size = weights.sum() ** 2 / np.sum(weights**2)
    assert size > 40
    worth = drawn_size(row["effective_size"], len(points))
    error = np.sqrt(1 / size + row["ln_evidence_error"] ** 2 + (1 - held) / held / worth)
    evidence = np.log(weights.mean() * np.prod(high - low) / held)
    assert evidence == pytest.approx(row["ln_evidence"], abs=3 * error)


@pytest.fixture(scope="module")
def judged(settings, declared):
    """Contacts of JKR over the ranges, judged."""
    case = build(Params, settings.branches["inference"]).pairs[STEEL]
    points = np.random.default_rng(6).random((300, 3))
    return Judged(case, case.laws[JKR], values_at(case, case.laws[JKR], declared, points))


def test_both_printed_capture_velocities_count(judged):
    """0.2 to 0.3 m/s of spheres of 49 um; 0.18 m/s of one of three sizes, which is open."""
    limits = judged.values["capture"]

    def log(value, low, high, tail):
        return -0.5 * (np.maximum(np.maximum(low - value, value - high), 0.0) / tail) ** 2

    of_sizes = scipy.special.logsumexp(log(limits, 0.175, 0.185, 0.01), axis=1) - np.log(3)
    by_hand = log(limits[:, 0], 0.2, 0.3, 0.03) + of_sizes
    both, neither = (judged.likelihood(judged.case.scenarios[s]).total for s in (WITH, WITHOUT))
    known = np.isfinite(by_hand)
    assert known.sum() > 20
    assert (both - neither)[known] == pytest.approx(by_hand[known])


def test_one_tilt_turns_restitution_and_impulse_ratio_of_one_experiment(judged):
    """The mean over a common error by plain sums; apart they would be more likely."""
    scenario, rise = judged.case.scenarios[WITHOUT], "rise of the impulse ratio"
    grazing = judged.case.statements[rise].same_normal_as
    e, ratio = (judged.case.statements[name] for name in (grazing, rise))
    error = judged.case.normal_error(scenario)
    known = np.flatnonzero(np.isfinite(judged.values[rise]).all(axis=1))[:20]
    turns = np.random.default_rng(3).normal(0.0, error, (4000, 1, 1))
    v = {name: value[known] for name, value in judged.values.items()}
    logs = e.log_likelihood(v[grazing] + turns * v[f"shared {grazing}"], e.interval)
    of_e = np.exp(logs).mean(axis=2)
    own = error * v[f"own {rise}"]
    turned = v[rise] + turns * v[f"shared {rise}"]
    of_ratio = np.exp(ratio.log_likelihood(turned, ratio.interval, error=own))
    mean = (of_e[..., None] * of_ratio).mean(axis=0)
    likely = mean > 0.02
    assert likely.sum() > 5
    both = np.exp(judged.log_together(scenario, rise)[known])
    assert both[likely] == pytest.approx(mean[likely], rel=0.1)
    # Towards the surface e falls, and so does the ratio.
    assert np.all(v[f"shared {grazing}"][:, 0] > 0.0)
    assert np.all(v[f"shared {rise}"] > 0.0)


def test_eq_27_as_printed_takes_the_net_force_alone(judged):
    bases = judged.case.friction_bases(judged.law)
    printed = judged.case.scenarios["Eq. 27 as printed"]
    assert [*np.array(bases)[judged.bases(printed)]] == ["net"]
    corrected = np.array(bases)[judged.bases(judged.case.scenarios[WITH])]
    assert [*corrected] == ["compressive", "pull-off"]


def test_a_uniform_prior_has_the_mean_of_its_range(judged):
    """The weights turn draws of the logarithm into those of the parameter itself."""
    uniform = judged.case.choices["w_A uniform"]
    work = judged.law.parameters(np.random.default_rng(2).random((200000, 3)))
    values = {"capture": np.zeros(200000), **work}
    weights = np.exp(judged.law.log_prior(uniform, values))
    assert weights.mean() == pytest.approx(1.0, abs=0.02)
    mean = np.average(work["work_of_adhesion_J_per_m2"], weights=weights)
    assert mean == pytest.approx(0.5 * (0.002 + 10.0), rel=0.01)


def test_without_printed_capture_velocities_there_is_an_upper_bound_alone(summary):
    row = summary.loc[(STEEL, WITHOUT, "all laws", V_C)]
    assert row["likely_low"] < 0.1 * row["likely_high"]
    assert 0.14 < row["likely_high"] < 0.2
    row = summary.loc[(STEEL, WITH, "all laws", V_C)]
    assert 0.1 < row["likely_low"] < row["likely_high"] < 0.2


def test_another_seed_agrees_within_the_stated_error(run_study, tables):
    keys, known = ["case", "scenario", "law", "quantity", "kind"], tables["evidence_summary"]
    other = run_study("inference", first=10, seed=77)["evidence_summary"]
    both = known.merge(other, on=keys, suffixes=("", "_other"))
    both = both[(both["quantity"] == V_C) & (both["law"] != "all laws")]
    both = both[both[["effective_size", "effective_size_other"]].min(axis=1) > 30]
    assert len(both) > 120
    error = np.hypot(both["ln_evidence_error"], both["ln_evidence_error_other"])
    apart = np.abs(both["ln_evidence"] - both["ln_evidence_other"]) / error
    assert apart.max() < 4
    assert np.sqrt(np.mean(apart**2)) < 1.5


def test_the_statements_leave_law_and_capture_velocity_open(summary):
    rows = summary.loc[(STEEL, WITHOUT)].xs(V_C, level="quantity")
    assert (rows.loc[[FREE, JKR], "standing"] == "preferred").all()
    assert rows.loc[CONSTANT, "standing"] == "consistent"
    assert rows.loc[FREE, "median"] < rows.loc[[CONSTANT, JKR], "median"].min()
    assert rows.loc[[FREE, CONSTANT, JKR], "high"].max() < 0.18
    work = "work_of_adhesion_J_per_m2"
    for law in (CONSTANT, JKR):
        assert summary.loc[(STEEL, WITHOUT, law, work), "low"] > 0.6
        weak = summary.loc[(STEEL, "without v_c, van der Waals w_A", law, V_C)]
        assert weak["standing"] == "excluded"


def test_contacts_drawn_are_those_of_the_summary(tables, summary, declared):
    rows = tables["posterior_contacts"].set_index(["case", "scenario", "law"]).sort_index()
    assert (rows.groupby(level=[0, 1, 2]).size() == 400).all()
    for scenario in (WITH, WITHOUT):
        drawn, row = rows.loc[(STEEL, scenario, FREE)], summary.loc[(STEEL, scenario, FREE, V_C)]
        error = 3 * np.sqrt(0.25 / 400 + 0.25 / row["effective_size"])
        assert np.mean(drawn[V_C] < row["median"]) == pytest.approx(0.5, abs=error)


def test_a_statement_has_the_mean_over_the_sizes_that_rebound(contact):
    statement = Statement(
        words="e falls",
        standing="derived",
        quantity="fall of restitution",
        diameter_um=Normal(mean=50.0, sd=10.0),
        speeds_m_per_s=(1.6, 0.4),
        angles_deg=(90.0, 30.0),
        interval=(0.0, 0.1),
        tail=0.01,
    )
    nodes = statement.impacts()
    e = simulate(contact.replace(diameter=nodes[..., 0] * 1e-6), nodes[..., 1])
    value = statement.value(e.coefficient_of_restitution)
    sizes = Normal(mean=50e-6, sd=10e-6).quantile((np.arange(2000) + 0.5) / 2000)
    each = [
        simulate(contact.replace(diameter=sizes), v, angle).coefficient_of_restitution.mean()
        for v, angle in ((1.6, 90.0), (0.4, 30.0))
    ]
    assert value == pytest.approx(each[0] - each[1], abs=2e-4)
    assert WEIGHTS.sum() == pytest.approx(1.0)
    captured = np.where(NODES > 0.5, 0.6, np.nan)
    assert statement.value(np.array([captured, captured])) == 0.0


def test_a_captured_share_becomes_a_likelihood_over_what_is_noticed():
    statement = Statement(
        words="none seen",
        standing="inferred",
        quantity="share captured",
        diameter_um=Constant(at=50.0),
        speeds_m_per_s=(0.4, 0.5),
        angles_deg=(30.0,),
        interval=(0.0, 0.025),
        tail=0.025,
        spheres=40,
    )
    q, share = (np.arange(20000) + 0.5) / 20000, np.array([0.0, 0.01, 0.3, 1.0])
    by_hand = [np.log(np.mean((1.0 - q * p) ** 40)) for p in share]
    logs = statement.log_likelihood(share, statement.interval)
    assert logs == pytest.approx(by_hand, abs=1e-3)
    # Normal speeds from 0.2 to 0.25 m/s: half are below 0.225.
    limits = np.array([[0.225, 0.225], [0.1, 0.1], [0.3, 0.3]])
    assert statement.captured(limits, np.array([40.0, 60.0])) == pytest.approx([0.5, 0.0, 1.0])


@pytest.fixture
def statement():
    return Statement(
        words="e",
        standing="printed",
        quantity="restitution",
        diameter_um=Constant(at=50.0),
        speeds_m_per_s=(1.66,),
        angles_deg=(10.0, 12.0),
        is_open=True,
        interval=(0.6, 0.7),
        tail=0.1,
    )


def test_an_interval_with_normal_tails(statement):
    logs = statement.log_likelihood(np.array([0.5, 0.6, 0.65, 0.9, np.nan]), (0.6, 0.7))
    assert logs[:4] == pytest.approx([-0.5, 0.0, 0.0, -2.0])
    assert logs[4] < -1e5


@pytest.mark.parametrize("error", [0.02, 0.3])
def test_the_likelihood_is_the_mean_over_a_normal_error(statement, error):
    value, turns = np.array([0.1, 0.62, 0.66, 1.9]), np.linspace(-12.0, 12.0, 20001)
    exact = np.exp(statement.log_likelihood(value[:, None] + error * turns, (0.6, 0.7)))
    mean = exact @ np.exp(-0.5 * turns**2) / np.exp(-0.5 * turns**2).sum()
    logs = statement.log_likelihood(value, (0.6, 0.7), error=error)
    assert logs == pytest.approx(np.log(mean), abs=1e-3)


def test_values_change_with_the_normal_as_measured_on_a_slope(contact, statement):
    ratio = replace(statement, quantity="impulse ratio", interval=(0.1, 0.2))
    each = contact.replace(friction=np.full(2, 0.15))

    def contacts(diameters, rows=slice(None)):
        spread = each.replace(friction=each.friction[rows, None])
        return spread.replace(diameter=diameters * 1e-6)

    both = {"e": statement, "mu": ratio}
    values = values_of(both, contacts, ("compressive",), np.array([40.0, 60.0]), 0.004)
    turn, angle = 1e-3, np.array([10.0, 12.0])
    e, mu = [], []
    for phi in (-turn, turn):
        local = contact.replace(diameter=50e-6, friction=0.15)
        impact = simulate(local, 1.66, angle + np.degrees(phi), friction_basis="compressive")
        signed = -np.asarray(impact.impulse_ratio)
        restitution = impact.coefficient_of_restitution
        e.append(measured_restitution(np.radians(angle), phi, restitution, signed))
        mu.append(-measured_impulse_ratio(phi, signed))
    assert values["turning e"][0] == pytest.approx((e[1] - e[0]) / (2 * turn), rel=0.03)
    assert values["turning mu"][0, 0] == pytest.approx((mu[1] - mu[0]) / (2 * turn), rel=0.05)
    # A quarter of a degree is a twenty-fifth in e at 10 deg.
    assert np.radians(0.25) * values["turning e"][0, 0] == pytest.approx(0.04, abs=0.006)
