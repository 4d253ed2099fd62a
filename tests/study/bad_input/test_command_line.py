"""Whatever numbers the command line is given, it answers or says in one line why not."""

from __future__ import annotations

import json
import math

import pytest
from click.testing import CliRunner
from hypothesis import example, given, settings
from hypothesis import strategies as st

from microimpact.cli import commands

numbers = st.one_of(
    st.floats(),
    st.integers(-(10**40), 10**40),
    st.sampled_from(["", "-", "1,5", "0x10", "1e", "one", "1_0", " 7", "٣", "\u2212\u0031"]),
).map(str)


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
    return json.loads(done.stdout)


PAIR = ("--particle", "stainless-steel-316", "--surface", "silicon")


@settings(deadline=None, derandomize=True, max_examples=120)
@given(speed=numbers, angle=numbers, spin=numbers, diameter=numbers)
@example(speed="1.66", angle="50", spin="0", diameter="62")
@example(speed="1e-300", angle="90", spin="1e300", diameter="1e-300")
@example(speed="299792457", angle="1e-300", spin="-0.0", diameter="1e9")
def test_an_impact(speed, angle, spin, diameter):
    found = answer(
        ["simulate", *PAIR, f"--speed={speed}", f"--angle={angle}", f"--spin={spin}",
         f"--diameter-um={diameter}"]
    )  # fmt: skip
    if found is not None:
        found = found["outputs"]
        e = found["coefficient_of_restitution"]
        assert 0.0 <= e <= 1.0 + 1e-12
        assert math.isfinite(found["spin"])


@settings(deadline=None, derandomize=True, max_examples=120)
@given(work=numbers, hertz=numbers, adhesion=numbers)
@example(work="0.5", hertz="0", adhesion="3")
def test_a_capture_velocity(work, hertz, adhesion):
    found = answer(
        ["capture", *PAIR, f"--work-of-adhesion={work}", f"--hertz-damping={hertz}",
         f"--adhesion-damping={adhesion}"]
    )  # fmt: skip
    if found is not None:
        velocity = found["outputs"]["capture_velocity"]
        assert velocity is None or velocity >= 0.0


@pytest.mark.parametrize("name", ["<script>", "", "steel\n", "../../etc/passwd", "%s", "ß" * 300])
def test_a_material_that_is_none(name):
    done = CliRunner().invoke(commands, ["capture", "--particle", name, "--surface", "silicon"])
    assert isinstance(done.exception, ValueError)
    assert "is not declared" in str(done.exception)
    assert repr(name) in str(done.exception)
