"""The compiled integrator: statuses, and numbers that do not depend on the company."""

import numpy as np
import pytest

from microimpact.model.dynamics import kernel
from microimpact.model.dynamics.normal import integrate


def problem(w=1.0, *, adhesion=1.0, c_h=0.0, c_a=0.0, always_captured=False):
    row = np.zeros(kernel.PROBLEM_COLUMNS)
    row[kernel.START_U], row[kernel.ADHESION] = w, adhesion
    row[kernel.HERTZ_DAMPING], row[kernel.DAMPING_2] = c_h, c_a
    row[kernel.ALWAYS_CAPTURED] = always_captured
    return row


@pytest.fixture(scope="module")
def sample():
    random = np.random.default_rng(7)
    rows = [
        problem(10 ** random.uniform(-3, 3), c_h=random.uniform(0, 0.3), c_a=random.uniform(0, 0.8))
        for _ in range(101)
    ]
    return np.array(rows)


@pytest.mark.parametrize("ledger", [False, True])
def test_a_result_does_not_depend_on_its_place_among_others(sample, ledger):
    together = integrate(sample, ledger=ledger)
    order = np.random.default_rng(1).permutation(len(sample))
    assert np.array_equal(integrate(sample[order], ledger=ledger), together[order])
    parts = [integrate(part, ledger=ledger) for part in np.array_split(sample, [1, 2, 19, 60])]
    assert np.array_equal(np.concatenate(parts), together)
    alone = np.concatenate([integrate(row[None], ledger=ledger) for row in sample[:20]])
    assert np.array_equal(alone, together[:20])


def test_the_ledger_does_not_change_the_path(sample):
    plain, full = integrate(sample, ledger=False), integrate(sample, ledger=True)
    for column in (kernel.STATUS, kernel.END_U, kernel.DURATION, kernel.COMPRESSIVE_IMPULSE):
        assert np.array_equal(plain[:, column], full[:, column])


def test_statuses_tell_rebound_from_capture():
    stays = problem(2.0, always_captured=True)
    rows = np.array([problem(2.0, c_a=0.3), problem(0.3, c_a=0.3), stays])
    status = integrate(rows, ledger=False)[:, kernel.STATUS]
    assert status.tolist() == [kernel.REBOUND, kernel.CAPTURED, kernel.CAPTURED]


def test_the_path_backwards_returns_to_the_start():
    forward = integrate(problem(2.0, c_h=0.05, c_a=0.3)[None], ledger=False)[0]
    back = problem(-forward[kernel.END_U], c_h=-0.05)
    back[kernel.DAMPING_1], back[kernel.DAMPING_2] = -0.3, 0.0
    returned = integrate(back[None], ledger=False)[0]
    assert -returned[kernel.END_U] == pytest.approx(2.0, rel=1e-13)
    assert returned[kernel.DURATION] == pytest.approx(forward[kernel.DURATION], rel=1e-13)


def test_a_backward_path_without_turning_point_is_told():
    back = problem(0.1, c_h=-1.0)
    results = np.zeros((1, kernel.RESULT_COLUMNS))
    kernel.integrate(back[None], kernel.PLAIN, results)
    assert results[0, kernel.STATUS] == kernel.ESCAPED


def test_a_problem_that_is_not_finite_raises():
    with pytest.raises(RuntimeError, match="1 impact"):
        integrate(problem(np.nan)[None], ledger=False)


def test_an_impact_takes_few_steps():
    steps = integrate(problem(2.0, c_h=0.05, c_a=0.3)[None], ledger=False)[0, kernel.STEPS]
    assert steps < 30


def test_the_recorded_path_ends_where_the_integration_ends():
    row = problem(2.0, c_h=0.05, c_a=0.3)
    result = integrate(row[None], ledger=True)[0]
    series, ends = np.zeros((200, 2, kernel.ORDER + 1)), np.zeros((200, 3))
    count = kernel.record(row, False, np.inf, series, ends)
    assert 0 < count < 60
    assert ends[:count, 1].sum() == pytest.approx(result[kernel.DURATION], rel=1e-13)
    assert ends[:count, 2].sum() == pytest.approx(result[kernel.HERTZ_IMPULSE], rel=1e-13)
    end_u = np.polyval(series[count - 1, 1, ::-1], ends[count - 1, 0])
    assert end_u == pytest.approx(result[kernel.END_U], rel=1e-13)
