"""The command that tells one claim: words and numbers, a changed input, one line for bad input."""

import pandas as pd
import pytest
from click.testing import CliRunner

from study.report.claim import changed, judged, tell
from study.report.commands import commands
from study.tables import write_table


@pytest.fixture
def nowhere(tmp_path):
    return tmp_path / "results"


def test_a_claim_is_told_with_all_that_decides_it(nowhere):
    text = tell("C58", {}, nowhere)
    for part in (
        "The impacts hardly deform the materials plastically.",
        "Reason of the criterion: Minimal means",
        "plastic loss / measured loss [at most 0.1]",
        "1.832 (annealed)",
        "Verdict: not identified",
        "conclusions.c58, ",
        "conclusions.py:",
        "Inputs: branch claim_numbers, calibration (of calibration), materials",
    ):
        assert part in text
    assert not nowhere.exists()


def test_the_numbers_of_a_run_are_told(tmp_path, monkeypatch):
    numbers = judged("C58").numbers.assign(value=0.05)
    others = numbers.assign(claim="C57", value=1.0)
    for name, table in (("claim_numbers", pd.concat([others, numbers])), ("claim_draws", others)):
        write_table(table, tmp_path / f"tables/{name}.csv")
    facts = pd.DataFrame(columns=["fact", "claim", "verdict"])
    write_table(facts, tmp_path / "tables/external_evidence.csv")
    monkeypatch.setattr("study.report.claim._shipped", lambda folder: True)
    text = tell("C58", {}, tmp_path)
    assert "0.05 (annealed)" in text
    assert f"Numbers: {tmp_path}" in text


@pytest.mark.parametrize(
    ("name", "setting", "value", "verdict"),
    [
        ("C17", "angles_deg", "[42.0, 52.0]", "not reproduced"),
        ("C77", "spin_ratio", "0.0", "not reproduced"),
    ],
)
def test_a_changed_value_gives_another_verdict(name, setting, value, verdict, nowhere):
    text = tell(name, changed([f"claim_numbers.{name}.{setting}={value}"]), nowhere)
    assert f"\nVerdict: {verdict}\n" in text
    assert f"Changed: {{claim_numbers: {{{name}: {{{setting}: {value}}}}}}}" in text


def test_studies_on_which_a_claim_rests_follow_the_change(nowhere):
    plain, doubled = (
        tell("C32", changed(settings), nowhere)
        for settings in ([], ["fig20_force_history.diameter_um=2.58"])
    )
    assert "Verdict: reproduced" in plain
    assert "0.352" in plain
    assert "0.352" not in doubled


def test_a_claim_without_a_test_is_told(nowhere):
    assert tell("C90", {}, nowhere).endswith("Verdict: not testable")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["C10O"], "'C10O' is no claim (did you mean 'C10'?)"),
        (["C04", "--set", "claim_numbers"], "--set: 'claim_numbers' must be of the form key=value"),
        (["C04", "--set", "claim_numbers.C4.x=1"], "claim_numbers.C4: unknown key (did you me"),
        (["C04", "--set", "claim_numbers.C04=[}"], "--set: '[}' is no value that YAML knows"),
    ],
)
def test_bad_input_gives_one_line(arguments, message):
    outcome = CliRunner().invoke(commands, ["claim", *arguments])
    assert isinstance(outcome.exception, ValueError)
    (line,) = str(outcome.exception).splitlines()
    assert line.startswith(message)
