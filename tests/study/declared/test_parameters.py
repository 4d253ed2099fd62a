"""Parameters from declared values: one that is not admissible is named by its key."""

import re
from dataclasses import dataclass

import pytest
from pydantic import ValidationError

from microimpact.lab.pdpa.analyser import Analyser
from microimpact.statistics.distributions import Distribution
from study.declared.parameters import build, explain


@dataclass(frozen=True)
class Holder:
    """A parameter class with a distribution, as a study has it."""

    diameter_um: Distribution


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kind": "normal", "mean": 1.0, "sd": -1.0}, "diameter_um.sd: -1.0 must be"),
        ({"kind": "normal", "means": 1.0}, "diameter_um.means: unknown key .did you mean 'mean'"),
        ({"kind": "gauss"}, r"diameter_um\.kind: .*gauss"),
        ({"mean": 1.0}, r"diameter_um\.kind: missing"),
        ({"kind": "uniform", "low": 2.0, "high": 1.0}, "diameter_um: low must be below high"),
        ({"kind": "uniform", "low": 2.0}, "diameter_um.high: missing"),
    ],
)
def test_a_malformed_distribution_is_named_by_its_key(given, words):
    with pytest.raises(ValidationError) as caught:
        build(Holder, {"diameter_um": given})
    lines = explain(caught.value, Holder, "study")
    assert len(lines) == 1
    assert re.search(rf"^study\.{words}", lines[0]), lines[0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"probe_height_error_um": 101.0}, "probe_height_error_um: 101 must be at most"),
        ({"outlier_factors": (1.4, 0.7)}, r"\[1.4, 0.7\] must ascend"),
        ({"false_diameters_um": (10.0, 10.0)}, r"\[10, 10\] must ascend"),
    ],
)
def test_a_setting_of_the_analyser_is_refused_by_its_key(settings, changes, message):
    with pytest.raises(ValueError, match=message):
        build(Analyser, settings.branches["fig04_05_normal_experiments"]["instrument"] | changes)
