"""A site made of the reference tables, with small pictures in place of the figures."""

from __future__ import annotations

import base64
import shutil
from dataclasses import replace

import pytest
from tests.shared import ROOT, made_once, require

from study.report.check.results import read_text, table_files
from study.report.site.build import write_site
from study.report.site.record import Change, Record, write_record

REFERENCE = ROOT / "tests/reference"
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 160 90" width="160" height="90">'
    '<path d="M10 80L60 20L150 70" fill="none" stroke="black"/></svg>\n'
)
PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


# The last three keep it from asking for hosts of its maker.
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


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """A headless browser that keeps what pages say on the console; tests are skipped without."""
    require("chromium", "chromedriver", package="chromium chromium-driver")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    for argument in ARGUMENTS:
        options.add_argument(argument)
    options.add_argument(f"--user-data-dir={tmp_path_factory.mktemp('browser')}")
    driver = webdriver.Chrome(
        options=options, service=webdriver.ChromeService(shutil.which("chromedriver"))
    )
    yield driver
    driver.quit()


@pytest.fixture(scope="session")
def entries(figures):
    """What the report shows of every figure."""
    return {name: figure.entry() for name, figure in figures.items()}


@pytest.fixture(scope="session")
def record(entries):
    """A run with one changed key, whose studies are all given the same rows."""
    rows = {"materials": ("silicon",), "printed": ("drop_height",)}
    return Record(
        seed=20011,
        git={"commit": "0123456789abcdef0123456789abcdef01234567", "dirty": True},
        python="3.11.7",
        platform="Linux x86_64",
        packages={"numpy": "2.4.6", "snakemake": None},
        changes=(Change(key="fig17_coulomb_friction.points", shipped=360, used=36),),
        impact="steel on silicon",
        figures=entries,
        rows={entry["analysis"]: rows for entry in entries.values()},
    )


@pytest.fixture(scope="session")
def results(tmp_path_factory, entries):
    """Results without a report: reference tables, figure data, pictures; nobody changes them."""

    def make(root):
        for file, path in table_files(REFERENCE).items():
            (root / file).parent.mkdir(parents=True, exist_ok=True)
            (root / file).write_text(read_text(path), encoding="utf-8", newline="")
        for name in entries:
            (root / f"figures/{name}.svg").write_text(SVG, encoding="utf-8")
            (root / f"figures/{name}.png").write_bytes(PNG)
            (root / f"figures/{name}.pdf").write_bytes(b"%PDF-1.4\n")

    return made_once(tmp_path_factory, "results", make)


@pytest.fixture(scope="session")
def site(results, record, tmp_path_factory):
    """The folder of a site with all pages."""

    def make(place):
        shutil.copytree(results, place)
        write_record(place, record.plain())
        write_site(place, record)

    return made_once(tmp_path_factory, "site", make) / "report"


@pytest.fixture
def few(tmp_path, record):
    """A results folder with one figure and no ledger, and its record."""
    root = tmp_path / "results"
    data = "panel,series,evidence,x_1,y_1\nleft,e,computed,1,2\nleft,v,printed,1,2\n"
    for file, text in {"figures/fig14.svg": SVG, "data/fig14.csv": data}.items():
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).write_text(text, encoding="utf-8")
    return root, replace(record, changes=(), rows={})
