"""The site in a browser, from its files: no errors, sorting and filtering, access for all."""

from __future__ import annotations

from importlib.resources import files

import pytest

# Rows of one template: a dozen of each table show what all of them have.
ALIKE = "tbody tr:nth-child(n+13)"
PHONE, DESK = (360, 740), (1280, 900)
REPRESENTATIVE = (
    *("index.html", "claims.html", "equations.html", "tables.html", "figures.html", "run.html"),
    *("figures/fig01.html", "figures/fig06.html", "figures/ridge.html"),
)
pytestmark = pytest.mark.slow


def resize(chromium, size):
    width, height = size
    chromium.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600},
    )


@pytest.fixture
def show(chromium, site):
    """Open a page at a width and in a scheme of colours."""

    def opened(page, size=DESK, scheme="light"):
        resize(chromium, size)
        scheme = [{"name": "prefers-color-scheme", "value": scheme}]
        chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})
        path, _, place = page.partition("#") if isinstance(page, str) else (page, "", "")
        chromium.get((site / path).as_uri() + (f"#{place}" if place else ""))
        return chromium

    return opened


def said(chromium):
    return [entry["message"] for entry in chromium.get_log("browser")]


def require_fit(chromium, size, page):
    """Demand that nothing of a page lies beyond the width of its window."""
    width, window = chromium.execute_script(
        "return [document.documentElement.scrollWidth, window.innerWidth]"
    )
    assert window == size[0]
    assert width <= size[0], page


def test_no_page_has_an_error_or_a_warning_or_is_wider_than_a_phone(show, site, chromium):
    said(chromium)
    for path in sorted(site.rglob("*.html")):
        show(path.relative_to(site), PHONE)
        assert said(chromium) == [], path.name
        broken = chromium.execute_script(
            "return [...document.images].filter(i => i.loading !== 'lazy' && !i.naturalWidth)"
            ".map(i => i.src)"
        )
        assert broken == [], path.name
        require_fit(chromium, PHONE, path.name)


def test_the_policy_forbids_the_network(show, chromium):
    show("index.html")
    refused = chromium.execute_async_script(
        "const done = arguments[0];"
        "addEventListener('securitypolicyviolation', e => done(e.effectiveDirective));"
        "const i = new Image(); i.src = 'http://127.0.0.1:9/x.png'; document.body.append(i);"
        "setTimeout(() => done('nothing was refused'), 2000);"
    )
    assert refused == "img-src"
    said(chromium)


@pytest.mark.parametrize(
    ("page", "scheme"),
    [(page, "light") for page in REPRESENTATIVE]
    + [(page, "dark") for page in ("index.html", "claims.html", "figures/fig06.html")],
)
def test_axe_finds_nothing_serious_and_the_page_fits_its_window(show, page, scheme):
    chromium = show(page, scheme=scheme)
    assert said(chromium) == []
    for size in ((768, 1024), (1024, 768), DESK):
        resize(chromium, size)
        require_fit(chromium, size, page)
    axe = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    chromium.execute_script(axe)
    found = chromium.execute_async_script(
        "const done = arguments[2];"
        "axe.run({exclude: [[arguments[0]]]}, {resultTypes: ['violations'], ...arguments[1]})"
        ".then(r => done(r.violations.map(v => [v.impact, v.id, v.nodes.length,"
        " v.nodes[0].html.slice(0, 200), v.nodes[0].any.map(a => a.message)[0]])));",
        ALIKE,
        # The scheme changes nothing but colours.
        {"runOnly": ["color-contrast"]} if scheme == "dark" else {},
    )
    assert [v for v in found if v[0] in {"serious", "critical"}] == []


def column(chromium, number):
    return chromium.execute_script(
        "return [...document.querySelector('table').tBodies[0].rows].filter(r => !r.hidden)"
        ".map(r => r.cells[arguments[0]].textContent.trim())",
        number,
    )


def test_claims_are_filtered_by_verdict_and_text(show):
    chromium = show("claims.html")
    first = column(chromium, 0)
    chromium.find_element("name", "first").click()
    every = column(chromium, 0)
    assert 0 < len(first) < len(every)
    for box in chromium.find_elements("css selector", ".filter fieldset input"):
        if box.get_attribute("value") != "not reproduced":
            box.click()
    verdicts = [text.splitlines()[0].strip() for text in column(chromium, 3)]
    assert set(verdicts) == {"not reproduced"}
    assert 0 < len(verdicts) < len(every)
    status = chromium.find_element("css selector", ".filter [role=status]")
    assert status.text == f"{len(verdicts)} of {len(every)} claims shown"
    chromium.find_element("css selector", ".filter input[type=search]").send_keys("FRICTION")
    left = chromium.execute_script(
        "return [...document.querySelector('table').tBodies[0].rows].filter(r => !r.hidden)"
        ".map(r => r.textContent.toLowerCase())"
    )
    assert 0 < len(left) < len(verdicts)
    assert all("friction" in text for text in left)


def test_a_link_to_a_filtered_row_shows_it(show, chromium):
    show("claims.html")
    for box in chromium.find_elements("css selector", ".filter input[type=checkbox]"):
        box.click()
    assert column(chromium, 0) == []
    chromium.execute_script("location.hash = 'C19'")
    chromium.execute_async_script("setTimeout(arguments[0], 50)")
    assert chromium.find_element("id", "C19").is_displayed()


def test_all_is_readable_without_scripts(show, chromium):
    chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        show("claims.html")
        rows = chromium.find_elements("css selector", "tbody tr")
        assert len(rows) > 100
        assert rows[-1].is_displayed()
        assert not chromium.find_element("css selector", ".filter").is_displayed()
    finally:
        chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
