"""The site as files: links lead somewhere, nothing asks the network, text stays text."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from types import SimpleNamespace
from urllib.parse import unquote, urlsplit

import jsonschema
import pandas as pd
import pytest
from click.testing import CliRunner
from tests.study.report.pages import Page

from study.declared.provenance import EVIDENCE
from study.ledgers.claims import COLUMNS
from study.report.check.results import ResultsError
from study.report.commands import commands
from study.report.site import PAGES
from study.report.site.build import site_pages, write_site
from study.report.site.chains import chains_json
from study.report.site.code import modules, place
from study.report.site.figures import departures, joined, studies_behind
from study.report.site.glossary import definitions, marked
from study.report.site.graph import needs, upstream
from study.report.site.pages import ASSETS
from study.report.site.record import (
    Change,
    Rule,
    changes,
    from_plain,
    read_record,
    row_names,
    write_record,
)
from study.tables import RESULT_EVIDENCE


@pytest.fixture(scope="module")
def pages(site):
    return {
        path.relative_to(site).as_posix(): Page(path.read_text(encoding="utf-8"))
        for path in sorted(site.rglob("*.html"))
    }


def test_there_is_a_page_for_every_figure(pages, registry):
    assert {f"figures/{name}.html" for name in registry} < set(pages)
    assert {f"{name}.html" for name in PAGES} < set(pages)


def test_every_link_and_anchor_leads_somewhere(site, pages):
    assert sum(len(page.links) for page in pages.values()) > 2000
    for name, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            assert not parts.scheme, f"{name}: {link} is not relative"
            assert not parts.netloc, f"{name}: {link} is not relative"
            target = (site / name).parent / unquote(parts.path) if parts.path else site / name
            assert target.is_file(), f"{name}: {link}"
            assert target.resolve().is_relative_to(site.resolve()), f"{name}: {link} leaves"
            if parts.fragment:
                other = pages[target.resolve().relative_to(site.resolve()).as_posix()]
                assert parts.fragment in other.ids, f"{name}: {link}"


def test_the_data_package_describes_every_table(site, results):
    package = json.loads((site / "files/datapackage.json").read_text())
    described = {entry["path"]: entry["schema"]["fields"] for entry in package["resources"]}
    assert set(described) == {f"{p.parent.name}/{p.name}" for p in (site / "files").glob("*/*.csv")}
    for path, fields in described.items():
        header = (site / "files" / path).read_text().partition("\n")[0]
        assert [field["name"] for field in fields] == header.split(",")
    units = {f["name"]: f["unit"] for fields in described.values() for f in fields if "unit" in f}
    assert units["x_m_per_s"] == "m/s"
    assert units["work_of_adhesion_J_per_m2"] == "J/m2"
    assert units["restitution"] == "1"


def test_the_ledger_of_claims_in_one_file_keeps_its_schema(site, results):
    text, schema = ((site / f"files/claims.{end}").read_text() for end in ("json", "schema.json"))
    content = json.loads(text)
    jsonschema.validate(content, json.loads(schema))
    rows = pd.read_csv(results / "tables/claims.csv", keep_default_na=False)
    assert [claim["verdict"] for claim in content["claims"]] == rows["verdict"].to_list()
    numbers = [number for claim in content["claims"] for number in claim["numbers"]]
    assert len(numbers) == len(pd.read_csv(results / "tables/claim_results.csv"))
    assert {number["passed"] for number in numbers} == {True, False, None}


@pytest.mark.parametrize(
    ("verdict", "status"),
    [
        ("reproduced", "Validated"),
        ("not reproduced", "Contradicted"),
        ("calibrated", "Inconclusive"),
        ("not of this experiment", "NotTested"),
    ],
)
def test_a_replication_chain_leads_from_the_outcome_to_the_quote(verdict, status):
    row = dict.fromkeys(COLUMNS, "") | {
        "id": "C01",
        "statement": "Spheres stick.",
        "quote": "they stick",
        "verdict": verdict,
    }
    drafts = json.loads(chains_json([row, row | {"quote": ""}], "abc"))["@graph"]
    quote, aida, claim, study, outcome = (draft["@graph"][0] for draft in drafts)
    assert outcome["slt:hasValidationStatus"] == {"@id": f"slt:{status}"}
    assert outcome["slt:isOutcomeOf"]["@id"] == study["@id"]
    assert study["slt:targetsClaim"]["@id"] == claim["@id"]
    assert claim["slt:asAidaStatement"]["@id"] == aida["@id"]
    assert aida["@id"] == "http://purl.org/aida/Spheres+stick."
    assert aida["skos:related"]["@id"] == drafts[0]["@id"]
    assert quote["cito:hasQuotedText"] == "they stick"


def test_a_claim_and_an_equation_lead_to_their_code(pages, results):
    for ledger, page, column in (
        ("claims", "claims.html", "code"),
        ("equations", "equations.html", "function"),
    ):
        rows = pd.read_csv(results / f"tables/{ledger}.csv", dtype=str, keep_default_na=False)
        names = {name.rpartition(".")[2] for name in rows[column] if name}
        linked = {
            link.rpartition("#")[2].rpartition(".")[2]
            for link in pages[page].links
            if link.startswith("code/")
        }
        assert linked == names
        assert len(names) > 20


def test_no_asset_asks_the_network():
    for path in ASSETS.iterdir():
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"https?://|@import|url\((?!data:)|fetch\(|XMLHttp", text), path


def test_the_front_page_counts_what_the_ledgers_say(pages, results):
    claims = pd.read_csv(results / "tables/claims.csv", dtype=str)
    counted = claims[~claims["kind"].isin(["arithmetic", "finding"])]["verdict"].value_counts()
    (told,) = [
        given["aria-label"]
        for tag, given in pages["index.html"].tags
        if tag == "svg" and given.get("aria-label", "").startswith("Claims")
    ]
    found = {
        verdict: int(number)
        for number, verdict in re.findall(r"(\d+) ([a-z ]+)", told.partition(": ")[2])
    }
    assert found == counted.to_dict()
    links = pages["index.html"].links
    failed = claims[(claims["verdict"] == "not reproduced") & (claims["kind"] != "arithmetic")]
    assert len(failed) > 10
    assert {f"claims.html#{i}" for i in failed["id"]} <= set(links)


def contents(folder):
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return {path.relative_to(folder): path.read_bytes() for path in paths}


def test_the_same_run_gives_the_same_bytes(site, record, tmp_path):
    again = shutil.copytree(site.parent, tmp_path / "again")
    stale = again / "report/files/tables/no_longer.csv"
    stale.write_text("a\n1\n", encoding="utf-8")
    write_site(again, record)
    assert not stale.exists()
    assert contents(again / "report") == contents(site)


def test_the_explorer_is_linked_where_it_is_and_left_alone(few):
    root, record = few
    write_site(root, record)
    index = root / "report/index.html"
    assert "explorer.html" not in Page(index.read_text(encoding="utf-8")).links
    (root / "report/explorer.html").write_text("another's page", encoding="utf-8")
    write_site(root, record)
    assert "explorer.html" in Page(index.read_text(encoding="utf-8")).links
    assert (root / "report/explorer.html").read_text(encoding="utf-8") == "another's page"


# Columns of a ledger that are no words.
LEDGER_NUMBERS = {"margin": "", "shares": "", "decided_by": ""}


def test_names_stay_text(few, results):
    root, record = few
    evil = "<script>alert(1)</script>"
    entry = dict(record.figures["fig14"], title=evil, caption=f'a "{evil}" & b')
    marks = pd.DataFrame(
        {"panel": [evil], "series": [evil], "evidence": [evil], "x_1": [0], "y_1": [0]}
    )
    marks.to_csv(root / "data/fig14.csv", index=False)
    inputs = {
        "file": ["config", "materials"],
        "key": [f"restitution_trends.{evil}", f"{evil}.density"],
    }
    (root / "tables").mkdir()
    for table, columns in (("inputs", inputs), ("claims", LEDGER_NUMBERS), ("equations", {})):
        header = pd.read_csv(results / f"tables/{table}.csv", nrows=0).columns
        rows = pd.DataFrame({name: [evil, evil] for name in header}).assign(**columns)
        rows.to_csv(root / f"tables/{table}.csv", index=False)
    changed = replace(
        record,
        figures={"fig14": entry},
        changes=(Change(key=evil, shipped=evil, used=evil),),
        git={"commit": evil, "dirty": False},
    )
    made = site_pages(root, changed)
    texts = {name: text for name, text in made.items() if name.endswith(".html")}
    assert any("&lt;script&gt;alert(1)" in text for text in texts.values())
    for name, text in texts.items():
        assert "<script>alert" not in text, name
        page = Page(text)
        assert not [t for t, given in page.tags if t == "script" and "src" not in given]


def test_a_results_folder_without_anything_is_refused(tmp_path, record):
    with pytest.raises(ValueError, match="no figures and no tables"):
        write_site(tmp_path, record)


def test_changes_of_the_configuration():
    shipped = {
        "a": {"x": {"value": 30.0, "evidence": "assumed", "source": "s"}, "y": [1, 2]},
        "gone": 1,
        "pathvars": {"results": "results"},
    }
    config = {
        "a": {"x": {"value": 30, "evidence": "user", "source": "other words"}, "y": [1, 3]},
        "new": {"z": 0},
        "pathvars": {"results": "elsewhere"},
    }
    assert changes(config, shipped) == (
        Change(key="a.y", shipped=[1, 2], used=[1, 3]),
        Change(key="gone", shipped=1, used=None),
        Change(key="new.z", shipped=None, used=0),
    )


def test_names_of_declared_rows():
    rows = {
        "materials": "material,property,value\nsilicon,density,1\nsilicon,youngs_modulus,2\n",
        "contacts": "particle,surface,property,value\nsteel,silicon,friction,1\n",
    }
    assert row_names(rows) == {"materials": ("silicon",), "contacts": ("steel on silicon",)}
    assert row_names(None) == {}


def test_the_command_writes_the_site_of_a_finished_run(few):
    root, record = few
    write_record(root, record)
    done = CliRunner().invoke(commands, ["report", str(root)])
    assert done.exit_code == 0, done.output
    assert (root / "report/index.html").is_file()
    assert (root / "report/files/figures/fig14.svg").is_file()


def test_no_site_shows_results_of_several_inputs(few):
    root, record = few
    write_record(root, record)
    (root / "run.json").write_text('{"outdated": ["data/fig14.csv"]}')
    done = CliRunner().invoke(commands, ["report", str(root)])
    assert str(done.exception).endswith(
        "run.json: made earlier, from other inputs: data/fig14.csv; renew them with `snakemake`"
    )
    assert not (root / "report/index.html").exists()


RULES = (
    Rule(name="a", outputs=("tables/a.csv",)),
    Rule(name="b", inputs=("tables/a.csv", "src/x.py"), outputs=("data/b.csv",)),
    Rule(name="fig01", inputs=("data/b.csv",), outputs=("figures/fig01.svg",)),
    Rule(name="alone", outputs=("tables/alone.csv",)),
)


def test_a_figure_rests_on_the_makers_of_its_inputs():
    assert upstream("fig01", needs(RULES)) == ("b", "a")


def test_a_term_leads_to_its_meaning_where_a_page_first_has_it():
    assert set(definitions()) >= {*EVIDENCE, *RESULT_EVIDENCE}
    page = "<h1>ring force</h1><main><h2>Ring force</h2><p>A ring force; the ring force.</p></main>"
    text = marked(page, "../")
    assert text.count("<a ") == 1
    assert 'A <a class="term" href="../glossary.html#term-ring-force" title="Attraction ' in text


def test_a_record_is_read_again_and_refused_where_it_lacks_a_part(few):
    root, record = few
    write_record(root, record)
    assert read_record(root).plain() == record.plain()
    content = record.plain()
    del content["seed"]
    with pytest.raises(ResultsError, match="seed"):
        from_plain(content)


def test_code_has_a_page_with_an_anchor_for_every_function():
    stiffness = "microimpact.model.contact.Contact.stiffness"
    assert place(stiffness) == "code/microimpact.model.contact.html#Contact.stiffness"
    assert place("microimpact.model.contact.nothing") == place("os.remove") == place("") == ""
    (module,) = modules([stiffness, "os.remove", "microimpact.model.contact.hertz_stiffness"])
    assert module.file == "src/microimpact/model/contact.py"
    begins = {name: i for i, line in enumerate(module.lines) for name in line.begins}
    # A property begins with its decorator, within its class.
    assert "@" in module.lines[begins["Contact.stiffness"]].text
    assert begins["Contact"] < begins["Contact.stiffness"]
    assert sum(line.ends for line in module.lines) == len(begins)


def test_a_claim_rests_on_the_departures_of_its_own_studies_alone():
    keys = ("force_history.diameter_um", "calibration.n", "doe.levels", "claim_numbers.speed")
    declared = [{"key": key, "overrides": "printed.x = 1"} for key in keys]
    needed = {"force_history": ("calibration",), "claim_numbers": ()}
    record = SimpleNamespace(figures={"fig25": {"study": "doe"}})

    def departing(**claim):
        behind = studies_behind({"figures": "", "inputs": "", **claim}, record)
        return [row["key"] for row in departures(declared, behind, needed)]

    assert departing() == ["claim_numbers.speed"]
    assert departing(inputs="force_ratios materials") == [keys[0], keys[1], keys[3]]
    assert departing(figures="fig25") == [keys[2], keys[3]]


def test_items_of_a_list_are_one_row_where_only_the_value_differs():
    def row(key, value, source="s"):
        same = {"unit": "deg", "evidence": "chosen", "overrides": ""}
        return {"key": key, "value": value, "source": source} | same

    rows = [row("angle[0]", "1"), row("angle[1]", "2"), row("angle[2]", "3", "t"), row("n", "4")]
    assert joined(rows) == [row("angle", "1, 2"), row("angle", "3", "t"), row("n", "4")]
