"""Mean and interval of an experiment, by hand and by tables of Student's t."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.lab.reduction import mean_interval
from microimpact.statistics.intervals import student_half_width


def test_two_events_have_one_degree_of_freedom():
    found = mean_interval([1.0, 3.0])
    assert found.value == 2.0
    assert found.sd == pytest.approx(np.sqrt(2.0))
    # t(0.975; 1) = 12.7062; the standard error of the mean is 1.
    assert found.high - found.value == pytest.approx(12.7062, abs=1e-4)
    assert found.value - found.low == pytest.approx(12.7062, abs=1e-4)


@pytest.mark.parametrize(
    ("events", "level", "t"),
    [(10, 0.95, 2.2622), (10, 0.90, 1.8331), (31, 0.95, 2.0423), (10**6, 0.95, 1.95996)],
)
def test_the_width_is_that_of_the_tables(events, level, t):
    assert student_half_width(np.sqrt(events), events, level=level) == pytest.approx(t, abs=1e-4)


def test_errors_that_all_events_share_are_not_averaged_away():
    # 3-4-5: standard error of the scatter 3, of what is shared 4.
    scatter = 3.0 * np.sqrt(10)
    alone = student_half_width(scatter, 10)
    assert student_half_width(scatter, 10, 4.0) == pytest.approx(5.0 / 3.0 * alone)
    values = np.array([1.0, 2.0, 4.0])
    both = mean_interval(values, systematic=0.5)
    expected = student_half_width(both.sd, 3, 0.5)
    assert both.high - both.value == pytest.approx(float(expected))


def test_one_event_is_not_enough():
    with pytest.raises(ValueError, match="at least 2 events, got 1"):
        mean_interval([1.0])
