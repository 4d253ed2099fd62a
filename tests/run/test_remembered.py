"""A configuration is checked once, and again as soon as anything that decides has changed."""

import copy
from pathlib import Path

import pytest

from microimpact.run import remembered
from microimpact.run.config import ConfigError, load, validate

SHIPPED = load(Path(__file__).parents[2] / "config/config.yaml")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "engine/validated.json"


@pytest.fixture
def checks(monkeypatch):
    """Return a list that grows with every check."""
    done = []

    def counted(*arguments):
        done.append(arguments)
        return validate(*arguments)

    monkeypatch.setattr(remembered, "validate", counted)
    return done


def test_what_is_remembered_is_what_was_checked(path, checks):
    first, second = (remembered.validated(SHIPPED, SHIPPED, path) for _ in range(2))
    assert len(checks) == 1
    assert first == second == validate(SHIPPED, SHIPPED)


def test_a_changed_value_is_checked_and_a_bad_one_never_kept(path, checks):
    remembered.validated(SHIPPED, SHIPPED, path)
    mine = copy.deepcopy(SHIPPED)
    mine["chunks"] = 3
    assert remembered.validated(mine, SHIPPED, path).general.chunks == 3
    mine["chunks"] = 0
    for _ in range(2):
        with pytest.raises(ConfigError, match="chunks"):
            remembered.validated(mine, SHIPPED, path)
    assert len(checks) == 4


def test_keys_that_json_would_not_tell_apart_are_told_apart(path):
    mine = SHIPPED | {"seed": {"value": 20011, 1: "one"}}
    other = SHIPPED | {"seed": {"value": 20011, "1": "one"}}
    name = remembered._fingerprint
    assert name(mine, SHIPPED) != name(other, SHIPPED)


def test_a_changed_line_of_the_package_is_a_reason_to_check(path, checks, monkeypatch, tmp_path):
    source = tmp_path / "package/studies/fall.py"
    source.parent.mkdir(parents=True)
    source.write_text("limit = 1\n")
    monkeypatch.setattr(remembered, "PACKAGE", tmp_path / "package")
    for text in ("limit = 1\n", "limit = 2\n"):
        source.write_text(text)
        for _ in range(2):
            remembered.validated(SHIPPED, SHIPPED, path)
    assert len(checks) == 2


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"decided by": 1}', None])
def test_a_damaged_memory_is_no_memory(path, checks, damage):
    kept = remembered.validated(SHIPPED, SHIPPED, path)
    whole = path.read_text()
    path.write_text(whole[: len(whole) // 2] if damage is None else damage)
    assert remembered.validated(SHIPPED, SHIPPED, path) == kept
    assert (len(checks), path.read_text()) == (2, whole)


def test_nowhere_to_remember_is_no_error(path, checks):
    path.parent.write_text("a file where the folder should be")
    for _ in range(2):
        remembered.validated(SHIPPED, SHIPPED, path)
    assert len(checks) == 2
