"""References to what is declared once, and overlays."""

from __future__ import annotations

from dataclasses import dataclass, make_dataclass
from typing import Annotated, Literal

from study.declared.parameters import Seed
from study.declared.references import Resolver, merged


@dataclass(frozen=True, kw_only=True)
class Constant:
    at: float
    kind: Literal["constant"] = "constant"


@dataclass(frozen=True, kw_only=True)
class Normal:
    mean: float
    sd: float
    kind: Literal["normal"] = "normal"


@dataclass(frozen=True, kw_only=True)
class Spin:
    sd: float
    mean: float


@dataclass(frozen=True, kw_only=True)
class Drop:
    diameter_um: Constant | Normal
    speed_m_per_s: float
    spin: Spin


@dataclass(frozen=True, kw_only=True)
class Params:
    seed: Seed
    drops: dict[str, Drop]
    fast_m_per_s: float
    range_m_per_s: tuple[float, float]


def given(value, evidence="printed", source="Section 2"):
    return {
        "values" if isinstance(value, list) else "value": value,
        "evidence": evidence,
        "source": source,
    }


SIZES = {"kind": "normal", "mean": {"from": "particles.SST65.mean_um"}, "sd": given(9.0)}
WORDS = {"evidence": "assumed", "source": "as there"}
LABORATORY = {
    "seed": given(7, "chosen", "root"),
    "particles": {
        "SST65": {
            "material": "steel",
            "mean_um": given(49),
            "diameter_um": SIZES,
        }
    },
    "speeds": {"fast, 1": {"speed_m_per_s": given(1.6), "range_m_per_s": given([1.5, 1.7])}},
    "spins": {"none": {"sd": given(0.0), "mean": given(0.0)}},
    "steel": {"from": ["particles.SST65", "speeds.fast, 1"], "spin": {"from": "spins.none"}},
    "study": {
        "drops": {"a": {"from": "steel"}, "b": {"from": "steel", "spin": {"mean": given(0.5)}}},
        "fast_m_per_s": {"from": "speeds.fast, 1.speed_m_per_s", **WORDS},
        "range_m_per_s": {"from": "speeds.fast, 1"},
    },
}  # fmt: skip
SECTIONS = ("particles", "speeds", "spins", "steel")


def resolved(changes=(), kind=Params):
    resolver = Resolver(merged(LABORATORY, dict(changes)), LABORATORY, SECTIONS)
    return resolver, resolver.resolved(kind, "study")


def row(resolver, key):
    (found,) = (row for row in resolver.rows if row.key == key)
    return found


def test_a_reference_gives_the_fields_that_are_wanted():
    resolver, study = resolved()
    assert not resolver.problems
    sizes = {"kind": "normal", "mean": 49, "sd": 9.0}
    a = {"diameter_um": sizes, "speed_m_per_s": 1.6, "spin": {"sd": 0.0, "mean": 0.0}}
    assert study == {
        "seed": study["seed"],
        "drops": {"a": a, "b": {**a, "spin": {"sd": 0.0, "mean": 0.5}}},
        "fast_m_per_s": 1.6,
        "range_m_per_s": [1.5, 1.7],
    }
    assert row(resolver, "study.drops.a.diameter_um.mean").origin == "particles.SST65.mean_um"
    assert row(resolver, "study.fast_m_per_s").evidence == "assumed"


def test_of_several_places_the_first_that_has_a_field_gives_it():
    beside = {"speeds": {"fast, 1": {"diameter_um": given(1.0)}}}
    resolver, study = resolved(beside)
    assert not resolver.problems
    assert study["drops"]["a"]["diameter_um"] == {"kind": "normal", "mean": 49, "sd": 9.0}


def test_a_value_beside_a_reference_is_told_as_one_in_its_place():
    resolver, _ = resolved()
    assert row(resolver, "study.drops.b.spin.mean").overrides == "spins.none.mean = 0"
    assert not row(resolver, "study.drops.b.spin.sd").overrides
    resolver, study = resolved({"study": {"fast_m_per_s": 3.0}})
    assert study["fast_m_per_s"] == 3.0
    found = row(resolver, "study.fast_m_per_s")
    assert (found.evidence, found.overrides) == ("user", "speeds.fast, 1.speed_m_per_s = 1.6")


def test_what_is_changed_in_the_laboratory_moves_all_that_names_it():
    resolver, study = resolved({"particles": {"SST65": {"mean_um": 50}}})
    assert [drop["diameter_um"]["mean"] for drop in study["drops"].values()] == [50, 50]
    assert row(resolver, "study.drops.a.diameter_um.mean").evidence == "user"
    assert not row(resolver, "study.drops.a.diameter_um.mean").overrides


def test_a_distribution_is_replaced_as_a_whole():
    constant = {"kind": "constant", "at": 3.0}
    for changes in (
        {"particles": {"SST65": {"diameter_um": constant}}},
        {"study": {"drops": {"a": {"diameter_um": constant}}}},
    ):
        resolver, study = resolved(changes)
        assert study["drops"]["a"]["diameter_um"] == constant
        assert not resolver.problems
    told = row(resolver, "study.drops.a.diameter_um.at").overrides
    assert told == "particles.SST65.diameter_um"


def test_a_distribution_keeps_the_place_of_a_number_that_is_replaced():
    old = {"kind": "constant", "at": {"from": "frictions.steel"}}
    assert merged(old, {"kind": "constant", "at": 0.2}) == {
        "kind": "constant",
        "at": {"from": "frictions.steel", "value": 0.2},
    }
    uniform = {"kind": "uniform", "low": 0.1, "high": 0.2}
    assert merged(old, uniform) == uniform


def test_numbers_of_a_distribution_change_without_its_kind():
    resolver, study = resolved({"particles": {"SST65": {"diameter_um": {"sd": 3.0}}}})
    assert study["drops"]["a"]["diameter_um"] == {"kind": "normal", "mean": 49, "sd": 3.0}
    assert not resolver.problems


def test_what_is_taken_away_must_be_there():
    assert merged({"a": 1, "b": 2}, {"a": None, "c": None}) == {"b": 2, "c": None}


def test_names_are_added_and_taken_away():
    drops = {"a": None, "c": {"from": "steel", "speed_m_per_s": 2.0}}
    _, study = resolved({"study": {"drops": drops}})
    assert list(study["drops"]) == ["b", "c"]
    assert study["drops"]["c"]["speed_m_per_s"] == 2.0


def test_a_declaration_is_replaced_as_a_whole():
    old = {"a": given(1), "b": given(2)}
    assert merged(old, {"a": {"value": 3}}) == {"a": {"value": 3}, "b": given(2)}
    assert merged(old, {"a": 3})["a"] == 3
    assert merged({"a": [1, 2]}, {"a": [3]}) == {"a": [3]}
    assert merged({"a": {"from": "x"}}, {"a": {"from": "y"}}) == {"a": {"from": "y"}}
    assert old == {"a": given(1), "b": given(2)}


def test_every_analysis_draws_from_the_root_seed_by_its_name():
    def seeds(root=7, own=(), kind=Params):
        resolver = Resolver(
            merged(LABORATORY, {"seed": root, "study": dict(own), "other": LABORATORY["study"]}),
            LABORATORY,
            SECTIONS,
        )
        return [resolver.resolved(kind, name)["seed"] for name in ("study", "other")]

    one, other = seeds()
    assert one != other
    assert seeds() == [one, other]
    assert not {one, other} & set(seeds(root=8))
    assert seeds(own={"seed": 3}) == [3, other]
    shared = make_dataclass("Shared", [("seed", Annotated[int, "both"])])
    assert len(set(seeds(kind=shared))) == 1
    resolver, _ = resolved()
    assert row(resolver, "study.seed").evidence == "derived"
    assert row(resolver, "study.seed").source == "from the root seed, 7, and the name 'study'"


def test_what_nothing_rests_on_is_told():
    resolver, _ = resolved({"speeds": {"slow": {"speed_m_per_s": 0.4}}})
    assert resolver.unused() == ["particles.SST65.material", "speeds.slow.speed_m_per_s"]
