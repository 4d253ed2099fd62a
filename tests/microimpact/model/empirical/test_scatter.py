"""Sizes that scatter and speeds with errors: the likelihood by quadrature, the truth inside."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm, t

from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.empirical import scatter, search, shapes
from microimpact.model.empirical.comparison import _checked, compare_models, compare_sets
from microimpact.model.empirical.equations import restitution
from microimpact.model.empirical.kernel import (
    BY_SIZE,
    FREEDOM,
    LEAST_SCATTER,
    LN_SIGMA,
    LN_SIZE,
    SCATTERED,
    deviance,
)

V = np.array([0.9, 1.0, 1.03, 1.1, 1.3, 2.0, 5.0, 12.0])
E = np.array([0.0, 0.1, 0.0, 0.25, 0.5, 0.7, 0.78, 0.7])
PLACES = {None: [np.log(40.0), 0.0, np.log(0.3), np.log(0.6)], "ring force": [3.0, 18.0, 15.0, 0.0]}
SIGMA_V, SIZE, SIGMA, V_C = 0.02, 0.07, 0.03, 1.02


def deviance_of(law, captured, x, v_c=V_C):
    """Minus twice the logarithm of the likelihood and its slopes, of the data above."""
    kept = (E > 0.0) | captured
    data = _checked(V[kept], E[kept], SIGMA, SIGMA_V * V[kept], None, "free")[0]
    gradient, information = np.empty(SCATTERED), np.empty((SCATTERED, SCATTERED))
    moments = np.empty((kept.sum(), 2))
    rows, table = scatter._data(data, data.scatter)[0], scatter._table(law)
    total = deviance(table, scatter._SCALE, rows, v_c, x, gradient, information, moments)
    return total, gradient.copy()


def variables(law, freedom=0.0):
    x = np.zeros(SCATTERED)
    x[:4] = PLACES[law]
    x[LN_SIZE], x[FREEDOM] = np.log(SIZE), freedom
    return x


@pytest.mark.parametrize("captured", [True, False])
@pytest.mark.parametrize("freedom", [0.0, 1.0, 2.0, 4.0])
def test_the_likelihood_of_eq_34_is_the_average_over_spheres_and_speeds(freedom, captured):
    x = variables(None, freedom)
    of_e = t(freedom, scale=SIGMA) if freedom else norm(scale=SIGMA)
    k, p, kappa, q = np.exp(x[:4])
    s = np.sqrt(SIGMA_V**2 + SIZE**2 + LEAST_SCATTER**2)
    expected = 0.0
    for v, measured in zip(V, E, strict=True):
        middle = np.log(v / V_C)
        if measured == 0.0:
            expected -= 2.0 * norm.logcdf(-middle / s) if captured else 0.0
            continue
        points = np.append(0.0, middle + s * np.array([-1.0, 0.0, 1.0]))

        def density(u, middle=middle, measured=measured):
            e = restitution(V_C * np.exp(u), k, p, kappa, q, V_C)
            return norm.pdf(u, middle, s) * of_e.pdf(measured - e)

        ends = 0.0, max(middle, 0.0) + 8.0 * s
        likely = quad(density, *ends, points=points[points > 0.0], limit=400)[0]
        # Of the density of e the constant factor is left out.
        expected -= 2.0 * np.log(likely * SIGMA * np.sqrt(2.0 * np.pi))
        expected += 0.0 if captured else 2.0 * norm.logcdf(middle / s)
    assert deviance_of(None, captured, x)[0] == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("captured", [True, False])
@pytest.mark.parametrize(
    ("law", "place"), [("ring force", [3.3, 18.4, 15.2]), ("viscous JKR", [0.0, 30.3, 0.0])]
)
def test_the_likelihood_is_that_of_spheres_of_the_same_materials(law, place, captured):
    """A smaller sphere has another v_c and other damping: simulated here, size by size."""
    x = variables(None)
    x[:4] = *place, 0.0
    axes = shapes.LAWS[law].axes
    first, second = (
        low * (high / low) ** (at / max(n - 1, 1))
        for (low, high, n), at in zip(axes, place[1:], strict=True)
    )
    contact = shapes.contact(law, first, second)
    limit = capture_velocity(contact)
    contact = contact.replace(adhesion_rate_exponent=place[0] / 4.0, reference_velocity=limit)
    log_d, step = np.linspace(-4.0, 4.0, 41, retstep=True)
    errors, apart = np.linspace(-4.0, 4.0, 161, retstep=True)
    spheres = contact.replace(diameter=np.exp(SIZE * log_d[:, None]) * contact.diameter)
    speed_sd = np.hypot(SIGMA_V, LEAST_SCATTER)
    expected = 0.0
    for v, measured in zip(V, E, strict=True):
        true = v / V_C * limit * np.exp(speed_sd * errors)
        e = simulate(spheres, np.broadcast_to(true, (41, 161))).coefficient_of_restitution
        weight = norm.pdf(log_d)[:, None] * norm.pdf(errors) * step * apart
        leaves = np.sum(weight, where=e > 0.0)
        if measured == 0.0:
            expected -= 2.0 * np.log(1.0 - leaves) if captured else 0.0
            continue
        likely = np.sum(weight * np.exp(-0.5 * ((measured - e) / SIGMA) ** 2), where=e > 0.0)
        expected -= 2.0 * np.log(likely) - (0.0 if captured else 2.0 * np.log(leaves))
    assert deviance_of(law, captured, x)[0] == pytest.approx(expected, abs=0.1)


def _exponent(law, x):
    cubes = scatter._table(law)[..., -3:-2]
    rows = np.empty((1, 1, 4))
    shapes.curves(np.repeat(cubes, 4 + BY_SIZE, axis=-1), np.zeros((1, 1)), x[None], rows)
    return float(rows[0, 0, -1])


@pytest.mark.parametrize("freedom", [0.0, 3.0])
@pytest.mark.parametrize("captured", [True, False])
@pytest.mark.parametrize("law", [None, "ring force"])
def test_its_slopes_are_those_of_differences(law, captured, freedom):
    x, step = variables(law, freedom), 1e-4
    free = [0, 1, 2, 3, LN_SIGMA, LN_SIZE] if law is None else [0, 1, 2, LN_SIGMA, LN_SIZE]
    gradient = deviance_of(law, captured, x)[1]
    for k in free:
        change = step * np.eye(SCATTERED)[k]
        up, down = (deviance_of(law, captured, x + sign * change)[0] for sign in (1.0, -1.0))
        assert gradient[k] == pytest.approx((up - down) / (2.0 * step), rel=0.02, abs=0.05)


@pytest.mark.parametrize("tails", [None, 4.0])
def test_many_rows_have_the_answer_of_a_search_without_classes(tails, monkeypatch):
    random = np.random.default_rng(11)
    v = np.geomspace(0.8, 12.0, 600) * np.exp(0.01 * random.normal(size=600))
    share = np.exp(0.06 * random.normal(size=600)) / v
    e = 0.8 * np.sqrt(np.maximum(1.0 - share**2, 0.0))
    e = np.where(e > 0.0, np.clip(e + 0.02 * random.normal(size=600), 0.001, 1.0), 0.0)
    said = {"models": ["fixed loss", "Eq. 34, q = 1/2"], "tails": tails}
    found, by_all = [], (v, e, 0.02, 0.01 * v, None, "free")
    for many in (500, 1000):
        monkeypatch.setattr(scatter, "MANY", many)
        found.append(compare_models(*by_all, **said))
    width = np.diff(found[1].v_c_interval)[0]
    assert found[0].v_c_interval == pytest.approx(found[1].v_c_interval, abs=0.03 * width)
    assert found[0].size_scatter == pytest.approx(found[1].size_scatter, rel=0.02)
    for one, other in zip(*(each.models for each in found), strict=True):
        assert one.weight == pytest.approx(other.weight, abs=0.01)


def test_exponents_are_those_of_capture_velocities(contact):
    """A smaller sphere of the same materials has a higher v_c, by the law's exponent."""
    viscous = contact.replace(
        hertz_damping=0.0, adhesion_damping=0.0, law=JKR(viscous_time=3e-10), work_of_adhesion=0.3
    )
    step = np.array([1.0, 1.02])
    limit = capture_velocity(viscous.replace(diameter=step * contact.diameter))
    e = simulate(viscous, limit[0] * 3.0).coefficient_of_restitution
    places = np.linspace(0.0, shapes.ONE - 1.0, 400)
    curve = np.array(
        [
            shapes.restitution("viscous JKR", np.array([0.0, x, 0.0]), np.array([3.0]))
            for x in places
        ]
    )
    nearest = places[np.argmin(np.abs(curve[:, 0] - e))]
    expected = -np.log(limit[1] / limit[0]) / np.log(1.02)
    assert _exponent("viscous JKR", np.array([0.0, nearest, 0.0])) == pytest.approx(
        expected, abs=0.02
    )
    assert np.all(shapes.exponents("fixed loss") == 5.0 / 6.0)


@pytest.fixture(scope="module")
def spheres(contact):
    """Twelve data sets of 25 rebounds of a class of 7 %, speeds +-1 %; no captured ones."""
    limit, rng = float(capture_velocity(contact)), np.random.default_rng(11)
    sets = []
    for _ in range(12):
        v = limit * np.exp(rng.uniform(np.log(1.05), np.log(15.0), 60))
        d = contact.diameter * np.exp(0.07 * rng.standard_normal(60))
        e = simulate(contact.replace(diameter=d), v).coefficient_of_restitution
        kept = np.flatnonzero(e > 0.0)[:25]
        e = np.clip(e + rng.normal(0.0, 0.015, 60), 1e-3, 1.0)
        read = v * np.exp(0.01 * rng.standard_normal(60))
        sets.append((read[kept], e[kept], d[kept]))
    return limit, sets


def test_a_class_of_sizes_covers_where_one_size_does_not(spheres, contact):
    limit, sets = spheres

    def held(arguments, limit=limit):
        found = compare_sets([arguments(*each) for each in sets])
        assert all(
            each.exact or not any("look as if" in w for w in each.warnings) for each in found
        )
        low, high = np.array([each.v_c_interval for each in found]).T
        return np.sum((low <= limit) & (limit <= high)), found

    exact, compared = held(lambda v, e, _: (v, e, 0.015))
    assert exact <= 10
    missed = [c for c in compared if not c.v_c_interval[0] <= limit <= c.v_c_interval[1]]
    assert sum(not c.warnings for c in missed) <= 1
    assert held(lambda v, e, _: (v, e, 0.015, 0.01 * v, None, 0.07))[0] >= 11
    # Each sphere's own diameter tells more.
    medians = np.array([np.median(d) for *_, d in sets])
    own_limits = capture_velocity(contact.replace(diameter=medians))
    inside, found = held(lambda v, e, d: (v, e, 0.015, 0.01 * v, d), own_limits)
    assert inside >= 11
    assert [each.diameter for each in found] == medians.tolist()


def test_a_scatter_is_found(spheres):
    limit, sets = spheres
    found = compare_sets([(v, e, 0.015, 0.01 * v, None, "free") for v, e, _ in sets[:4]])
    sizes = [each.size_scatter for each in found]
    assert np.exp(np.mean(np.log(sizes))) == pytest.approx(0.07, rel=0.6)
    assert sum(c.v_c_interval[0] <= limit <= c.v_c_interval[1] for c in found) >= 3


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("sigma", [0.02, None])
@pytest.mark.parametrize("sizes", ["one", "given", "free", "measured"])
@pytest.mark.parametrize("captured", [True, False])
def test_every_combination_of_captures_sigma_and_scatter_has_its_interval(captured, sizes, sigma):
    rng = np.random.default_rng(5)
    v = 0.18 * np.geomspace(0.6, 12.0, 30)
    d = 80e-6 * np.exp((0.0 if sizes == "one" else 0.07) * rng.standard_normal(30))
    share = np.minimum(0.18 * 80e-6 / d / v, 1.0)
    e = 0.75 * np.sqrt(1.0 - share**2)
    e = np.where(e > 0.0, np.clip(e + 0.02 * rng.standard_normal(30), 0.01, 1.0), 0.0)
    kept = (e > 0.0) | captured
    said = {
        "one": {},
        "given": {"size_scatter": 0.07},
        "free": {"size_scatter": "free"},
        "measured": {"d": d[kept]},
    }[sizes]
    found = compare_models(v[kept], e[kept], sigma, **said)
    low, high = found.v_c_interval
    truth = 0.18 * 80e-6 / np.median(d[kept]) if sizes == "measured" else 0.18
    assert low < found.v_c < high
    assert low <= truth <= high
    assert high < 1.5 * low
    assert sum(model.weight for model in found.models) == pytest.approx(1.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("said", [{"d": 50e-6}, {"sigma_v": 0.003}, {"size_scatter": 0.07}])
def test_few_rows_with_a_capture_and_no_sigma(said):
    """The example of the guide without its sigma: each model says 0.17 to 0.2 m/s."""
    v = [0.15, 0.2, 0.23, 0.3, 0.4, 0.55, 0.8, 1.2, 1.7, 2.5]
    e = [0.0, 0.19, 0.3, 0.45, 0.56, 0.64, 0.68, 0.72, 0.71, 0.66]
    found = compare_models(v, e, **said)
    low, high = found.v_c_interval
    assert 0.14 < low < found.v_c < high < 0.23
    assert low < 0.178 < high
    assert found.sigma > 0.002, "sizes do not explain all"


def test_captures_that_no_stated_scatter_allows_have_it_found():
    """Rebounds and captures that overlap, with sizes taken as exact."""
    rng = np.random.default_rng(6)
    v = np.geomspace(0.05, 2.0, 40)
    share = np.minimum(0.18 * np.exp(0.2 * rng.standard_normal(40)) / v, 1.0)
    e = np.where(share < 1.0, 0.7 * np.sqrt(1.0 - share**2), 0.0)
    found = compare_models(v, e, 0.02, d=np.full(40, 5e-5))
    assert found.size_scatter == pytest.approx(0.2, rel=0.5)
    assert found.v_c_interval[0] < 0.18 < found.v_c_interval[1]
    assert any("captures lie farther above rebounds" in w for w in found.warnings)
    stated = compare_models(v, e, 0.02, size_scatter=0.2)
    assert stated.size_scatter is None
    assert not any("captures lie farther" in w for w in stated.warnings)


@pytest.mark.parametrize("law", [None, "fixed loss", "ring force"])
def test_without_scatter_and_sigma_the_deviance_is_that_of_the_sum_of_squares(law):
    v = np.geomspace(1.0, 12.0, 15)
    e = 0.7 * np.sqrt(1.0 - 0.8 / v**2) + 0.05 * np.cos(9.0 * v)
    exact, scattered = _checked(v, e)[0], _checked(v, e, None, None, None, 0.0)[0]
    owner, v_c, none = np.zeros(1, int), np.array([0.85]), np.empty((0, 0, 0))
    if law is None:
        squares = search.profile(exact, owner, 1.0 - v_c, fresh=5)
    else:
        squares = shapes.profile(law, exact, owner, v_c, none)
    found = scatter.profile(law, None, scattered, owner, v_c, none)
    # With a factor sigma/0.03 in the likelihood, the square is that of n - 1 data.
    variance = squares.value[0] / (v.size - 1.0)
    expected = (v.size - 1.0) * np.log(variance) - 1.0 + 2.0 * np.log(0.03)
    assert found.value[0] == pytest.approx(expected, abs=0.1)
    assert np.exp(found.x[0, LN_SIGMA]) == pytest.approx(np.sqrt(variance), rel=0.02)


def test_a_wide_sigma_is_estimated():
    v = np.geomspace(0.2, 5.0, 60)
    e = 0.6 * np.sqrt(1.0 - (0.18 / v) ** 2)
    e = np.clip(e + 0.12 * np.random.default_rng(4).standard_normal(60), 0.01, 1.0)
    exact, averaged = compare_models(v, e), compare_models(v, e, sigma_v=0.0)
    assert exact.sigma == pytest.approx(0.12, rel=0.15)
    assert averaged.sigma == pytest.approx(exact.sigma, rel=0.05)


def test_without_scatter_all_is_as_if_exact(contact):
    limit = float(capture_velocity(contact))
    v = limit * np.geomspace(1.2, 12.0, 20)
    e = simulate(contact, v).coefficient_of_restitution
    e += np.random.default_rng(2).normal(0.0, 0.02, v.size)
    for sigma in (0.02, None):
        exact, none = compare_models(v, e, sigma), compare_models(v, e, sigma, size_scatter=0.0)
        width = np.diff(exact.v_c_interval)[0]
        assert none.v_c_interval == pytest.approx(exact.v_c_interval, abs=0.1 * width)
        assert exact.exact
        assert not none.exact


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sigma_v": -0.1}, r"sigma_v must be finite and in \[0, 1e\+06\], got -0.1"),
        ({"sigma_v": 1e308}, "sigma_v must be"),
        ({"sigma_v": 1.0}, r"sigma_v / v must be finite and in \[0, 0.5\)"),
        ({"d": 0.0}, "d must be finite and in"),
        ({"d": 1e308}, "d must be finite and in"),
        ({"d": [1e-5, 2e-5]}, r"d must be one number or of shape \(8,\), got \(2,\)"),
        ({"size_scatter": 7.0}, r"size_scatter must be finite and in \[0, 0.5\), got 7"),
        ({"size_scatter": "unknown"}, "size_scatter must be numbers or 'free', got 'unknown'"),
    ],
)
def test_bad_spreads_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        compare_models(np.arange(1.0, 9.0), np.full(8, 0.5), 0.02, **changes)
