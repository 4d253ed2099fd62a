"""Small made-up results folders, and the command run on them."""

from __future__ import annotations

import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from unittest.mock import patch

from microimpact import cli
from study.report.commands import commands

INPUTS = """file,key,value,low,high,unit,evidence,source,origin
config,seed,20011,,,-,chosen,root of every draw,
config,friction.points,36,,,-,chosen,smooth curves,
materials,glass.density,2500,2400,2600,kg/m3,found,handbook,
"""
CLAIMS = """id,statement,criterion,computed_value,verdict
C01,falls,at most 1,0.44,reproduced
C02,sticks,at least 1,0.2,not reproduced
"""
CLAIM_RESULTS = """id,case,quantity,value,test
C01,,fall,0.44,
C02,,share,0.2,
"""
SVG = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0L1 {slope}"/></svg>\n'
CONTENT = """panel,artist,text,look,x_low,x_high,y_low,y_high
figure,title,Restitution,,,,,
a,Line2D,n = 0,#0072b2 1.2: 5,0.0,100.0,0.0,{slope}
a,Line2D,n = 1,#d55e00 1.2: 5,0.0,100.0,0.0,{slope}
"""


def figure_data(slope):
    rows = "".join(f"a,e,computed,{x / 4},{slope * x**2 / 16},,\n" for x in range(5))
    return "panel,series,evidence,x_m_per_s,y_1,y_low,y_high\n" + rows


def write(root, files):
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return root


def draw(root, name, slope):
    """Write the picture of a figure and its content."""
    shown = {"svg": SVG, "csv": CONTENT, "png": "", "pdf": ""}
    return write(
        root,
        {
            f"figures/{name}.{kind}": text.replace("{slope}", str(slope))
            for kind, text in shown.items()
        },
    )


def results(root, *, slope=0.7, inputs=INPUTS, claims=CLAIMS, commit="abc"):
    """Write a results folder with three tables, one figure and a run stamp."""
    stamp = {"ended": "today", "git": {"commit": commit}, "config": {"x": 1}}
    files = {
        "tables/inputs.csv": inputs,
        "tables/claims.csv": claims,
        "tables/claim_results.csv": CLAIM_RESULTS,
        "data/fig14.csv": figure_data(slope),
        "run.json": json.dumps(stamp),
    }
    return draw(write(root, files), "fig14", slope)


def edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def run(*arguments):
    """Run the command: exit code, output and errors."""
    out, err = io.StringIO(), io.StringIO()
    words = ["microimpact", *map(str, arguments)]
    with patch.object(sys, "argv", words), redirect_stdout(out), redirect_stderr(err):
        try:
            cli.run(commands)
            code = 0
        except SystemExit as end:
            code = end.code
    return code, out.getvalue(), err.getvalue()
