"""Language and time zone of the machine change no byte, not even where they reach the libraries."""

from __future__ import annotations

import shutil
import sys

import pytest
from tests.shared import ROOT, execute

# A table and a figure, from the declared numbers, in a program that takes on its user's locale.
PROGRAM = """
import locale, sys
from importlib import import_module

locale.setlocale(locale.LC_ALL, "")
from microimpact.declared.documents import load
from microimpact.run.config import read_configuration
from microimpact.figures.registry import figure_spec, filled
from microimpact.figures.style import save
from microimpact.declared.parameters import build
from microimpact.declared.provenance import plain
from microimpact.studies.models import restitution_trends as study
from microimpact.core.tables import read_figure_data, write_table

(out,) = sys.argv[1:]
branch = plain(read_configuration("config")["restitution_trends"])
tables = study.run(build(study.Params, branch), {})
write_table(tables["fig14"], f"{out}/fig14.csv")

entries = {"fig14": load("config/figures.yaml")["fig14"]}
spec = figure_spec("fig14", filled(entries, {"restitution_trends": branch})["fig14"])
unit = spec.data["fig14"]
data = {"fig14": read_figure_data(f"{out}/fig14.csv", unit.x, unit.y)}
draw = getattr(import_module(spec.module), spec.function)
save(draw(data, spec), f"{out}/fig14.svg", f"{out}/fig14.png")
print(locale.localeconv()["decimal_point"])
"""


def built(out, **environment):
    """Return the decimal point of the locale, and the bytes that a program in it wrote."""
    environment = {"PYTHONPATH": str(ROOT / "src"), **environment}
    done = execute(sys.executable, "-c", PROGRAM, str(out), cwd=ROOT, env=environment)
    return done.stdout.strip(), {path.name: path.read_bytes() for path in out.iterdir()}


def test_a_locale_with_a_decimal_comma_and_one_without_letters_beyond_ascii(tmp_path):
    """In zones apart; where only ASCII is known, any other file would need its encoding named."""
    place, german, plain = (tmp_path / name for name in ("locales", "german", "plain"))
    for folder in (place, german, plain):
        folder.mkdir()
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(place / "de_DE.UTF-8")]
    made = shutil.which(command[0]) and not execute(*command, check=False).returncode
    own = {"LC_ALL": "de_DE.UTF-8", "LOCPATH": str(place)} if made else {"LC_ALL": "C.UTF-8"}
    comma, files = built(german, TZ="Europe/Berlin", **own)
    ascii_alone = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    point, others = built(plain, TZ="Pacific/Kiritimati", PYTHONHASHSEED="1", **ascii_alone)
    assert point == "."
    assert set(files) == {"fig14.csv", "fig14.svg", "fig14.png"}
    assert files == others
    if not made:
        pytest.skip("needs localedef and the sources of locales; on Debian: apt install locales")
    assert comma == ","
