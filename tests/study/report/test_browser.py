"""The site in a browser, from its files: no errors, filtering, access for all."""

from __future__ import annotations

import pytest
from tests.study.report.pages import emulate, overflow, violations

# Rows of one template: a dozen of each table show what all of them have.
ALIKE = "tbody tr:nth-child(n+13)"
PHONE, DESK = (360, 740), (1280, 900)
LIGHT = (
    *("index.html", "claims.html", "equations.html", "tables.html", "figures.html", "run.html"),
    *("figures/fig01.html", "figures/fig06.html", "figures/ridge.html"),
)
DARK = ("index.html", "claims.html", "figures/fig06.html")
pytestmark = pytest.mark.slow


@pytest.fixture
def show(chromium, site):
    """Open a page, whose console must stay empty."""
    chromium.get_log("browser")

    def opened(page, size=DESK, scheme="light"):
        emulate(chromium, size, scheme)
        chromium.get((site / page).as_uri())
        assert [entry["message"] for entry in chromium.get_log("browser")] == [], page
        return chromium

    return opened


def test_no_page_has_an_error_or_a_warning_or_is_wider_than_a_phone(show, site):
    for path in sorted(site.rglob("*.html")):
        chromium = show(path.relative_to(site), PHONE)
        broken = chromium.execute_script(
            "return [...document.images].filter(i => i.loading !== 'lazy' && !i.naturalWidth)"
            ".map(i => i.src)"
        )
        assert broken == [], path.name
        assert overflow(chromium) == 0, path.name


@pytest.mark.parametrize(
    ("page", "scheme"),
    [*((page, "light") for page in LIGHT), *((page, "dark") for page in DARK)],
)
def test_axe_finds_nothing_serious_and_the_page_fits_its_window(show, page, scheme):
    for size in ((768, 1024), (1024, 768), DESK):
        chromium = show(page, size, scheme)
        assert overflow(chromium) == 0, size
    assert violations(chromium, scheme, ALIKE) == []


def shown(chromium):
    """The rows of the table that are not hidden, each as the texts of its cells."""
    return chromium.execute_script(
        "return [...document.querySelector('table').tBodies[0].rows].filter(r => !r.hidden)"
        ".map(r => [...r.cells].map(c => c.textContent.trim()))"
    )


def test_claims_are_filtered_by_verdict_and_text_and_a_link_shows_its_row(show):
    chromium = show("claims.html")
    first = shown(chromium)
    chromium.find_element("name", "first").click()
    every = shown(chromium)
    assert 0 < len(first) < len(every)
    boxes = chromium.find_elements("css selector", ".filter fieldset input")
    for box in boxes:
        if box.get_attribute("value") != "not reproduced":
            box.click()
    failed = shown(chromium)
    assert {cells[3].splitlines()[0].strip() for cells in failed} == {"not reproduced"}
    status = chromium.find_element("css selector", ".filter [role=status]")
    assert status.text == f"{len(failed)} of {len(every)} claims shown"
    chromium.find_element("css selector", ".filter input[type=search]").send_keys("DROP HEIGHT")
    left = shown(chromium)
    assert 0 < len(left) < len(failed) < len(every)
    assert all("drop height" in " ".join(cells).lower() for cells in left)
    chromium.execute_script("location.hash = 'C19'")
    chromium.execute_async_script("setTimeout(arguments[0], 50)")
    assert chromium.find_element("id", "C19").is_displayed()
