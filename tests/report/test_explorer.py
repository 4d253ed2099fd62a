"""The explorer in a browser: its numbers against the kernel's, and its use by hand and keyboard."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from microimpact.core.files import write_file
from microimpact.core.materials import Material
from microimpact.core.tables import parse_table, read_table
from microimpact.declared.parameters import build
from microimpact.declared.selection import read_all
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import FRICTION_BASES, simulate, velocity_components
from microimpact.model.dynamics.normal import normal_impact
from microimpact.report.explorer.build import page_files
from microimpact.report.site.pages import ASSETS
from microimpact.run.config import load, validate
from microimpact.studies.models import explorer_tables

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
BY_KERNEL = """
return arguments[0].map((c) => {
  const found = Explorer.impact(c);
  const limit = Explorer.captureVelocity(c);
  return { ...found, limit_kind: limit.kind, limit: limit.value };
});
"""


@pytest.fixture(scope="module")
def tables():
    base = load(ROOT / "config/config.yaml")
    settings = validate(base, base)
    declared = read_all(*(str(ROOT / path) for path in settings.general.tables)).contact_rows()
    inputs = {name: parse_table(text) for name, text in declared.items()}
    inputs["calibration"] = read_table(ROOT / "tests/reference/tables/calibration.csv")
    branch = settings.branches["explorer_tables"]
    return explorer_tables.run(build(explorer_tables.Params, branch), inputs)


@pytest.fixture(scope="module")
def files(tables):
    return page_files(tables, 16.0)


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
    chromium.set_window_size(1300, 1000)
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


# ---- the files ----------------------------------------------------------------------------------


def test_the_page_carries_its_numbers_and_asks_for_nothing_from_outside(files):
    assert sum(len(text.encode()) for text in files.values()) < 1_500_000
    for name, content in files.items():
        addresses = set(re.findall(r"https?://[^\s\"'<>)]+", content))
        assert addresses <= {"http://www.w3.org/2000/svg"}, name
        assert "fetch(" not in content
        assert "import " not in content.replace("important", "") or not name.endswith(".js")
    linked = re.findall(r'(?:src|href)="(explorer/[^"]+)"', files["explorer.html"])
    assert set(linked) == set(files) - {"explorer.html"}


def test_the_same_tables_give_the_same_bytes(tables, files):
    assert page_files(tables, 16.0) == files


def test_stated_errors_are_those_of_the_table(tables, files):
    rows = tables["explorer_accuracy"].set_index("quantity").loc["coefficient_of_restitution"]
    found = re.search(r"<strong>([\d.]+)×10⁻([⁰¹²³⁴⁵⁶⁷⁸⁹])</strong>", files["explorer.html"])
    said = float(found.group(1)) * 10.0 ** -("⁰¹²³⁴⁵⁶⁷⁸⁹".index(found.group(2)))
    assert said == pytest.approx(rows["largest"].max(), rel=0.05)
    assert f"at {rows['points'].sum():,} random points" in files["explorer.html"]


def test_calibrated_cases_and_declared_pairs_are_offered(files):
    data = re.search(r'id="numbers">(.*?)</script>', files["explorer.html"], re.DOTALL)
    names = {row["contact"] for row in json.loads(data.group(1))["contacts"]}
    assert {"steel-silicon, n = 0", "steel-silicon, n = 1"} <= names
    assert "stainless-steel-316 on silicon" in names


# ---- its numbers --------------------------------------------------------------------------------


def random_arguments(count):
    """Draw contacts and impacts within the tables, from sticky to bouncy, in SI units."""
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence(20011, spawn_key=(121, 1))))

    def log_uniform(low, high, zero=0.0):
        drawn = np.exp(rng.uniform(np.log(low), np.log(high), count))
        return np.where(rng.uniform(size=count) < zero, 0.0, drawn)

    c = {
        "E": log_uniform(1e9, 300e9),
        "nu": rng.uniform(0.0, 0.45, count),
        "rho": log_uniform(900.0, 9000.0),
        "E_2": log_uniform(1e9, 300e9),
        "diameter": log_uniform(0.5e-6, 200e-6),
        "work_of_adhesion": log_uniform(1e-3, 5.0, zero=0.05),
        "hertz_damping": log_uniform(1e-3, 0.5, zero=0.2),
        "adhesion_damping": log_uniform(1e-2, 5.0, zero=0.1),
        "adhesion_rate_exponent": rng.choice([0.0, 0.0, 0.5, 1.0, 1.5], count),
        "reference_velocity": log_uniform(0.5, 3.0),
        "friction": rng.uniform(0.0, 0.6, count),
        "speed": log_uniform(0.02, 30.0),
        "angle": rng.uniform(2.0, 90.0, count),
    }
    spin = rng.choice([0.0, 1.0], count) * rng.standard_normal(count)
    c["spin"] = spin * c["speed"] / (c["diameter"] / 2.0)
    normal = c["speed"] * np.sin(np.radians(c["angle"]))
    rate = (c["reference_velocity"] / normal) ** c["adhesion_rate_exponent"]
    damping = normal * (c["adhesion_damping"] * rate + 2.0 * c["hertz_damping"])
    return {name: values[damping < 16.0] for name, values in c.items()}


def contact_of(c):
    particle = Material(name="p", youngs_modulus=c["E"], poissons_ratio=c["nu"], density=c["rho"])
    surface = Material(name="s", youngs_modulus=c["E_2"], poissons_ratio=0.25, density=2000.0)
    fields = (
        *("diameter", "work_of_adhesion", "hertz_damping", "adhesion_damping"),
        *("adhesion_rate_exponent", "reference_velocity", "friction"),
    )
    return Contact(particle=particle, surface=surface, **{name: c[name] for name in fields})


def as_page_takes_it(c, basis):
    own = {"E", "nu", "rho", "E_2"}
    return [
        {name: float(values[i]) for name, values in c.items() if name not in own}
        | {
            "particle": {
                "youngs_modulus": float(c["E"][i]),
                "poissons_ratio": float(c["nu"][i]),
                "density": float(c["rho"][i]),
            },
            "surface": {"youngs_modulus": float(c["E_2"][i]), "poissons_ratio": 0.25},
            "basis": basis,
        }
        for i in range(c["speed"].size)
    ]


@pytest.mark.parametrize("basis", FRICTION_BASES)
def test_numbers_agree_with_the_kernel_within_the_stated_errors(browser, tables, basis):
    c = random_arguments(300)
    contact = contact_of(c)
    exact = simulate(contact, c["speed"], c["angle"], c["spin"], basis)
    found = browser.execute_script(BY_KERNEL, as_page_takes_it(c, basis))
    assert len(found) > 200
    assert not any(one["outside"] for one in found)

    def column(name):
        return np.array([np.inf if one[name] is None else one[name] for one in found])

    stated = tables["explorer_accuracy"].groupby("quantity")["largest"].max()
    # The largest error at some random points may be exceeded a little at others.
    restitution = 2.0 * stated["coefficient_of_restitution"]
    impulse = 2.0 * max(stated[f"{name}_impulse"] for name in ("compressive", "hertz", "peak_net"))
    captured = column("captured").astype(bool)
    assert np.array_equal(captured, exact.captured)
    assert 40 < captured.sum() < captured.size - 80

    e = column("coefficient_of_restitution")
    assert np.max(np.abs(e - exact.coefficient_of_restitution)) < restitution
    ratio = np.abs(column("impulse_ratio") - exact.impulse_ratio)
    assert np.max(ratio / np.maximum(np.abs(exact.impulse_ratio), 1e-12)) < impulse + restitution
    surface_speed = c["speed"] + np.abs(c["spin"]) * contact.radius
    spin = np.abs(column("spin") - exact.spin) * contact.radius
    # A normal impulse of up to 2 m v is split by friction between sliding and spin.
    assert np.max(spin / surface_speed) < 5.0 * impulse
    for name in ("energy_loss", "translational_energy_loss"):
        energy = (surface_speed / c["speed"]) ** 2
        error = np.abs(column(name) - getattr(exact, name)) / energy
        assert np.max(error) < 4.0 * (impulse + restitution), name
    assert np.array_equal(column("rolling").astype(bool), exact.rolling)
    time = column("contact_time")[~captured] / exact.contact_time[~captured] - 1.0
    assert np.max(np.abs(time)) < 2.0 * stated["contact_time"]


def test_capture_velocities_agree_with_the_kernel(browser):
    c = random_arguments(300)
    exact = capture_velocity(contact_of(c))
    found = browser.execute_script(BY_KERNEL, as_page_takes_it(c, "compressive"))
    kinds = [one["limit_kind"] for one in found]
    finite = np.array([kind == "finite" for kind in kinds])
    assert finite.sum() > 150
    values = np.array([one["limit"] for one, kind in zip(found, finite, strict=True) if kind])
    assert values == pytest.approx(exact[finite], rel=1e-9)
    for one, value, known in zip(found, exact, finite, strict=True):
        if not known:
            assert one["limit_kind"] in {"infinite", "above", "below"}
            if one["limit_kind"] == "infinite":
                assert np.isinf(value)
            elif one["limit_kind"] == "above":
                assert value > one["limit"]
            else:
                assert value < one["limit"]


def test_shares_of_the_energy_add_up_and_follow_the_ledger(browser, tables):
    c = random_arguments(300)
    contact = contact_of(c)
    found = browser.execute_script(BY_KERNEL, as_page_takes_it(c, "compressive"))
    v_n = velocity_components(c["speed"], c["angle"])[0]
    energy = np.square(c["speed"]) + 0.4 * np.square(c["spin"] * contact.radius)
    ledger = normal_impact(contact, -v_n, ledger=True).ledger
    errors = tables["explorer_accuracy"].groupby("quantity")["largest"].max()
    bound = 2.0 * errors[["coefficient_of_restitution", "hertz_work"]].sum()
    for i, one in enumerate(found):
        assert sum(one["shares"].values()) == pytest.approx(1.0, abs=1e-12)
        assert all(share >= 0.0 for share in one["shares"].values())
        unit = contact.mass[i] / 2.0 * energy[i]
        if not one["captured"]:
            for name in ("hertz", "adhesion"):
                known = getattr(ledger, f"{name}_work")[i] / unit
                assert one["shares"][f"{name}_damping"] == pytest.approx(known, abs=bound)


# ---- its use ------------------------------------------------------------------------------------


def test_it_opens_with_a_calibrated_case_and_its_capture_velocity(browser):
    assert browser.find_element("id", "contact").get_attribute("value") == "steel-silicon, n = 1"
    assert text(browser, "out_vc") == "0.1800 m/s"
    assert text(browser, "verdict").startswith("Rebounds")
    assert "–" not in outputs(browser)


@pytest.mark.parametrize("name", ["d", "w", "cH", "cA", "f", "v", "angle", "spin"])
def test_the_arrow_keys_move_a_slider_and_the_numbers_follow(browser, name):
    from selenium.webdriver.common.keys import Keys

    before = outputs(browser), browser.find_element("id", name).get_attribute("value")
    slider = browser.find_element("id", f"{name}_slider")
    slider.send_keys(Keys.ARROW_RIGHT)
    settled(browser)
    after = outputs(browser), browser.find_element("id", name).get_attribute("value")
    assert after[1] != before[1]
    assert after[0] != before[0]
    assert (
        browser.find_element("id", f"{name}_slider")
        .get_attribute("aria-valuetext")
        .startswith(after[1])
    )


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


@pytest.mark.parametrize(
    ("name", "typed", "said"),
    [
        ("d", "abc", "Diameter “abc”: it must be a number greater than 0."),
        ("d", "-3", "Diameter “-3”: it must be a number greater than 0."),
        (
            "angle",
            "91",
            "Angle from the surface “91”: it must be a number above 0 and up to 90 degrees.",
        ),
        ("v", "", "Speed is empty: it must be greater than 0 and below that of light."),
        ("w", "1e400", "Work of adhesion “1e400”: it must be 0 or a positive number."),
        ("surface_nu", "0.7", "Poisson’s ratio of the surface “0.7”: it must be a number above −1"),
    ],
)
def test_bad_input_gives_one_clear_message_and_no_numbers(browser, name, typed, said):
    type_into(browser, name, typed)
    assert text(browser, "problem").startswith(said)
    assert browser.find_element("id", name).get_attribute("aria-invalid") == "true"
    assert browser.find_element("id", name).get_attribute("aria-describedby") == "problem"
    assert set(outputs(browser)) == {"–"}
    assert browser.find_elements("css selector", ".x-plots svg *") == []
    type_into(browser, name, "0.4")
    assert not browser.find_element("id", "problem").is_displayed()
    assert "–" not in outputs(browser)


def test_a_comma_is_read_as_a_decimal_point(browser):
    type_into(browser, "v", "1,5")
    point = text(browser, "out_vn")
    type_into(browser, "v", "1.5")
    assert text(browser, "out_vn") == point


def test_outside_the_tables_it_says_so_and_shows_nothing(browser):
    type_into(browser, "cA", "60")
    assert text(browser, "problem").startswith("Outside the tables: ")
    assert set(outputs(browser)) == {"–"}
    type_into(browser, "cA", "1")
    assert "–" not in outputs(browser)


def test_a_slow_sphere_is_captured_and_rolls_on(browser):
    type_into(browser, "v", "0.1")
    assert text(browser, "verdict") == "Captured: the sphere stays on the surface."
    assert text(browser, "out_e") == "0"
    assert text(browser, "out_time") == "does not leave"
    # (5/7) v cos 45 degrees
    assert text(browser, "out_V").startswith("0.05051 m/s")


def test_extreme_but_admissible_numbers_give_numbers_or_a_message(browser):
    for name, typed in (("w", "0"), ("cA", "0"), ("cH", "0"), ("d", "1e-300"), ("f", "0")):
        type_into(browser, name, typed)
        shown = outputs(browser)
        complains = browser.find_element("id", "problem").is_displayed()
        assert complains != ("–" not in shown)
        assert not re.search(r"NaN|undefined|Infinity", " ".join(shown) + browser.page_source[-1:])


def test_a_link_restores_the_state(browser, page):
    type_into(browser, "v", "0.77")
    type_into(browser, "angle", "33")
    type_into(browser, "spin", "-4000")
    browser.find_element("css selector", "#basis option[value=hertz]").click()
    settled(browser)
    link, shown = browser.find_element("id", "permalink").get_attribute("href"), outputs(browser)
    assert browser.current_url == link
    visit(browser, link)
    assert outputs(browser) == shown
    assert browser.find_element("id", "basis").get_attribute("value") == "hertz"
    browser.find_element("id", "reset").click()
    assert outputs(browser) != shown


def test_everything_is_reached_by_the_tabulator_key(browser):
    from selenium.webdriver.common.keys import Keys

    reached = []
    browser.find_element("id", "contact").send_keys("")
    for _ in range(40):
        active = browser.switch_to.active_element
        reached.append(active.get_attribute("id"))
        active.send_keys(Keys.TAB)
    for name in (
        "contact",
        "particle",
        "d",
        "d_slider",
        "angle_slider",
        "basis",
        "reset",
        "permalink",
    ):
        assert name in reached


def test_each_plot_names_what_it_shows_and_only_files_were_read(browser):
    for name in ("sketch", "plot_e", "plot_mu", "plot_loss"):
        label = browser.find_element("id", name).get_attribute("aria-label")
        assert re.search(r"\d", label), name
    loaded = browser.execute_script(
        "return performance.getEntriesByType('resource').map((entry) => entry.name)"
    )
    assert all(name.startswith("file:") for name in loaded)


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1300, 1000), (390, 844)])
def test_it_is_accessible_and_fits_the_window(browser, theme, size):
    selenium = pytest.importorskip("axe_core_python.selenium")
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size[0] < 600},
    )
    browser.execute_cdp_cmd(
        "Emulation.setEmulatedMedia",
        {"features": [{"name": "prefers-color-scheme", "value": theme}]},
    )
    try:
        type_into(browser, "v", "0.21")
        wide = browser.execute_script("return document.documentElement.scrollWidth")
        assert wide <= size[0]
        violations = selenium.Axe().run(browser)["violations"]
        assert [(v["id"], [n["target"] for n in v["nodes"]]) for v in violations] == []
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
