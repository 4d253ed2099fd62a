"""Fig. 20: normal force against time and its four terms."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest


@pytest.fixture(scope="module")
def study(run_study, calibration, admitted):
    """The function that runs the study with some parameters of its own."""
    inputs = {**calibration, "admissible_contacts": admitted("force_history", [{}] * 3)}
    return partial(run_study, "force_history", inputs)


@pytest.fixture(scope="module")
def tables(study):
    return study()


@pytest.fixture(scope="module")
def terms(tables):
    table = tables["fig20"].query("series != 'admissible'")
    wide = table.pivot_table(index="x_ns", columns="series", values="y_uN", sort=True)
    return {name: wide[name].to_numpy() for name in wide} | {"time": wide.index.to_numpy()}


@pytest.fixture(scope="module")
def numbers(tables):
    return tables["force_ratios"].set_index("quantity")


def test_terms_add_up(terms):
    parts = ("hertz", "hertz damping", "adhesion", "adhesion damping")
    np.testing.assert_allclose(sum(terms[p] for p in parts), terms["total"], rtol=1e-9, atol=1e-9)


def test_compression_is_positive_and_adhesion_negative(terms):
    assert (terms["hertz"] >= 0).all()
    assert (terms["adhesion"] <= 0).all()


def test_the_force_dips_near_both_ends_and_more_on_rebound(terms):
    total = terms["total"]
    signs = np.sign(total[np.abs(total) > 1e-9])
    assert (np.diff(signs) != 0).sum() == 2, "one compressive stretch between two dips"
    assert signs[0] == signs[-1] == -1
    turn = int(np.argmax(terms["hertz"]))
    assert total[turn:].min() < total[:turn].min() < 0


def test_no_adhesion_dissipation_during_approach(terms):
    turn = int(np.argmax(terms["hertz"]))
    assert np.abs(terms["adhesion damping"][: turn - 1]).max() == 0.0
    assert (terms["adhesion damping"][turn + 1 :] <= 0).all()


def test_impulse_equals_the_change_of_momentum(terms, numbers):
    mass = 1350 * np.pi / 6 * 4.9e-6**3
    impulse = np.trapezoid(terms["total"] * 1e-6, terms["time"] * 1e-9)
    e = numbers.loc["coefficient_of_restitution", "value"]
    assert impulse == pytest.approx(mass * 5.2 * (1 + e), rel=1e-3)


def test_printed_ratios(numbers):
    # "approximately 1/3" and "about 1/5": within 10 %; the second fixed the damping
    assert numbers.loc["peak_adhesion_over_peak_hertz", "value"] == pytest.approx(1 / 3, rel=0.1)
    assert numbers.loc["peak_adhesion_over_peak_hertz", "evidence"] == "computed"
    name = "peak_adhesion_dissipation_over_adhesion"
    assert numbers.loc[name, "value"] == pytest.approx(1 / 5, rel=1e-3)
    assert numbers.loc[name, "evidence"] == "calibrated"


def test_adhesion_over_hertz_follows_the_greatest_compression(numbers, study):
    # 1/x_m: a faster sphere is compressed more, so the ratio falls
    faster = study(speed_m_per_s=10.4)["force_ratios"].set_index("quantity")
    name = "peak_adhesion_over_peak_hertz"
    assert faster.loc[name, "value"] < 0.7 * numbers.loc[name, "value"]


def test_a_captured_sphere_is_drawn_too(study, draw):
    tables = study(speed_m_per_s=0.5)
    numbers = tables["force_ratios"].set_index("quantity")["value"]
    assert numbers["coefficient_of_restitution"] == 0.0
    draw("fig20", tables)


def test_another_impact_has_no_printed_ratios(study, numbers):
    assert numbers["printed"].notna().sum() == 2
    slower = study(speed_m_per_s=5.0)["force_ratios"]
    assert slower["printed"].isna().all()


def test_band_of_admissible_contacts(tables, terms, study):
    """Three times the contact that is drawn, at another size: its own force, to a thin line."""
    band = tables["fig20"].query("series == 'admissible'")
    own = np.interp(band["x_ns"], terms["time"], terms["total"])
    for name in ("y_low", "y_uN", "y_high"):
        np.testing.assert_allclose(band[name], own, atol=0.01 * terms["total"].max())
    other = study(case="steel-silicon, n = 1", diameter_um=62.0, speed_m_per_s=1.66)["fig20"]
    assert "admissible" not in set(other["series"])
