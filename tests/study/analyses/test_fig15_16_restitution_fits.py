"""Figs. 15 and 16: simulated restitution, fitted by Eq. (34)."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture(scope="module")
def tables(made):
    return made("fig15_16_restitution_fits")


@pytest.fixture(scope="module")
def fits(tables):
    return tables["restitution_fits"].set_index(["case", "exponent"])


def test_molybdenum_is_a_prediction_and_its_ends_enclose_the_printed_value(tables, fits):
    assert set(fits.loc["fluorescein-molybdenum, nominal", "evidence"]) == {"computed"}
    table = tables["fig15"]

    def capture(end):
        rows = table[table["series"] == f"fluorescein-molybdenum, {end}, simulation"]
        return rows.loc[rows["y_1"] > 0, "x_m_per_s"].min()

    assert capture("least") < 1.47 < capture("greatest")


def test_curves_end_in_capture(tables):
    for name in ("fig15", "fig16"):
        table = tables[name]
        curves = table[table["series"].str.endswith((", simulation", ", fit"))]
        for series, rows in curves.groupby("series"):
            first = rows.sort_values("x_m_per_s")["y_1"].to_numpy()
            assert first[0] == 0.0, series
            assert np.abs(np.diff(first)).max() < 0.05, series  # dense where they rise
            assert first.max() > 0.6, series


def test_fits_from_closer_to_capture_are_closer(run_study, settings, calibration):
    # v_c from data above capture: better the nearer the data come
    cases = settings.branches["fig15_16_restitution_fits"]["cases"]
    case = next(name for name in cases if "n = 0" in name)
    left_out = dict.fromkeys(set(cases) - {next(iter(cases)), case})
    errors = []
    for start in (1.05, 1.5, 3.0):
        found = run_study(
            "fig15_16_restitution_fits", calibration, cases=left_out, fitted_from=start
        )
        row = found["restitution_fits"].query("case == @case").iloc[0]
        errors.append(abs(row["v_c_m_per_s"] / row["simulated_v_c_m_per_s"] - 1))
    assert np.all(np.diff(errors) > 0)
    assert errors[0] < 0.03
