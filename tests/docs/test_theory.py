"""The table of symbols gives the units with which the ledger of equations is checked."""

from __future__ import annotations

import re

from tests.docs.blocks import ROOT

from study.equations.forms import units_of

SPELT = {"-": "", "rad": "", "J/m²": "J/m**2", "kg m²": "kg*m**2", "N s": "N*s"}


def test_symbols_have_the_units_of_the_ledger():
    page = (ROOT / "docs/theory.md").read_text(encoding="utf-8")
    rows = page.partition("| symbol | meaning | unit |")[2].partition("\n\n")[0].splitlines()[2:]
    compared = 0
    for row in rows:
        symbols, _, unit = (cell.strip() for cell in row.strip("|").split("|"))
        names = re.findall(r"\$\\?([^$]+)\$", symbols)
        units = unit.split(", ")
        units = units * len(names) if len(units) == 1 else units
        for name, own in zip(names, units, strict=bool(names)):
            if name == "s":  # the second, in the ledger
                continue
            known = {units_of(section).get(name) for section in ("", "3.2", "3.3")} - {None}
            assert not known or SPELT.get(own, own) in known, f"{name}: {own}, not {known}"
            compared += bool(known)
    assert compared > 40
