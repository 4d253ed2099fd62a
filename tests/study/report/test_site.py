"""The site as files: links lead somewhere, files hold what the ledgers say, text stays text."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace
from urllib.parse import unquote, urlsplit

import jsonschema
import pandas as pd
import pytest
from click.testing import CliRunner
from tests.study.report.pages import Page

from study import analyses
from study.declared.provenance import EVIDENCE
from study.report.check.results import ResultsError
from study.report.commands import commands
from study.report.site import PAGES
from study.report.site.build import site_pages, write_site
from study.report.site.figures import (
    OTHER,
    SUBJECTS,
    _evidence,
    departures,
    joined,
    shows_article,
    studies_behind,
    upstream,
)
from study.report.site.glossary import definitions, marked
from study.report.site.record import (
    Change,
    changes,
    read_record,
    row_names,
    write_record,
)
from study.tables import RESULT_EVIDENCE, not_computed


@pytest.fixture(scope="module")
def pages(site):
    return {
        path.relative_to(site).as_posix(): Page(path.read_text(encoding="utf-8"))
        for path in sorted(site.rglob("*.html"))
    }


def test_a_table_that_could_not_be_computed_has_no_evidence(tmp_path):
    path = tmp_path / "curves.csv"
    not_computed("edge_speed: no root").to_csv(path, index=False)
    assert _evidence([path]) == ()


def test_every_figure_has_a_page_and_every_link_and_anchor_leads_somewhere(site, pages, entries):
    assert {f"figures/{name}.html" for name in entries} < set(pages)
    assert {f"{name}.html" for name in PAGES} < set(pages)
    assert sum(len(page.links) for page in pages.values()) > 2000
    for name, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            assert not parts.scheme + parts.netloc, f"{name}: {link} is not relative"
            target = (site / name).parent / unquote(parts.path) if parts.path else site / name
            assert target.is_file(), f"{name}: {link}"
            assert target.resolve().is_relative_to(site.resolve()), f"{name}: {link} leaves"
            if parts.fragment:
                other = pages[target.resolve().relative_to(site.resolve()).as_posix()]
                assert parts.fragment in other.ids, f"{name}: {link}"


def test_pages_group_figures_and_tables_by_what_they_are_about(site, pages, entries):
    named = [name for names in SUBJECTS.values() for name in names]
    assert sorted(named) == sorted({entry["analysis"] for entry in entries.values()})
    for page in ("figures.html", "tables.html"):
        text = (site / page).read_text(encoding="utf-8")
        heads = [text.index(f">{subject}</h2>") for subject in SUBJECTS]
        assert heads == sorted(heads)
        assert OTHER not in text
    text = (site / "tables.html").read_text(encoding="utf-8")
    assert text.index("claims.csv") < text.index(">Capture velocity</h2>")


def test_a_figure_of_the_article_begins_with_where_it_disagrees(site):
    text = (site / "figures/fig06.html").read_text(encoding="utf-8")
    disagreement, agreement, open_ = (
        text.index(f">{words}</h2>") for words in ("Disagreement", "Agreement", "Not decided")
    )
    assert disagreement < text.index("Slopes alone lower restitution") < agreement < open_
    assert disagreement < text.index("claims.html#C72") < agreement


def test_a_figure_of_other_impacts_is_not_compared_with_the_article(entries):
    entry = entries["fig06"]
    assert shows_article("fig06", entry)
    other = entry | {"title": entry["title"].replace("silicon", "glass")}
    assert not shows_article("fig06", other)
    assert not shows_article("of nobody", other)


def test_claims_on_the_article_do_not_judge_a_figure_of_another_pair(results, record, entries):
    other = entries["fig06"] | {"title": "Of latex on quartz"}
    changed = replace(record, figures={**record.figures, "fig06": other})
    page = site_pages(results, changed)["figures/fig06.html"]
    assert page.index('id="of-article"') < page.index("claims.html#C72")
    assert not any(f'id="{part}"' in page for part in ("disagreement", "agreement", "open"))


def test_the_ledger_of_claims_in_one_file_keeps_its_schema(site, results):
    text, schema = ((site / f"files/claims.{end}").read_text() for end in ("json", "schema.json"))
    content = json.loads(text)
    jsonschema.validate(content, json.loads(schema))
    rows = pd.read_csv(results / "tables/claims.csv", keep_default_na=False)
    assert [claim["verdict"] for claim in content["claims"]] == rows["verdict"].to_list()
    numbers = [number for claim in content["claims"] for number in claim["numbers"]]
    assert len(numbers) == len(pd.read_csv(results / "tables/claim_results.csv"))
    assert {number["passed"] for number in numbers} == {True, False, None}


def test_the_front_page_counts_what_the_ledgers_say(pages, results):
    claims = pd.read_csv(results / "tables/claims.csv", dtype=str)
    counted = claims["verdict"].value_counts()
    front = pages["index.html"]
    words = [text.strip() for text in front.text if text.strip()]
    shown = {verdict: int(words[words.index(verdict) + 1]) for verdict in counted.index}
    assert shown == counted.to_dict()
    failed = claims[claims["verdict"] == "not reproduced"]
    assert len(failed) > 3
    assert {f"claims.html#{i}" for i in failed["id"]} <= set(front.links)


def contents(folder):
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return {path.relative_to(folder): path.read_bytes() for path in paths}


def test_the_same_run_gives_the_same_bytes(site, record, tmp_path):
    again = shutil.copytree(site.parent, tmp_path / "again")
    (again / "report/files/tables/no_longer.csv").write_text("a\n1\n", encoding="utf-8")
    write_site(again, record)
    assert contents(again / "report") == contents(site)


def test_the_explorer_is_linked_where_it_is_and_left_alone(few):
    root, record = few
    index, explorer = root / "report/index.html", root / "report/explorer.html"
    write_site(root, record)
    assert "explorer.html" not in Page(index.read_text(encoding="utf-8")).links
    explorer.write_text("another's page", encoding="utf-8")
    write_site(root, record)
    assert "explorer.html" in Page(index.read_text(encoding="utf-8")).links
    assert explorer.read_text(encoding="utf-8") == "another's page"


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
        "key": [f"fig14_restitution_trends.{evil}", f"{evil}.density"],
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
    texts = {k: text for k, text in site_pages(root, changed).items() if k.endswith(".html")}
    assert sum("&lt;script&gt;alert(1)" in text for text in texts.values()) > 4
    for text in texts.values():
        assert not [t for t, given in Page(text).tags if t == "script" and "src" not in given]


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


def test_the_command_writes_the_site_of_a_run(few):
    root, record = few
    write_record(root, record.plain())
    done = CliRunner().invoke(commands, ["report", str(root)])
    assert done.exit_code == 0, done.output
    assert (root / "report/files/figures/fig14.svg").is_file()


def test_a_record_is_read_again_and_refused_where_it_lacks_a_part(few):
    root, record = few
    write_record(root, record.plain())
    assert read_record(root).plain() == record.plain()
    write_record(root, {k: v for k, v in record.plain().items() if k != "seed"})
    with pytest.raises(ResultsError, match="seed"):
        read_record(root)


def test_a_figure_rests_on_the_studies_that_its_study_needs():
    assert upstream("calibration") == ()
    for study in analyses.homes():
        chain = upstream(study)
        assert len(set(chain)) == len(chain)
        assert {m for name in (study, *chain) for m in analyses.needs(name).values()} == set(chain)


def test_a_claim_rests_on_the_departures_of_its_own_studies_alone():
    keys = (
        "fig20_force_history.diameter_um",
        "calibration.n",
        "fig24_25_doe.levels",
        "claim_numbers.speed",
    )
    declared = [{"key": key, "overrides": "printed.x = 1"} for key in keys]
    record = SimpleNamespace(figures={"fig25": {"analysis": "fig24_25_doe"}})

    def departing(**claim):
        behind = studies_behind({"figures": "", "inputs": "", **claim}, record)
        return {row["key"] for row in departures(declared, behind)}

    assert departing() == {"claim_numbers.speed"}
    assert departing(inputs="force_ratios materials") == {keys[0], keys[1], keys[3]}
    assert departing(figures="fig25") >= {keys[2], keys[3]}


def test_items_of_a_list_are_one_row_where_only_the_value_differs():
    def row(key, value, source="s"):
        same = {"unit": "deg", "evidence": "chosen", "overrides": ""}
        return {"key": key, "value": value, "source": source} | same

    rows = [row("angle[0]", "1"), row("angle[1]", "2"), row("angle[2]", "3", "t"), row("n", "4")]
    assert joined(rows) == [row("angle", "1, 2"), row("angle", "3", "t"), row("n", "4")]


def test_a_term_leads_to_its_meaning_where_a_page_first_has_it():
    assert set(definitions()) >= {*EVIDENCE, *RESULT_EVIDENCE}
    page = "<h1>ring force</h1><main><h2>Ring force</h2><p>A ring force; the ring force.</p></main>"
    text = marked(page, "../")
    assert text.count("<a ") == 1
    assert 'A <a class="term" href="../glossary.html#term-ring-force" title="Attraction ' in text
