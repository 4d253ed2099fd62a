"""The documentation builds into a site without a warning, and shows the public names."""

from __future__ import annotations

import re
import sys

import pytest
from tests.docs.blocks import PAGES, ROOT
from tests.shared import execute

import microimpact

SPHINX = (sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    target = tmp_path_factory.mktemp("site")
    execute(*SPHINX, "-d", target / "doctrees", ROOT / "docs", target / "html")
    return target / "html"


def test_every_page_is_in_the_navigation_once():
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    entries = re.findall(r"^([\w/-]+)$", index, flags=re.MULTILINE)
    pages = [page.stem for page in (ROOT / "docs").glob("*.md") if page.stem != "index"]
    pages += [f"notebooks/{page.stem}" for page in (ROOT / "docs/notebooks").glob("*.ipynb")]
    assert sorted(entries) == sorted([*pages, "api/index"])


@pytest.mark.slow
def test_every_page_and_every_exported_name_is_there(site):
    for page in PAGES:
        if page.startswith("docs/"):
            assert (site / page.removeprefix("docs/")).with_suffix(".html").is_file()
    described = "".join(path.read_text(encoding="utf-8") for path in (site / "api").glob("*.html"))
    for name in microimpact.__all__:
        value = getattr(microimpact, name)
        if callable(value):
            assert f'id="{value.__module__}.{value.__qualname__}"' in described


@pytest.mark.slow
def test_nothing_is_fetched(site):
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        fetched = re.findall(r"<(?:script|img|link|iframe)\b[^>]*(?:src|href)=\"(\w+:)?//", text)
        assert not fetched, path.name
