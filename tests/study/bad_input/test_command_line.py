"""Whatever numbers the command line is given, it answers or says in one line why not."""

from __future__ import annotations

import json
import math

import pytest
from click.testing import CliRunner

from microimpact.cli import commands

PAIR = ("--particle", "stainless-steel-316", "--surface", "silicon")
NUMBERS = ("", "nan", "-inf", "1e999", "1,5", "0x10", "1_0", "\u0663", "-1", "0", "1e-300", "1e300")


def answer(arguments):
    """Run a command as `main` does; return its JSON, or None after a refusal."""
    done = CliRunner().invoke(commands, [*arguments, "--json"])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        assert isinstance(done.exception, ValueError | TypeError | OSError), repr(done.exception)
        assert str(done.exception).strip()
        return None
    if done.exit_code:
        assert done.exit_code == 2
        assert "Error: " in done.output
        return None
    return json.loads(done.stdout)["outputs"]


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("option", ["speed", "angle", "spin", "diameter-um"])
def test_an_impact(option, number):
    usual = {"speed": "1.66", "angle": "50", "spin": "0", "diameter-um": "62"} | {option: number}
    outputs = answer(["simulate", *PAIR, *(f"--{key}={value}" for key, value in usual.items())])
    if outputs is not None:
        assert 0.0 <= outputs["coefficient_of_restitution"] <= 1.0 + 1e-12
        assert math.isfinite(outputs["spin"])


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("option", ["work-of-adhesion", "hertz-damping", "adhesion-damping"])
def test_a_capture_velocity(option, number):
    outputs = answer(["capture", *PAIR, f"--{option}={number}"])
    if outputs is not None:
        assert outputs["capture_velocity"] is None or outputs["capture_velocity"] >= 0.0


@pytest.mark.parametrize("name", ["<script>", "", "steel\n", "../../etc/passwd", "ß" * 300])
def test_a_material_that_is_none(name):
    done = CliRunner().invoke(commands, ["capture", "--particle", name, "--surface", "silicon"])
    assert isinstance(done.exception, ValueError)
    assert f"{name!r} is not declared" in str(done.exception)
