"""The constants of nature are SciPy's."""

import scipy

from microimpact.core import constants


def test_constants_are_scipys():
    assert constants.gravity == scipy.constants.g
    assert constants.epsilon_0 == scipy.constants.epsilon_0
