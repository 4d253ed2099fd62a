"""One study from Python: what is changed is taken, or refused in one line."""

from __future__ import annotations

import numpy as np
import pytest
from tests.shared import ROOT

from study.declared.documents import load
from study.run.study import Made, run_study


def test_arrays_are_taken_as_lists():
    (table,) = run_study(
        "fig17_coulomb_friction", friction=np.array([0.1, 0.2]), points=10
    ).values()
    assert {"0.1", "0.2"} <= set(table["series"])
    assert "0.15" not in set(table["series"])


@pytest.mark.parametrize(
    ("name", "changes", "told"),
    [
        (
            "fig20_force_histroy",
            {},
            "'fig20_force_histroy' is no study .did you mean 'fig20_force_history'",
        ),
        (3, {}, "3 is no study"),
        ("fig20_force_history", {"diameter": 3}, "fig20_force_history.diameter: unknown key"),
        ("fig20_force_history", {"diameter_um": -3}, "diameter_um: -3 must be greater than 0"),
        (
            "fig20_force_history",
            {"diameter_um": 4.9e-6},
            "4.9e-06 um must be from 0.001 to 5000 um",
        ),
        ("fig20_force_history", {"diameter_um": None}, "fig20_force_history.diameter_um: missing"),
        ("fig20_force_history", {"diameter_um": {1, 2}}, "must be a number, a text, a list"),
        (
            "fig20_force_history",
            {"particles": {}},
            "particles: is shared by all studies: an overlay",
        ),
    ],
)
def test_what_is_wrong_is_told_in_one_line(name, changes, told):
    with pytest.raises((ValueError, TypeError), match=told) as caught:
        run_study(name, **changes)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("given", [{"friction": [0.1]}, [0.1]])
def test_parameters_are_no_tables(given):
    with pytest.raises(ValueError, match="must be tables of studies by name; parameters are key"):
        run_study("fig17_coulomb_friction", given)


@pytest.mark.parametrize("name", sorted(path.stem for path in ROOT.glob("config/examples/*.yaml")))
def test_what_an_example_changes_can_be_calibrated(name):
    overlay = load(ROOT / f"config/examples/{name}.yaml")
    del overlay["pathvars"]
    tables = Made("fig20_force_history", overlay)
    assert tables.moved("calibration") == (name in {"large-spheres", "jkr-impact"})
    assert "fluorescein-molybdenum, greatest" in set(tables["calibration"]["case"])
