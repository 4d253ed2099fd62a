"""Student's t of e: the likelihood is SciPy's, and stray rows leave the interval where it was."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import norm, t

from microimpact import compare_models
from microimpact.core.computable import NotComputable
from microimpact.model.empirical.data import Tails, data_sets
from microimpact.model.empirical.search import misfits

LIMIT, NOISE = 0.18, 0.02


def rebounds(strays=()):
    v = LIMIT * np.geomspace(1.05, 12.0, 25)
    noise = np.random.default_rng(4).normal(0.0, NOISE, v.size)
    e = 0.72 * np.sqrt(1.0 - (LIMIT / v) ** 2) + noise
    for row in strays:
        e[row] = 0.05
    return v, e


@pytest.mark.parametrize("freedom", [1.0, 4.0, 30.0])
@pytest.mark.parametrize("known", [False, True])
def test_scale_and_deviance_are_the_likeliest(freedom, known):
    missed = np.random.default_rng(1).standard_t(3.0, (1, 20)) * 0.03 / (NOISE if known else 1.0)
    found, _ = Tails((freedom,), known).likeliest(missed, 20)

    def deviance(x):
        scale = max(np.exp(x[0]), 1.0 if known else 0.0)
        normal = -2.0 * np.sum(norm.logpdf(np.full(20, 1.0)))
        return -2.0 * np.sum(t.logpdf(missed, freedom, scale=scale)) - normal

    best = minimize(deviance, np.log([np.std(missed)]), method="Nelder-Mead", tol=1e-10)
    assert found[0, 0] == pytest.approx(best.fun, abs=1e-6)
    assert found[0, 1] == pytest.approx(max(np.exp(best.x[0]), float(known)), rel=1e-4)
    assert found[0, 2] == freedom


def test_slopes_are_those_of_the_deviance():
    v, e = rebounds()
    rng = np.random.default_rng(2)
    missed, slopes = rng.normal(0.0, 0.03, (1, 25)), rng.normal(0.0, 1.0, (1, 25, 3))
    sets = data_sets(v, e, 1.0)
    for tails in (Tails((3.0,), known=False), Tails((2.0, 5.0, 50.0), known=False)):
        heavy = type(sets)(v=sets.v, e=sets.e, weight=sets.weight, unit=sets.unit, top=sets.top,
                           q=None, tails=tails)  # fmt: skip
        owner, step = np.zeros(1, int), 1e-6
        half = misfits(missed, slopes, heavy, owner)[1][0]
        for k in range(3):
            ends = [misfits(missed + s * step * slopes[..., k], slopes, heavy, owner)[0][0]
                    for s in (1.0, -1.0)]  # fmt: skip
            assert 2.0 * half[k] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4)


def test_many_degrees_of_freedom_are_the_normal_distribution():
    v, e = rebounds()
    models = ["fixed loss", "viscous JKR"]
    for size in (None, 0.05, "free"):
        normal, heavy = (
            compare_models(v, e, size_scatter=size, models=models, tails=each)
            for each in (None, 1e6)
        )
        assert heavy.v_c_interval == pytest.approx(normal.v_c_interval, rel=1e-3)
        assert [m.criterion for m in heavy.models] == pytest.approx(
            [m.criterion for m in normal.models], abs=0.01
        )


@pytest.mark.parametrize("sigma", [None, NOISE])
@pytest.mark.parametrize("tails", [4.0, "free"])
def test_two_strays_of_25_cost_little(sigma, tails):
    """With exact speeds and with errors of speed."""
    clean = compare_models(*rebounds(), sigma)
    with pytest.raises(NotComputable, match="tails admit a few rows that stray"):
        compare_models(*rebounds((6, 20)), sigma)
    for errors in ({}, {"sigma_v": 1e-4}):
        heavy = compare_models(*rebounds((6, 20)), sigma, **errors, tails=tails)
        low, high = heavy.v_c_interval
        assert low < LIMIT < high
        assert high - low < 2.0 * np.diff(clean.v_c_interval)
        assert any("row 7" in words and "row 21" in words for words in heavy.warnings)
        assert heavy.tails in {4.0, 2.0, 3.0}
        assert (heavy.sigma is None) == (sigma is not None)


def test_refused_tails():
    v, e = rebounds()
    with pytest.raises(ValueError, match="tails must be"):
        compare_models(v, e, tails=0.5)
    with pytest.raises(ValueError, match="degrees of freedom or 'free'"):
        compare_models(v, e, tails="heavy")


ERRORS = {"exact": {}, "given": {"sigma_v": 0.004, "size_scatter": 0.05}, "free": {
    "sigma_v": 0.004, "size_scatter": "free"}}  # fmt: skip


@pytest.mark.parametrize("tails", [None, 4.0, "free"])
@pytest.mark.parametrize("errors", [*ERRORS])
@pytest.mark.parametrize("sigma", [None, NOISE])
@pytest.mark.parametrize("captured", [False, True])
def test_all_that_may_be_said_goes_together(captured, sigma, errors, tails):
    random = np.random.default_rng(7)
    v = LIMIT * np.geomspace(0.85, 12.0, 30)
    share = LIMIT / v * np.exp(0.05 * random.normal(size=30))
    e = 0.72 * np.sqrt(np.maximum(1.0 - share**2, 0.0))
    e = np.where(e > 0.0, np.clip(e + NOISE * random.standard_t(4.0, 30), 0.01, 1.0), 0.0)
    kept = (e > 0.0) | captured
    models = ["fixed loss", "viscous JKR", "Eq. 34, q = 1/2"]
    found = compare_models(v[kept], e[kept], sigma, **ERRORS[errors], models=models, tails=tails)
    low, high = found.v_c_interval
    assert 0.0 <= low < found.v_c < high < 2.0 * LIMIT
    weights = [model.weight for model in found.models]
    assert np.isfinite(weights).all()
    assert sum(weights) == pytest.approx(1.0)
    assert found.exact == (errors == "exact")
    assert (found.tails is None) == (tails is None)
    assert (found.size_scatter is None) == (errors != "free")
    assert (found.sigma is None) == (sigma is not None)
    assert ("Student's t" in found.summary()) == (tails is not None)
