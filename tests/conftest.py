"""What all tests share."""

from __future__ import annotations

import pytest
from tests.forks import forking


@pytest.fixture(scope="session")
def forked():
    """What stands for ``python`` in a command ``python -m NAME ...`` that is to start quickly."""
    with forking() as python:
        yield python


def pytest_collection_modifyitems(items):
    """Put the longest files first: workers then end at about the same time."""
    items.sort(key=lambda item: item.get_closest_marker("workflow") is None)
