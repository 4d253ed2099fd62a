"""Small made-up results folders, and the command run on them."""

from __future__ import annotations

import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

import numpy as np
from matplotlib.figure import Figure

from microimpact import cli
from microimpact.figures.style import context, save
from microimpact.report.commands import commands

INPUTS = """file,key,value,low,high,unit,evidence,source
config,seed,20011,,,-,chosen,root of every draw
config,friction.points,36,,,-,chosen,smooth curves
materials.csv,glass density,2500,2400,2600,kg/m3,found,handbook
"""
CLAIMS = """id,statement,computed_value,verdict
C01,falls,0.44,reproduced
C02,sticks,0.2,not reproduced
"""


def curve(slope):
    x = np.linspace(0, 1, 30)
    return x, slope * x**2


def figure_data(slope):
    points = np.transpose(curve(slope)).tolist()
    rows = "".join(f"a,e,computed,{x},{y},,\n" for x, y in points)
    return "panel,series,evidence,x_m_per_s,y_1,y_low,y_high\n" + rows


def draw(root, name, slope, *, label="restitution", lines=1):
    """Save a figure of some curves."""
    (root / "figures").mkdir(parents=True, exist_ok=True)
    for suffix, content in drawn(slope, label, lines).items():
        (root / f"figures/{name}{suffix}").write_bytes(content)


@cache
def drawn(slope, label, lines):
    with context():
        figure = Figure(figsize=(3.4, 2.4))
        ax = figure.subplots()
        for i in range(lines):
            ax.plot(*curve(slope / (i + 1)), label=label)
        ax.plot([0.2, 0.8], [0.2, 0.8], "o", color="black")
        ax.set(xlabel="speed", ylabel="e", ylim=(0, 1))
        ax.legend()
    with TemporaryDirectory() as folder:
        paths = [Path(folder, f"x{suffix}") for suffix in (".svg", ".png")]
        save(figure, *paths)
        return {path.suffix: path.read_bytes() for path in paths}


def results(root, *, slope=0.7, inputs=INPUTS, claims=CLAIMS, commit="abc"):
    """Write a results folder with two tables, one figure and a run stamp."""
    for name, text in {
        "tables/inputs.csv": inputs,
        "tables/claims.csv": claims,
        "data/fig14.csv": figure_data(slope),
        "run.json": json.dumps({"ended": "today", "git": {"commit": commit}, "config": {"x": 1}}),
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    draw(root, "fig14", slope)
    return root


def run(*arguments):
    """Run the command: exit code, output and errors."""
    out, err = io.StringIO(), io.StringIO()
    given = ["microimpact", *map(str, arguments)]
    with patch.object(sys, "argv", given), redirect_stdout(out), redirect_stderr(err):
        try:
            cli.run(commands)
            code = 0
        except SystemExit as end:
            code = end.code
    return code, out.getvalue(), err.getvalue()
