"""The site in a browser, from its files: no errors, sorting and filtering, access for all."""

from __future__ import annotations

import os
import shutil
from importlib.resources import files

import pytest

# Rows of one template: a dozen of each table show what all of them have.
ALIKE = "tbody tr:nth-child(n+13)"
PHONE, DESK = (360, 740), (1280, 900)
REPRESENTATIVE = (
    *("index.html", "claims.html", "equations.html", "tables.html", "workflow.html", "run.html"),
    *("figures/fig01.html", "figures/fig06.html", "figures/ridge.html"),
)
ARGUMENTS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    tools = {name: shutil.which(name) for name in ("chromium", "chromedriver")}
    if missing := [name for name, path in tools.items() if path is None]:
        message = f"needs {' and '.join(missing)} (Debian: chromium, chromium-driver)"
        if os.environ.get("MICROIMPACT_REQUIRE_TOOLS"):
            pytest.fail(message)
        pytest.skip(message)
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = tools["chromium"]
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for argument in ARGUMENTS:
        options.add_argument(argument)
    options.add_argument(f"--user-data-dir={tmp_path_factory.mktemp('browser')}")
    driver = webdriver.Chrome(
        options=options, service=webdriver.ChromeService(tools["chromedriver"])
    )
    yield driver
    driver.quit()


@pytest.fixture
def show(browser, site):
    """Open a page at a width and in a scheme of colours."""

    def opened(page, size=DESK, scheme="light"):
        command = browser.execute_cdp_cmd
        width, height = size
        command(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600},
        )
        scheme = [{"name": "prefers-color-scheme", "value": scheme}]
        command("Emulation.setEmulatedMedia", {"features": scheme})
        browser.get((site / page).as_uri())
        return browser

    return opened


def said(browser):
    return [entry["message"] for entry in browser.get_log("browser")]


def test_no_page_has_an_error_or_a_warning(show, site, browser):
    said(browser)
    for path in sorted(site.rglob("*.html")):
        show(path.relative_to(site))
        assert said(browser) == [], path.name
        broken = browser.execute_script(
            "return [...document.images].filter(i => i.loading !== 'lazy' && !i.naturalWidth)"
            ".map(i => i.src)"
        )
        assert broken == [], path.name


def test_the_policy_forbids_the_network(show, browser):
    show("index.html")
    refused = browser.execute_async_script(
        "const done = arguments[0];"
        "addEventListener('securitypolicyviolation', e => done(e.effectiveDirective));"
        "const i = new Image(); i.src = 'http://127.0.0.1:9/x.png'; document.body.append(i);"
        "setTimeout(() => done('nothing was refused'), 2000);"
    )
    assert refused == "img-src"
    said(browser)


@pytest.mark.parametrize(
    ("page", "scheme"),
    [(page, "light") for page in REPRESENTATIVE[:-1]]
    + [(page, "dark") for page in ("index.html", "claims.html", "figures/fig06.html")],
)
def test_axe_finds_nothing_serious(show, page, scheme):
    browser = show(page, scheme=scheme)
    axe = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    browser.execute_script(axe)
    found = browser.execute_async_script(
        "const done = arguments[1];"
        "axe.run({exclude: [[arguments[0]]]}, {resultTypes: ['violations']})"
        ".then(r => done(r.violations.map(v => [v.impact, v.id, v.nodes.length,"
        " v.nodes[0].html.slice(0, 200), v.nodes[0].any.map(a => a.message)[0]])));",
        ALIKE,
    )
    assert [v for v in found if v[0] in {"serious", "critical"}] == []


@pytest.mark.parametrize("size", [PHONE, (768, 1024), (1024, 768), DESK])
def test_no_page_is_wider_than_its_window(show, site, size):
    every = [path.relative_to(site).as_posix() for path in sorted(site.rglob("*.html"))]
    for page in every if size == PHONE else REPRESENTATIVE:
        browser = show(page, size=size)
        width, window = browser.execute_script(
            "return [document.documentElement.scrollWidth, window.innerWidth]"
        )
        assert window == size[0]
        assert width <= size[0], page


def column(browser, number):
    return browser.execute_script(
        "return [...document.querySelectorAll('tbody tr')].filter(r => !r.hidden)"
        ".map(r => r.cells[arguments[0]].textContent.trim())",
        number,
    )


def test_a_table_is_sorted_by_its_headers(show):
    browser = show("tables.html")
    header = browser.find_element("css selector", "thead th:nth-child(2)")
    table = (
        "return [...document.querySelector('table').tBodies[0].rows]"
        ".map(r => +r.cells[1].textContent)"
    )
    before = browser.execute_script(table)
    header.find_element("tag name", "button").click()
    assert header.get_attribute("aria-sort") == "ascending"
    # By value and not as text: 9 before 10.
    assert browser.execute_script(table) == sorted(before) != before
    header.find_element("tag name", "button").click()
    assert header.get_attribute("aria-sort") == "descending"
    assert browser.execute_script(table) == sorted(before, reverse=True)


def test_claims_are_filtered_by_verdict_and_text(show):
    browser = show("claims.html")
    every = column(browser, 0)
    for box in browser.find_elements("css selector", ".filter input[type=checkbox]"):
        if box.get_attribute("value") != "not reproduced":
            box.click()
    verdicts = column(browser, 5)
    assert set(verdicts) == {"not reproduced"}
    assert 0 < len(verdicts) < len(every)
    status = browser.find_element("css selector", ".filter [role=status]")
    assert status.text == f"{len(verdicts)} of {len(every)} claims shown"
    browser.find_element("css selector", ".filter input[type=search]").send_keys("FRICTION")
    left = browser.execute_script(
        "return [...document.querySelectorAll('tbody tr')].filter(r => !r.hidden)"
        ".map(r => r.textContent.toLowerCase())"
    )
    assert 0 < len(left) < len(verdicts)
    assert all("friction" in text for text in left)


def test_a_link_to_a_filtered_row_shows_it(show, browser):
    show("claims.html")
    for box in browser.find_elements("css selector", ".filter input[type=checkbox]"):
        box.click()
    assert column(browser, 0) == []
    browser.execute_script("location.hash = 'C19'")
    browser.execute_async_script("setTimeout(arguments[0], 50)")
    assert browser.find_element("id", "C19").is_displayed()


def test_the_theme_is_chosen_and_kept(show, browser):
    paper = "return getComputedStyle(document.body).backgroundColor"
    show("run.html")
    light = browser.execute_script(paper)
    browser.find_element("css selector", "button.theme").click()
    dark = browser.execute_script(paper)
    assert dark != light
    show("index.html")
    assert browser.execute_script(paper) == dark
    browser.find_element("css selector", "button.theme").click()
    assert browser.execute_script(paper) == light
    browser.execute_script("localStorage.clear()")


def test_a_figure_is_enlarged_and_closed_by_the_keyboard(show, browser):
    from selenium.webdriver.common.keys import Keys

    show("figures/fig06.html")
    browser.find_element("css selector", "a.zoom").send_keys(Keys.ENTER)
    dialog = browser.find_element("css selector", "dialog")
    assert dialog.is_displayed()
    dialog.find_element("tag name", "button").send_keys(Keys.ENTER)
    assert not dialog.is_displayed()


def test_all_is_readable_without_scripts(show, browser):
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        show("claims.html")
        rows = browser.find_elements("css selector", "tbody tr")
        assert len(rows) > 100
        assert rows[-1].is_displayed()
        assert not browser.find_element("css selector", ".filter").is_displayed()
    finally:
        browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
