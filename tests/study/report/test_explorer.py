"""The explorer in a browser: its numbers against the kernel's, and its use by hand and keyboard."""

from __future__ import annotations

import json
import re
import shutil
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.shared import ROOT
from tests.study.report.pages import emulate, overflow, violations

from microimpact.core.files import write_file
from microimpact.core.materials import Material
from microimpact.model.choices import FRICTION_BASES, NUMBERS
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate, velocity_components
from microimpact.model.dynamics.normal import normal_impact
from study.contacts import calibrated_contact
from study.report.explorer.build import MATERIAL, page_files
from study.report.site.figures import explored
from study.report.site.pages import ASSETS
from study.tables import parse_table, read_table, text_rows

pytestmark = pytest.mark.slow

# Largest relative error where the speed is this much, relatively, above the threshold.
RELATIVE = 1e-9
CLEAR = 1e-2
# What JSON cannot carry is infinite: the diameter of a plane.
BY_PAGE = """
return arguments[0].map((c) => {
  c.partner_diameter ??= Infinity;
  return { ...Explorer.impact(c), limit: Explorer.captureVelocity(c) };
});
"""


@pytest.fixture(scope="module")
def inputs(settings):
    declared = settings.tables.whole(("materials", "contacts"))
    calibration = read_table(ROOT / "tests/reference/tables/calibration.csv")
    return {name: parse_table(text) for name, text in declared.items()} | {
        "calibration": calibration
    }


@pytest.fixture(scope="module")
def files(inputs):
    return page_files(inputs)


@pytest.fixture(scope="module")
def page(files, tmp_path_factory):
    """The page in a folder, with the site's styles: all it needs."""
    folder = tmp_path_factory.mktemp("report")
    for name, text in files.items():
        write_file(folder / name, text)
    shutil.copytree(ASSETS, folder / "assets")
    return folder / "explorer.html"


@pytest.fixture
def browser(chromium, page):
    """The page as it opens; afterwards nothing may have been reported on the console."""
    emulate(chromium, (1300, 1000))
    visit(chromium, page.as_uri())
    yield chromium
    assert [line["message"] for line in chromium.get_log("browser")] == []


def visit(driver, address):
    """Open the page anew, also where only the fragment of the address differs."""
    from selenium.webdriver.support.ui import WebDriverWait

    driver.get("about:blank")
    driver.get(address)
    ready = "return document.readyState === 'complete' && Boolean(globalThis.Page)"
    WebDriverWait(driver, 20).until(lambda now: now.execute_script(ready))


def text(browser, name):
    return browser.find_element("id", name).text


def settled(browser):
    """Let the page's next frame, in which it computes, pass."""
    script = "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(done));"
    browser.execute_async_script(script)


def type_into(browser, name, value):
    field = browser.find_element("id", name)
    if not field.is_displayed():
        browser.execute_script("arguments[0].closest('details').open = true;", field)
    field.clear()
    field.send_keys(value)
    settled(browser)


def outputs(browser):
    script = "return [...document.querySelectorAll('[id^=out_]')].map((cell) => cell.textContent)"
    return browser.execute_script(script)


def test_calibrated_cases_and_declared_pairs_are_offered_in_si(inputs):
    """A pair that is calibrated is offered once, as its cases; here one more is declared."""
    pairs = inputs["contacts"]
    other = pairs[pairs["surface"] == "mica"].assign(particle="glass", surface="silicon")
    files = page_files({**inputs, "contacts": pd.concat([pairs, other])})
    carried = re.search(r'id="numbers">(.*?)</script>', files["explorer.html"], re.DOTALL)
    data = json.loads(carried.group(1))
    contacts = {row["contact"]: row for row in data["contacts"]}
    assert len(contacts) == len(data["contacts"])
    offered = {name for name, row in contacts.items() if row["origin"] == "declared"}
    assert offered == {"glass on silicon"}
    assert set(contacts) - offered == set(inputs["calibration"]["case"])
    pair = contacts["glass on silicon"]
    assert (pair["particle"], pair["surface"]) == ("glass", "silicon")
    assert pair["diameter"] == pytest.approx(4.9e-6)
    assert pair["reference_velocity"] is None
    rows = inputs["calibration"].set_index(["case", "quantity"])["value"]
    for name in ("diameter", "work_of_adhesion", "hertz_damping", "adhesion_damping"):
        known = float(rows["steel-silicon, n = 1", name])
        assert contacts["steel-silicon, n = 1"][name] == known
    materials = {row["material"]: row for row in data["materials"]}
    assert materials["stainless-steel-316"]["youngs_modulus"] == pytest.approx(193e9)


# ---- its numbers --------------------------------------------------------------------------------


def random_impacts(count, *, pair=False):
    """Draw contacts and impacts from sticky to bouncy, slow to fast."""
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(20011, spawn_key=(121, 1))))

    def log_uniform(low, high, zero=0.0):
        drawn = np.exp(rng.uniform(np.log(low), np.log(high), count))
        return np.where(rng.uniform(size=count) < zero, 0.0, drawn)

    particle, surface = (
        Material(
            name=name,
            youngs_modulus=log_uniform(1e9, 300e9),
            poissons_ratio=rng.uniform(0.0, 0.45, count),
            density=log_uniform(900.0, 9000.0),
        )
        for name in "ps"
    )
    diameter = log_uniform(0.5e-6, 200e-6)
    contact = Contact(
        particle=particle,
        surface=surface,
        diameter=diameter,
        work_of_adhesion=log_uniform(1e-3, 5.0, zero=0.05),
        hertz_damping=log_uniform(1e-3, 0.5, zero=0.2),
        adhesion_damping=log_uniform(1e-2, 5.0, zero=0.2),
        adhesion_rate_exponent=rng.choice([0.0, 0.0, 0.5, 1.0, 1.5], count),
        reference_velocity=log_uniform(0.5, 3.0),
        friction=rng.uniform(0.0, 0.6, count),
        **({"partner_diameter": diameter * log_uniform(0.1, 30.0)} if pair else {}),
    )
    speed, turning = log_uniform(1e-6, 1e3), rng.choice([0.0, 1.0], count)
    spin = turning * rng.standard_normal(count) * speed / contact.radius
    return contact, {
        "speed": speed,
        "angle": rng.uniform(2.0, 90.0, count),
        "spin": spin,
        "partner_spin": spin * rng.standard_normal(count) * pair,
    }


def by_page(browser, contact, impact, basis="compressive"):
    """The outcomes in the browser: one array per quantity; what JSON cannot carry is infinite."""
    count = impact["speed"].size

    def rows(source, names):
        columns = [np.broadcast_to(getattr(source, name), count).tolist() for name in names]
        lists = ([None if np.isinf(x) else x for x in column] for column in columns)
        return [dict(zip(names, row, strict=True)) for row in zip(*lists, strict=True)]

    bodies = (rows(body, MATERIAL) for body in (contact.particle, contact.surface))
    fields = (*NUMBERS, "partner_diameter")
    parts = zip(
        *bodies, rows(contact, fields), rows(SimpleNamespace(**impact), impact), strict=True
    )
    arguments = [
        {"particle": p, "surface": s, "basis": basis, **own, **given} for p, s, own, given in parts
    ]
    outcomes = browser.execute_script(BY_PAGE, arguments)
    return {
        name: np.array([np.inf if one[name] is None else one[name] for one in outcomes])
        for name in outcomes[0]
    }


def relative(found, exact, name, chosen):
    """The largest relative error of one quantity among the chosen impacts."""
    known = getattr(exact, name)[chosen]
    return np.max(np.abs(found[name][chosen] - known) / np.maximum(np.abs(known), 1e-300))


def stated_errors(files):
    """The bounds that the page states: of e, and of the capture velocity relative to itself."""
    said = re.findall(r"<strong>10⁻([⁰¹²³⁴⁵⁶⁷⁸⁹]+)</strong>", files["explorer.html"])
    powers = ["".join(str("⁰¹²³⁴⁵⁶⁷⁸⁹".index(digit)) for digit in power) for power in said]
    restitution, limit = (10.0 ** -int(power) for power in powers)
    return restitution, limit


@pytest.mark.parametrize("pair", [False, True])
@pytest.mark.parametrize("basis", FRICTION_BASES)
def test_impacts_are_those_of_the_kernel(browser, basis, pair):
    contact, impact = random_impacts(600, pair=pair)
    exact = simulate(contact, **impact, friction_basis=basis)
    found = by_page(browser, contact, impact, basis)
    assert not np.any(found["unsolved"])
    for name in ("captured", "rolling"):
        assert np.array_equal(found[name], getattr(exact, name)), name
    assert 200 < exact.captured.sum() < 400
    assert np.sum(~exact.rolling) > 80

    for name in ("coefficient_of_restitution", "contact_time", "impulse_ratio"):
        assert relative(found, exact, name, ~exact.captured) < RELATIVE, name
    second = contact.partner_diameter / 2.0 if pair else 0.0
    turning = (np.abs(impact[name]) for name in ("spin", "partner_spin"))
    surface = impact["speed"] + sum(
        w * r for w, r in zip(turning, (contact.radius, second), strict=True)
    )
    for name, scale in {
        "spin": surface / contact.radius,
        "normal_velocity": surface,
        "tangential_velocity": surface,
        "energy_loss": (surface / impact["speed"]) ** 2,
        "translational_energy_loss": (surface / impact["speed"]) ** 2,
        **({"partner_spin": surface / second} if pair else {}),
    }.items():
        assert np.max(np.abs(found[name] - getattr(exact, name)) / scale) < RELATIVE, name


def test_impacts_near_the_threshold_are_those_of_the_kernel(browser, files):
    contact, impact = random_impacts(900)
    limit = capture_velocity(contact)
    near = (limit > 0.0) & (limit < 1e3)
    assert near.sum() > 500
    # From 1e-6 to 1e-1 above the capture velocity, half of them below.
    distance = np.geomspace(1e-6, 1e-1, limit.size) * np.where(np.arange(limit.size) % 2, -1, 1)
    speed = limit * (1.0 + distance) / np.sin(np.radians(impact["angle"]))
    impact["speed"] = np.where(near, speed, 1.0)
    exact = simulate(contact, **impact)
    found = by_page(browser, contact, impact)
    assert np.array_equal(found["captured"][near], distance[near] < 0.0)
    error = np.abs(found["coefficient_of_restitution"] - exact.coefficient_of_restitution)
    assert np.max(error[near]) < stated_errors(files)[0]
    clear = near & (distance > CLEAR)
    assert clear.sum() > 50
    for name in ("coefficient_of_restitution", "contact_time", "impulse_ratio"):
        assert relative(found, exact, name, clear) < RELATIVE, name


@pytest.mark.parametrize("pair", [False, True])
def test_capture_velocities_are_those_of_the_kernel(browser, files, pair):
    contact, impact = random_impacts(600, pair=pair)
    exact, found = capture_velocity(contact), by_page(browser, contact, impact)["limit"]
    assert np.array_equal(np.isinf(found), np.isinf(exact))
    assert np.array_equal(found == 0.0, exact == 0.0)
    finite = np.isfinite(exact) & (exact > 0.0)
    assert min(finite.sum(), np.isinf(exact).sum(), (exact == 0.0).sum()) > 20
    assert np.max(np.abs(found[finite] / exact[finite] - 1.0)) < stated_errors(files)[1]


def test_shares_of_the_energy_add_up_and_follow_the_ledger(browser):
    contact, impact = random_impacts(300)
    found = by_page(browser, contact, impact)
    names = found["shares"][0]
    shares = {name: np.array([one[name] for one in found["shares"]]) for name in names}
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-12)
    assert np.min(list(shares.values())) >= 0.0
    v_n = velocity_components(impact["speed"], impact["angle"])[0]
    energy = np.square(impact["speed"]) + 0.4 * np.square(impact["spin"] * contact.radius)
    ledger = normal_impact(contact, -v_n, ledger=True).ledger
    for name in ("hertz", "adhesion"):
        known = getattr(ledger, f"{name}_work") / (contact.mass / 2.0 * energy)
        free = ~found["captured"]
        assert shares[f"{name}_damping"][free] == pytest.approx(known[free], abs=1e-11)


# ---- its use ------------------------------------------------------------------------------------


def test_a_choice_of_material_sets_its_constants_and_own_numbers_are_named_so(browser):
    from selenium.webdriver.support.select import Select

    Select(browser.find_element("id", "surface")).select_by_value("mica")
    settled(browser)
    assert browser.find_element("id", "surface_E").get_attribute("value") == "57"
    assert browser.find_element("id", "contact").get_attribute("value") == "own numbers"
    type_into(browser, "surface_E", "60")
    assert browser.find_element("id", "surface").get_attribute("value") == "own numbers"
    Select(browser.find_element("id", "contact")).select_by_value("steel-silicon, n = 0")
    settled(browser)
    assert browser.find_element("id", "surface").get_attribute("value") == "silicon"
    assert text(browser, "out_vc") == "0.1800 m/s"


def test_a_link_that_names_what_the_page_lacks_says_so(browser, page):
    visit(browser, page.as_uri() + "#contact=nosuch&foo=1&basis=hertz&v=0.5")
    said = text(browser, "link_problem")
    assert "“foo”, “contact=nosuch”" in said
    assert "basis" not in said
    assert browser.find_element("id", "v").get_attribute("value") == "0.5"
    visit(browser, page.as_uri() + "#v=0.5")
    assert not browser.find_element("id", "link_problem").is_displayed()


def test_bad_input_gives_a_message_for_each_field_and_no_numbers(browser):
    wrong = {"d": "1e9", "D": "0", "angle": "91", "v": "", "w": "1e400", "spin2": "3"}
    for name, typed in wrong.items():
        type_into(browser, name, typed)
    type_into(browser, "D", "inf")
    del wrong["D"]
    said = text(browser, "problem")
    assert "Diameter “1e9”: it must be greater than 0 and up to 10000 µm." in said
    assert "Speed is empty: " in said
    assert "Spin of the second sphere: a plane does not spin." in said
    marked = browser.find_elements("css selector", "[aria-invalid=true][aria-describedby=problem]")
    assert {field.get_attribute("id") for field in marked} == set(wrong)
    assert set(outputs(browser)) == {"–"}
    assert browser.find_elements("css selector", ".x-plots svg *") == []
    for name in wrong:
        type_into(browser, name, "0" if name == "spin2" else "0.4")
    assert not browser.find_element("id", "problem").is_displayed()
    assert "–" not in outputs(browser)


def test_what_takes_too_many_steps_is_said_and_not_shown(browser):
    for name, typed in (("w", "0"), ("cH", "1e5")):
        type_into(browser, name, typed)
    assert text(browser, "problem").startswith("Damping or adhesion is too strong at this speed: ")
    assert set(outputs(browser)) == {"–"}
    type_into(browser, "cH", "1")
    assert "–" not in outputs(browser)


def test_a_link_restores_the_state(browser, page):
    type_into(browser, "v", "0.77")
    type_into(browser, "angle", "33")
    type_into(browser, "spin", "-4000")
    type_into(browser, "D", "80")
    browser.find_element("css selector", "#basis option[value=hertz]").click()
    settled(browser)
    link, shown = browser.find_element("id", "permalink").get_attribute("href"), outputs(browser)
    assert browser.current_url == link
    visit(browser, link)
    assert outputs(browser) == shown
    assert browser.find_element("id", "basis").get_attribute("value") == "hertz"
    browser.find_element("id", "reset").click()
    assert outputs(browser) != shown


def test_a_figure_opens_it_with_its_impact(browser, page, inputs, results):
    declared = text_rows(results / "tables/inputs.csv")
    visit(browser, f"{page.as_uri()}#{explored('fig20_force_history', declared)}")
    case = "fluorescein-molybdenum, nominal"
    assert browser.find_element("id", "contact").get_attribute("value") == case
    assert text(browser, "out_vn") == "5.200 m/s"
    known = calibrated_contact(inputs, case)
    assert text(browser, "out_vc") == f"{capture_velocity(known):#.4g} m/s"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1300, 1000), (390, 844)])
def test_it_is_accessible_and_fits_the_window(browser, scheme, size):
    emulate(browser, size, scheme)
    type_into(browser, "v", "0.21")
    assert overflow(browser) == 0
    assert violations(browser, scheme) == []
