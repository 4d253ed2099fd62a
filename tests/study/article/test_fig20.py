"""Fig. 20: other impacts, and the contacts drawn beside the nominal one."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest


@pytest.fixture(scope="module")
def study(run_study, calibration, admitted):
    """The function that runs the study with some parameters of its own."""
    inputs = {**calibration, "posterior_contacts": admitted("force_history", [{}] * 3)}
    return partial(run_study, "force_history", inputs)


@pytest.fixture(scope="module")
def tables(study):
    return study()


@pytest.fixture(scope="module")
def terms(tables):
    table = tables["fig20"].query("series != 'posterior'")
    wide = table.pivot_table(index="x_ns", columns="series", values="y_uN", sort=True)
    return {name: wide[name].to_numpy() for name in wide} | {"time": wide.index.to_numpy()}


@pytest.fixture(scope="module")
def numbers(tables):
    return tables["force_ratios"].set_index("quantity")


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


def test_band_of_drawn_contacts(tables, terms, study):
    """Three times the contact that is drawn, at another size: its own force, to a thin line."""
    band = tables["fig20"].query("series == 'posterior'")
    own = np.interp(band["x_ns"], terms["time"], terms["total"])
    for name in ("y_low", "y_uN", "y_high"):
        np.testing.assert_allclose(band[name], own, atol=0.01 * terms["total"].max())
    other = study(case="steel-silicon, n = 1", diameter_um=62.0, speed_m_per_s=1.66)["fig20"]
    assert "posterior" not in set(other["series"])
