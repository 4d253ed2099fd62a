"""The search for declared values that move no output: it finds one, and takes no other for one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import pandas as pd
import pytest
from tests import dead_inputs
from tests.dead_inputs import EXCEPTIONS, Found, Rests, World, faults, fits, tried

STUDY = "restitution_trends"
DEAD = f"{STUDY}.body_exponent"


@pytest.fixture(scope="module")
def document():
    return dead_inputs.declared()


@pytest.fixture(scope="module")
def resolved(document):
    return dead_inputs.resolved(document)


def world_of(document, rests, results, **parts):
    world = World(document=document, results=results, rests=rests, **parts)
    world.before[STUDY] = dead_inputs.unchanged(STUDY, world)
    return world


def found_in(world, branch):
    return {one.key: tried(one, world) for one in dead_inputs.values(world.document)
            if one.key.startswith(f"{branch}.")}  # fmt: skip


def test_every_value_of_a_study_moves_its_table(document, resolved, tmp_path):
    found = found_in(world_of(document, resolved, tmp_path), STUDY)
    assert DEAD in found
    assert {one.verdict for one in found.values()} == {"moved"}
    assert {one.by for one in found.values()} == {STUDY}


def test_a_parameter_that_the_study_does_not_read_is_dead(
    document, resolved, tmp_path, monkeypatch
):
    real = dead_inputs.study(STUDY)

    def run(params, inputs):
        return real.run(replace(params, body_exponent=1.2), inputs)

    study = SimpleNamespace(Params=real.Params, run=run)
    monkeypatch.setattr(dead_inputs, "study", lambda name: study)
    found = found_in(world_of(document, resolved, tmp_path), STUDY)
    assert {key for key, one in found.items() if one.verdict == "dead"} == {DEAD}


def test_a_key_that_reaches_no_study_is_dead(document, resolved, tmp_path):
    world = world_of(document, resolved, tmp_path)
    (chunks,) = [one for one in dead_inputs.values(document) if one.key == "chunks"]
    assert tried(chunks, world).verdict == "dead"


@dataclass(frozen=True)
class Params:
    read: int
    never_read: int
    case: str


def in_parts(params, inputs, index, count):
    return params.read if index == count - 1 else 0


SMALL = {
    "config": {STUDY: {"read": 3, "never_read": 3, "case": "first"}, "other": {"case": "second"}},
    "claims": {},
    "places": [],
    **{name: {} for name in dead_inputs.TABLES},
}


def small(document, *_):
    branch = document["config"][STUDY]
    if branch["case"] not in {"first", "second"}:
        raise ValueError(f"case: {branch['case']!r} must be 'first' or 'second'")
    return {STUDY: Rests(branch, {})}


@pytest.fixture
def small_world(tmp_path, monkeypatch):
    study = SimpleNamespace(
        Params=Params,
        part=in_parts,
        gather=lambda params, inputs, parts: {"t": pd.DataFrame([[sum(parts), params.case]])},
    )
    monkeypatch.setattr(dead_inputs, "study", lambda name: study)
    return world_of(SMALL, small(SMALL), tmp_path, resolve=small)


def test_of_a_study_in_parts_the_last_part_counts(small_world):
    found = found_in(small_world, STUDY)
    assert found[f"{STUDY}.read"].verdict == "moved"
    assert found[f"{STUDY}.never_read"].verdict == "dead"


def test_a_name_is_changed_to_one_that_stands_elsewhere(small_world):
    assert found_in(small_world, STUDY)[f"{STUDY}.case"].verdict == "moved"


@pytest.mark.parametrize(("last", "verdict"), [("second", "moved"), ("first", "dead")])
def test_another_place_of_the_same_value_is_no_change(small_world, last, verdict):
    places = {"a": "first", "b": "first", "c": "first", "d": "first", "e": last}
    references = {name: {"case": {"from": name}} for name in places}
    own = {"read": 3, "never_read": 3, **references["a"]}
    document = {**SMALL, "config": {**references, STUDY: own}}

    def followed(document, *_):
        branch = document["config"][STUDY]
        return {STUDY: Rests(branch | {"case": places[branch["case"]["from"]]}, {})}

    world = replace(
        small_world, document=document, resolve=followed, rests=followed(document), before={}
    )
    assert found_in(world, STUDY)[f"{STUDY}.case.from"].verdict == verdict


def test_where_a_reference_stands_a_user_may_put_a_number(small_world):
    def followed(document, *_):
        branch = document["config"][STUDY]
        return {STUDY: Rests(branch | {"read": branch["read"].get("value", 3)}, {})}

    own = {"read": {"from": "place"}, "never_read": 3, "case": "first"}
    document = {**SMALL, "config": {"place": {"read": 3}, STUDY: own}}
    world = replace(
        small_world, document=document, resolve=followed, rests=followed(document), before={}
    )
    assert found_in(world, STUDY)[f"{STUDY}.read.from"].verdict == "moved"


def test_what_stands_in_place_of_a_reference_is_the_value():
    (number,) = dead_inputs.values({**SMALL, "config": {"a": {"from": "place", "value": 4}}})
    assert (number.key, number.value) == ("a", 4)


def test_a_text_to_which_aliases_refer_is_one_value(tmp_path):
    path = tmp_path / "figures.yaml"
    path.write_text("a: &a {p: 1, r: 5}\nb: {<<: *a, q: [2], r: 3}\nc: *a\n")
    assert set(dead_inputs.written(path)) == {
        (("figures", "a", "p"), ("figures", "b", "p"), ("figures", "c", "p")),
        (("figures", "a", "r"), ("figures", "c", "r")),
        (("figures", "b", "r"),),
        (("figures", "b", "q", 0),),
    }


def test_a_number_is_changed_to_one_that_the_refusal_names(small_world):
    def choosy(document, *_):
        read = document["config"][STUDY]["read"]
        if read not in {3, 7}:
            raise ValueError(f"read: {read} must be one of (3, 7)")
        return small(document)

    found = found_in(replace(small_world, resolve=choosy), STUDY)
    assert found[f"{STUDY}.read"].verdict == "moved"


def test_what_is_always_refused_is_told_as_not_tested(small_world, tmp_path):
    def refusing(document, *_):
        if document is not SMALL:
            raise ValueError("not this one")
        return small(document)

    found = found_in(replace(small_world, resolve=refusing), STUDY)
    assert {one.verdict for one in found.values()} == {"not tested"}
    assert "not this one" in found[f"{STUDY}.read"].by


def test_a_value_whose_changes_all_stop_the_study_is_needed(small_world, monkeypatch):
    def gather(params, inputs, parts):
        raise KeyError(params.read)

    monkeypatch.setattr(dead_inputs.study(STUDY), "gather", gather)
    found = found_in(small_world, STUDY)
    assert {one.verdict for one in found.values()} == {"needed"}
    assert found[f"{STUDY}.read"].by == "4: KeyError: 4"


def test_another_run_than_that_of_this_state_is_told(small_world):
    path = small_world.results / "tables/t.csv"
    path.parent.mkdir()
    table = small_world.before.pop(STUDY).tables["t"]
    path.write_text("0,1\n4,first\n")
    with pytest.raises(
        dead_inputs.StaleRunError, match=rf"^{path} is not of this state; make the run anew$"
    ):
        found_in(small_world, STUDY)
    table.to_csv(path, index=False, lineterminator="\n")
    assert found_in(small_world, STUDY)[f"{STUDY}.read"].verdict == "moved"


FOUND = [
    Found(key="a.dead[0]", value=1, verdict="dead"),
    Found(key="a.dead[1]", value=2, verdict="dead"),
    Found(key="a.moved", value=3, verdict="moved"),
]


@pytest.mark.parametrize(
    ("meant", "expected"),
    [
        ({"a.dead*": "reason"}, []),
        ({"a.dead[0]": "reason"}, ["a.dead[1]: 2 moves no output"]),
        ({"a.*": "reason"}, [f"{EXCEPTIONS.name}, a.*: a.moved is moved, not dead"]),
        ({"a.dead*": "reason", "a.gone": "reason"}, [f"{EXCEPTIONS.name}, a.gone: no such value"]),
    ],
)
def test_faults_are_dead_values_without_reason_and_reasons_without_dead_value(meant, expected):
    assert faults(FOUND, meant) == expected


def test_every_number_of_a_criterion_is_a_value(document):
    keys = {one.key for one in dead_inputs.values(document)}
    for name, claim in document["claims"].items():
        for i, criterion in enumerate(claim.get("criteria", [])):
            own = {f"claims.{name}.criteria[{i}].{part}" for part in criterion}
            assert own - keys == {f"claims.{name}.criteria[{i}].{p}" for p in ("quantity", "test")}


def test_every_exception_names_a_value_and_gives_a_reason(document):
    keys = [one.key for one in dead_inputs.values(document)]
    for pattern, reason in dead_inputs.exceptions().items():
        assert any(fits(pattern, key) for key in keys), pattern
        assert len(reason.split()) > 3, pattern
