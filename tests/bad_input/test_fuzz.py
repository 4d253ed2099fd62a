"""Readers of CSV and YAML give a result or their own error, whatever bytes they meet."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.bad_input.conftest import ROOT

from microimpact.declared.documents import ConfigError, load
from microimpact.declared.selection import MATERIAL_COLUMNS, SelectionError, read_declared
from microimpact.figures.registry import RegistryError, registry
from microimpact.ledgers.claims.criteria import ClaimsError, read_claims
from microimpact.run.digitised import DigitisedError, read_points

fuzz = settings(
    deadline=None,
    derandomize=True,
    max_examples=150,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)

# Pieces that the grammars know, so that not all falls at the first hurdle.
csv_text = st.lists(
    st.one_of(
        st.sampled_from(
            [",", "\n", "\r\n", '"', "# source: a", "series,x,y,y_low,y_high", "1.0", "nan",
             "1e999", "-", ",".join(MATERIAL_COLUMNS), "a,density,1,kg/m3,,,found,b"]
        ),
        st.text(max_size=6),
    ),
    max_size=30,
).map("".join)  # fmt: skip
yaml_text = st.lists(
    st.one_of(
        st.sampled_from(
            ["a: ", "b:\n", "  ", "- ", "{", "}", "[", "]", "&x ", "*x", "<<: ", "!!int ", "| ",
             "\n", "'", '"', "#", "1e3", "? ", "--- ", "...\n", "2001-02-03", "!!python/none ~"]
        ),
        st.text(max_size=4),
    ),
    max_size=30,
).map("".join)  # fmt: skip
spoilt = st.tuples(st.integers(0, 10**9), st.integers(0, 40), st.binary(max_size=8))


def one_line_each(error):
    told = str(error)
    assert told.strip()
    assert len(told) < 20_000
    assert all(line.strip() for line in told.splitlines())


def written(tmp_path, content):
    file = tmp_path / "fig16.csv"
    file.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "replace"))
    return str(file)


def spoil(content, change):
    """Replace some bytes of a file."""
    place, length, piece = change
    start = place % (len(content) + 1)
    return content[:start] + piece + content[start + length :]


@pytest.fixture(scope="module")
def figure():
    entries = load(ROOT / "config/figures.yaml")
    words = str(entries["fig16"])
    assert "[[" not in words
    return registry({"fig16": entries["fig16"]})["fig16"]


@fuzz
@given(content=st.one_of(csv_text, st.binary(max_size=60)))
def test_a_declared_table(tmp_path, content):
    try:
        table = read_declared(written(tmp_path, content), MATERIAL_COLUMNS)
    except SelectionError as error:
        one_line_each(error)
    else:
        assert table.columns == MATERIAL_COLUMNS


@fuzz
@given(change=spoilt)
def test_a_spoilt_declared_table(tmp_path, change):
    shipped = (ROOT / "config/materials.csv").read_bytes()
    try:
        read_declared(
            written(tmp_path, spoil(shipped, change)), MATERIAL_COLUMNS, ("value", "low", "high")
        )
    except SelectionError as error:
        one_line_each(error)


@fuzz
@given(content=st.one_of(csv_text, st.binary(max_size=60)))
def test_digitised_points(tmp_path, figure, content):
    try:
        points = read_points(written(tmp_path, content), figure)
    except DigitisedError as error:
        one_line_each(error)
    else:
        assert len(points.table)
        assert points.table[["x", "y"]].notna().all(axis=None)


@fuzz
@given(content=st.one_of(yaml_text, st.binary(max_size=60)))
def test_a_document(tmp_path, content):
    try:
        found = load(written(tmp_path, content))
    except ConfigError as error:
        one_line_each(error)
    else:
        assert isinstance(found, dict)


@settings(fuzz, max_examples=25)
@given(change=spoilt)
def test_spoilt_claims(tmp_path, change):
    shipped = (ROOT / "config/claims.yaml").read_bytes()
    try:
        read_claims(written(tmp_path, spoil(shipped, change)))
    except (ConfigError, ClaimsError) as error:
        one_line_each(error)


@fuzz
@given(
    entries=st.dictionaries(
        st.text(st.characters(categories=["L", "N", "P"]), min_size=1, max_size=8),
        st.recursive(
            st.one_of(st.none(), st.booleans(), st.floats(), st.text(max_size=5)),
            lambda inner: st.one_of(
                st.lists(inner, max_size=3),
                st.dictionaries(
                    st.sampled_from(["title", "data", "panels", "series", "x_range", "width"]),
                    inner,
                ),
            ),
            max_leaves=8,
        ),
        max_size=3,
    )
)
def test_a_figure_registry(entries):
    try:
        registry(entries)
    except RegistryError as error:
        one_line_each(error)
