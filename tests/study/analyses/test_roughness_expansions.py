"""Coefficients measured on a slope: what Section 4.1 says, and how far its equations reach."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact.model.rigid_body.roughness import energy_bound
from study.analyses.roughness_expansions.compute import (
    EQUATIONS,
    FORMS,
    SlopedImpacts,
    slope_range,
)

FACETS = np.array([-10.0, -5.0, -2.0, -1.0, 1.0, 2.0, 5.0, 10.0, 20.0])


def impacts(angle, slope, spin=0.0):
    angle, slope = np.radians(angle), np.radians(slope)
    return SlopedImpacts(angle=angle, slope=slope, e=0.7, friction=0.15, spin_ratio=spin)


def value(name, angle, slope, form="printed"):
    return float(EQUATIONS[name].value(impacts(angle, slope), form))


def test_equations_35_and_37_on_a_slope_of_10_deg_at_10_deg():
    exact = float(EQUATIONS["37"].exact(impacts(10, 10)))
    assert exact == pytest.approx(2.21, abs=5e-3)
    assert value("37", 10, 10) == pytest.approx(2.40)
    assert value("35", 10, 10) == pytest.approx(0.77, abs=5e-3)
    assert value("35", 10, 10, "corrected") == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "spin"),
    [("35", 0.0), ("37", 0.0), ("38", 0.0)]
    # without spin both forms of Eq. 41 are one
    + [(name, spin) for name in ("39", "41") for spin in (-0.2, 0.0, 0.2) if spin or name == "39"]
    + [("after 40", 0.0)],
)
def test_corrections_bring_every_equation_nearer(name, spin):
    equation = EQUATIONS[name]
    for angle in (5.0, 10.0, 20.0) if equation.shallow else (90.0,):
        small = impacts(angle, FACETS[abs(FACETS) <= 2.0], spin)
        printed, corrected = (equation.error(small, form) for form in FORMS)
        assert np.all(corrected < printed)


def test_equation_35_as_printed_breaks_energy_and_never_exceeds_one_on_a_facing_slope():
    broken = []
    for angle in (5.0, 10.0, 20.0):
        slopes = FACETS[angle + FACETS > 0.0]
        printed = EQUATIONS["35"].value(impacts(angle, slopes), "printed")
        broken += slopes[abs(printed) > energy_bound(np.radians(angle))].tolist()
        assert np.all(printed[slopes > 0] < 1.0)
    assert broken
    assert max(broken) < 0.0


def test_ends_of_ranges_are_where_the_error_is_one_per_cent():
    ends = slope_range(EQUATIONS["37"], "printed", impacts(10.0, 0.0), 0.01)
    assert -10.0 < ends[0] < 0.0 < ends[1] < 45.0
    for end in ends:
        assert EQUATIONS["37"].error(impacts(10.0, end), "printed") == pytest.approx(0.01, rel=1e-6)


def test_the_figure_holds_every_panel_with_its_ranges(run_study):
    table = run_study("roughness_expansions")["roughness"]
    series = table.groupby("panel")["series"].unique()
    assert len(series) == 3
    for panel in series:
        assert {"exact", "printed", "corrected", "range corrected"} <= set(panel)
