"""A finding is shown on a figure as long as the data of the figure bear it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.shared import ROOT
from tests.study.figures.test_pictures import SPECS, data_of

from study.figures.declaration import Figure, stated
from study.tables import Numbers, ResultTables

# The small run of the references has no events at the shallow angles that these are about.
OF_SHALLOW_ANGLES = {"fig06", "fig07", "fig11", "fig12", "causes"}
# Effects, works of adhesion, velocities, angles and slopes are abscissae.
OF_ABSCISSAE = {"fig24_25_doe", "calibration", "campaign", "inference", "roughness_expansions"}
# All ordinates; in another unit than one, above what the sentence calls few.
FLAT = {"coverage_of_means": 100.0, "capture_by_size": 1e4}
CHECKED = [name for name, figure in SPECS.items() if figure.holds]


COMPARED = [name for name, figure in SPECS.items() if figure.disagreement + figure.agreement]


# Columns that say which experiment a row is of, and those of one table alone.
KEYS = {"angle_deg", "nominal_speed_m_per_s", "probe_height_mm", "slope_sd", "spin_mean"}
KEYS |= {"target_radius_mm", "slope_deg", "share", "diameter_um", "x_deg"}
KEYS_OF = {"surface_correction": {"speed_m_per_s", "restitution"}}


class FlatTables(ResultTables):
    """Tables of a run in which nothing depends on anything."""

    def __call__(self, name):
        """Return a table in which all results are the same."""
        rows = super().__call__(name).rows
        results = {*rows.select_dtypes("number")} - KEYS - KEYS_OF.get(name, set())
        return Numbers(name, rows.assign(**{column: flat_value(column) for column in results}))


def flat_value(column):
    """Return a number that is a restitution of 0.55 everywhere, or follows from it."""
    if "difference" in column:
        return 0.0
    return 1.0 - 0.55**2 if "loss" in column else 0.55


def tables_of(figure):
    return dict(zip(figure.data, data_of(figure), strict=True))


@pytest.mark.parametrize("name", CHECKED)
def test_data_of_the_reference_bear_each_finding(name):
    figure = SPECS[name]
    found = figure.checked(tables_of(figure)).finding
    assert bool(found) != (name in OF_SHALLOW_ANGLES)
    assert "{" not in found


@pytest.mark.parametrize("name", CHECKED)
def test_flat_curves_bear_no_finding(name):
    figure = SPECS[name]
    flat = {
        key: table.assign(**dict.fromkeys(table.columns[4:7], FLAT.get(name, 1.0)))
        for key, table in tables_of(figure).items()
    }
    if figure.analysis in OF_ABSCISSAE:
        flat = {key: table.assign(**{table.columns[3]: 1.0}) for key, table in flat.items()}
    assert figure.checked(flat).finding == ""


def test_faces_of_the_mirror_that_differ_by_their_roughness_alone_are_not_said_to_differ_more():
    """The two smooth curves, equal within 0.01, belonged to the sentence that stood there."""
    figure = SPECS["fig07"]
    tables = tables_of(figure)
    table = tables["fig07"]
    y = table.columns[4]
    rough = (table["series"] == "mirror back") & (table["panel"] == "restitution")
    table.loc[rough, y] += 1.0
    assert "0.80 of the front and 0.70 of the back" in figure.checked(tables).finding
    back = (table["series"] == "mirror back, smooth") & (table["panel"] == "restitution")
    table.loc[back, y] += 0.095
    assert figure.checked(tables).finding == ""
    former = replace(figure, finding="Only roughness.", holds=lambda y: stated(faces(y) < 0.01))
    assert former.checked(tables).finding == "Only roughness."
    assert former.checked(tables_of(figure)).finding == ""


def faces(y):
    front, back = (
        y(f"mirror {face}, smooth", "restitution").iloc[-1] for face in ("front", "back")
    )
    return abs(front - back)


def test_a_finding_without_a_check_or_without_its_curve_is_not_shown():
    figure = Figure(print, "fig14", "t", "c", {}, data=("d",), finding="Said.")
    assert figure.checked({}).finding == ""
    absent = replace(figure, holds=lambda y: stated(y("none").any()))
    assert absent.checked({}).finding == ""
    assert replace(figure, holds=lambda _: stated(True)).checked({}).finding == "Said."


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Tables of a full run and figure data of the small one, as in the references."""
    root = tmp_path_factory.mktemp("kept")
    (root / "tables").symlink_to(ROOT / "tests/reference/full/tables")
    (root / "data").symlink_to(ROOT / "tests/reference/data")
    return root


@pytest.mark.parametrize("name", COMPARED)
def test_a_run_bears_every_remark_on_the_article_and_a_flat_one_none(name, kept):
    figure = SPECS[name]
    disagreement, agreement = figure.compared(ResultTables(kept))
    assert len(disagreement) == len(figure.disagreement)
    assert len(agreement) == len(figure.agreement)
    assert not any("{" in remark for remark in disagreement + agreement)
    assert figure.compared(FlatTables(kept)) == ([], [])


def test_a_run_without_the_tables_bears_no_remark(tmp_path):
    assert SPECS["fig06"].compared(ResultTables(tmp_path)) == ([], [])
