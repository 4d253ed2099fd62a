"""Every declared parameter is read: by a study, or by the words of a figure or claim."""

from __future__ import annotations

import dataclasses
import re
import sys
from collections.abc import Mapping
from functools import cache

import pytest
from tests.shared import ROOT
from tests.workflow.conftest import TINY

from study import analyses
from study.declared.documents import load
from study.declared.parameters import build
from study.declared.references import merged
from study.run.config import read_configuration, validate
from study.run.study import run_with

pytestmark = pytest.mark.slow

# Read before all else: the class that a mapping stands for, and rows that come as tables.
CHOICES = {"kind", "external", "anchors"}
# Methods of all dataclasses, which take every field.
OF_ALL = {"__eq__", "__hash__", "__repr__", "replace", "_replace"}


def records(value):
    """Yield every dataclass in a value."""
    items = ()
    if dataclasses.is_dataclass(value):
        yield value
        items = (object.__getattribute__(value, f.name) for f in dataclasses.fields(value))
    elif isinstance(value, Mapping | tuple | list):
        items = value.values() if isinstance(value, Mapping) else value
    for item in items:
        yield from records(item)


def in_words():
    """Return the names of parameters that figures and claims show."""
    folders = (ROOT / f"src/study/{name}" for name in ("analyses", "claims"))
    texts = (path.read_text() for folder in folders for path in folder.rglob("*.py"))
    shown = re.findall(r"\[\[([\w.]+)", "".join(texts))
    return {name.rpartition(".")[2] for name in shown}


def test_every_parameter_is_read(monkeypatch):
    shipped = read_configuration(ROOT / "config")
    settings = validate(merged(merged(shipped, load(ROOT / "config/ci.yaml")), TINY), shipped)
    declared, read = set(), set()

    def reading(record, name):
        if sys._getframe(1).f_code.co_name not in OF_ALL:
            read.add((type(record), name))
        return object.__getattribute__(record, name)

    def watched(kind, values):
        for record in records(build(kind, values)):
            required = [f for f in dataclasses.fields(record) if f.default is dataclasses.MISSING]
            declared.update((type(record), field.name) for field in required)
            monkeypatch.setattr(type(record), "__getattribute__", reading)
        return build(kind, values)

    monkeypatch.setattr("study.run.study.build", watched)

    @cache
    def tables(study):
        needed = {table: tables(maker)[table] for table, maker in analyses.needs(study).items()}
        return run_with(study, settings.branches[study], settings.rows[study], needed)

    for study in analyses.homes():
        tables(study)
    unread = {(kind, name) for kind, name in declared - read if name not in CHOICES | in_words()}
    names = sorted(f"{kind.__module__}.{kind.__name__}.{name}" for kind, name in unread)
    assert not names, "\n".join(names)
