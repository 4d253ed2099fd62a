"""Normal impacts against heyoka: another integrator, in 80-bit numbers, and in another scale."""

from __future__ import annotations

import platform

import numpy as np
import pytest

from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import normal_impact

pytest.importorskip("heyoka", reason="heyoka is not installed; make test-peers runs this")
if platform.machine() not in {"x86_64", "AMD64"}:
    pytest.skip("80-bit numbers are an affair of x86 processors", allow_module_level=True)

from benchmarks.cases import judge, make_cases, make_jkr_cases
from benchmarks.own import Jkr, Kernel
from benchmarks.taylor import Batch, JkrReference, Reference, Scalar
from tests.peers.heyoka_impact import impact

AGREEMENT = 1e-12
IMPACT = (
    "coefficient_of_restitution",
    "contact_time",
    "compression_time",
    "maximum_compression",
    "compressive_impulse",
    "peak_net_impulse",
    "hertz_impulse",
)
LEDGER = ("adhesion_impulse", "hertz_work", "adhesion_work")

STEEL = Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.28, density=8000.0)
SILICON = Material(name="silicon", youngs_modulus=169e9, poissons_ratio=0.25, density=2330.0)


def contact(**changes: object) -> Contact:
    fields = {
        "particle": STEEL,
        "surface": SILICON,
        "diameter": 62e-6,
        "work_of_adhesion": 0.7,
        "hertz_damping": 0.02,
        "adhesion_damping": 1.6,
    }
    return Contact(**(fields | changes))


CONTACTS = {
    "n = 0": contact(),
    "n = 1": contact(adhesion_rate_exponent=1.0, reference_velocity=1.66, hertz_damping=0.21),
    "n = 1/2": contact(adhesion_rate_exponent=0.5, reference_velocity=1.0),
    "no adhesion": contact(work_of_adhesion=0.0),
    "no adhesion, no damping": contact(work_of_adhesion=0.0, hertz_damping=0.0),
    "no damping": contact(hertz_damping=0.0, adhesion_damping=0.0),
    "damped by adhesion alone": contact(hertz_damping=0.0),
    "damped by the material alone": contact(adhesion_damping=0.0),
    "strong adhesion": contact(
        work_of_adhesion=3.5, diameter=5e-6, hertz_damping=0.002, adhesion_damping=0.1
    ),
    "Eq. (31)": contact(stiffness_model="reduced"),
    "on a sphere": contact(surface_radius=1e-4),
}
SPEEDS = (0.02, 0.05, 0.2, 0.6, 1.66, 5.0, 30.0)


@pytest.mark.parametrize("name", CONTACTS)
def test_times_impulses_and_works(name: str) -> None:
    given = CONTACTS[name]
    own = normal_impact(given, np.array(SPEEDS), ledger=True)
    assert own.ledger is not None
    rebounds = 0
    for i, speed in enumerate(SPEEDS):
        peer = impact(given, speed)
        assert bool(own.captured[i]) == peer.captured, speed
        if peer.captured:
            continue
        rebounds += 1
        for field in IMPACT:
            expected = pytest.approx(getattr(peer, field), rel=AGREEMENT, abs=0.0)
            assert getattr(own, field)[i] == expected, (field, speed)
        for field in LEDGER:
            expected = pytest.approx(getattr(peer, field), rel=AGREEMENT, abs=0.0)
            assert getattr(own.ledger, field)[i] == expected, (field, speed)
    assert rebounds >= 3


def test_capture_is_seen_alike() -> None:
    verdicts = [impact(CONTACTS["strong adhesion"], speed).captured for speed in SPEEDS]
    assert any(verdicts)
    assert not all(verdicts)


@pytest.mark.parametrize("peer", [Scalar, Batch])
def test_the_peers_of_the_benchmark_solve_the_same_problem(peer: type) -> None:
    cases = make_cases(60)
    reference = Reference(cases, *Reference.settings)()
    for method in (peer, Kernel):
        errors = judge(method(cases, 1e-12)(), reference)
        assert errors.wrong == 0
        assert errors.largest < AGREEMENT


@pytest.mark.parametrize("name", ["jkr-pair", "viscous-jkr-pair"])
def test_two_jkr_spheres(name: str) -> None:
    cases = make_jkr_cases(60, name)
    errors = judge(Jkr(cases, 0.0)(), JkrReference(cases, *JkrReference.settings)())
    assert errors.largest < AGREEMENT
