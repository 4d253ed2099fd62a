"""What the README says of claims in words is what the ledgers say; its pictures are small."""

from __future__ import annotations

import re
import runpy

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from tests.docs.blocks import PAGES, ROOT

from study.tables import text_rows

README = (ROOT / "README.md").read_text(encoding="utf-8")
TABLES = ROOT / "tests/reference/full/tables"
CLAIMS = {row["id"]: row for row in text_rows(TABLES / "claims.csv")}
RESULTS = pd.read_csv(TABLES / "claim_results.csv")
FINDINGS = re.findall(r"^\| (C\d+) \| (.+) \| (.+) \|$", README, flags=re.MULTILINE)
GALLERY = runpy.run_path(str(ROOT / "docs/gallery.py"))


@pytest.mark.parametrize(("name", "stated", "found"), FINDINGS)
def test_a_finding_gives_numbers_of_its_claim(name, stated, found):
    claim = CLAIMS[name]
    reasons = found.partition(":")[2]
    computed = RESULTS.loc[RESULTS["id"] == name, "value"]
    # Numbers of the statement itself, of equations and of settings are no results.
    known = set(re.findall(r"\d+(?:\.\d+)?", claim["statement"])) | {"0", "1"}
    numbers = re.findall(r"(?<!Eq\. )(?<![\w.])(\d+(?:\.\d+)?)( %)?", reasons)
    results = [(text, bool(percent)) for text, percent in numbers if text not in known or percent]
    for text, percent in results:
        digits = len(text.partition(".")[2])
        told = {f"{abs(v) * (100 if percent else 1):.{digits}f}" for v in computed}
        assert text in told, f"{text}: none of {sorted(told)}"
    assert results or "1" in reasons


def test_a_picture_keeps_colours_that_are_rare_in_it(tmp_path):
    grey = np.add.outer(np.arange(400), np.arange(400)) // 4
    picture = np.repeat(grey[..., None], 3, axis=-1).astype(np.uint8)
    picture[200, ::40] = 0, 114, 178  # ten points of a line, blue
    Image.fromarray(picture).save(tmp_path / "large.png")
    GALLERY["shrink"](tmp_path / "large.png", tmp_path / "small.png")
    with Image.open(tmp_path / "small.png") as small:
        found = np.asarray(small.convert("RGB"), int)
    assert np.abs(found - picture).max() < 20


def test_every_verdict_is_in_the_bar(tmp_path):
    GALLERY["draw_outcomes"](ROOT / "tests/reference/full", tmp_path / "bar.svg")
    words = {word for of in GALLERY["OUTCOMES"].values() for word in of}
    assert {row["verdict"] for row in CLAIMS.values()} <= words
    assert (tmp_path / "bar.svg").stat().st_size > 0


def test_pictures_are_there_and_small():
    shown = [ROOT / f"docs/images/{name}.png" for name in GALLERY["shown"](README)]
    assert sum(path.stat().st_size for path in shown) < 600_000
    pages = "".join((ROOT / page).read_text(encoding="utf-8") for page in PAGES)
    unused = [path.name for path in (ROOT / "docs/images").iterdir() if path.stem not in pages]
    assert not unused
