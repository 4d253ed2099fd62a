"""What must be true of every contact and every impact, whatever the numbers.

Contacts are drawn over four decades of size, soft to hard materials, and damping from none to so
much that no speed rebounds.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from microimpact import (
    JKR,
    Contact,
    Hysteresis,
    Material,
    MaugisBarquins,
    ThorntonNing,
    capture_velocity,
    planar,
    simulate,
    spatial,
    tabulate,
    trajectory,
)
from microimpact.model.contact_laws import EDGE_SPEEDS
from microimpact.model.dynamics.normal import normal_impact

settings.register_profile("interface", deadline=None, max_examples=60, derandomize=True)
settings.load_profile("interface")


def decades(low, high):
    """Numbers whose logarithms are drawn evenly."""
    return st.floats(low, high).map(lambda power: 10.0**power)


@st.composite
def materials(draw):
    return Material(
        name=draw(st.sampled_from(["a", "b"])),
        youngs_modulus=draw(decades(7.0, 12.0)),
        poissons_ratio=draw(st.floats(-0.9, 0.5)),
        density=draw(decades(2.0, 4.3)),
    )


@st.composite
def contacts(draw, adhesive=True):
    """Contacts by their damping groups: the numbers that decide, whatever the materials."""
    fields = {
        "particle": draw(materials()),
        "surface": draw(materials()),
        "diameter": draw(decades(-7.0, -3.0)),
        "friction": draw(st.floats(0.0, 1.5)),
    }
    if not adhesive:
        bare = Contact(work_of_adhesion=0.0, **fields)
        return bare.replace(hertz_damping=draw(st.sampled_from([0.0, 1e-3, 0.05, 0.3])))
    work = draw(decades(-3.0, 0.7))
    bare = Contact(work_of_adhesion=work, **fields)
    scale = bare.velocity_scale
    hertz = draw(st.one_of(st.just(0.0), decades(-4.0, 0.5)))
    adhesion = draw(st.one_of(st.just(0.0), decades(-3.0, 0.5)))
    exponent = draw(st.sampled_from([0.0, 0.5, 1.0]))
    return bare.replace(
        hertz_damping=hertz / scale,
        adhesion_damping=adhesion / scale,
        adhesion_rate_exponent=exponent,
        reference_velocity=scale * draw(decades(-1.0, 2.0)),
        damped_attachment=draw(st.booleans()),
    )


@st.composite
def by_other_laws(draw):
    """Contacts by the other laws, from elastic ones to those that keep next to nothing."""
    bare = draw(contacts())
    work = bare.work_of_adhesion
    pressure = float(bare.stiffness) * draw(decades(-4.0, 0.0))
    time = float(bare.equilibrium_compression / bare.velocity_scale) * draw(decades(-4.0, 0.0))
    laws = (
        JKR(),
        JKR(viscous_time=time),
        ThorntonNing(yield_pressure=pressure),
        Hysteresis(unloading_work=work * draw(decades(0.0, 2.0))),
        MaugisBarquins(
            edge_speed=min(float(bare.velocity_scale) * draw(decades(-4.0, 8.0)), EDGE_SPEEDS[1]),
            edge_exponent=draw(st.floats(0.05, 2.0)),
            viscous_time=draw(st.sampled_from([0.0, time])),
        ),
    )
    return bare.by_law(draw(st.sampled_from(laws)), work)


any_law = st.one_of(contacts(), by_other_laws())

# Speeds in units of the contact's own scale, and what else an impact needs.
ratios = decades(-3.0, 4.0)
impacts = st.fixed_dictionaries(
    {
        "angle": st.floats(0.5, 90.0),
        "spin_ratio": st.floats(-3.0, 3.0),
        "friction_basis": st.sampled_from(["compressive", "hertz", "net"]),
    }
)


def speed_of(contact, ratio):
    scale = float(contact.velocity_scale)
    speed = ratio * scale if scale > 0.0 else ratio
    assume(speed < 1e6)
    return speed


def outcome(contact, ratio, impact):
    speed = speed_of(contact, ratio)
    spin = impact["spin_ratio"] * speed / contact.radius
    laws = {name: impact[name] for name in ("friction_basis", "tangential") if name in impact}
    return speed, spin, simulate(contact, speed, impact["angle"], spin, **laws)


def kinetic(speed, spin, radius):
    """Translational and rotational energy per half a mass."""
    return speed**2 + 0.4 * (radius * spin) ** 2


@given(
    contact=any_law,
    ratio=decades(-5.0, 4.0),
    impact=impacts,
    tangential=st.sampled_from(["rigid", "mindlin", "spring"]),
)
def test_no_impact_gains_energy_and_restitution_lies_between_0_and_1(
    contact, ratio, impact, tangential
):
    if contact.law is not None:
        assume(tangential == "rigid")
        own = "net" if isinstance(contact.law, MaugisBarquins) else "pull-off"
        basis = own if impact["friction_basis"] == "hertz" else impact["friction_basis"]
        impact = impact | {"friction_basis": basis}
    if tangential != "rigid":
        assume(impact["friction_basis"] != "net")
        impact = impact | {"tangential": tangential}
    speed, spin, found = outcome(contact, ratio, impact)
    assert 0.0 <= found.coefficient_of_restitution <= 1.0 + 1e-12
    after = kinetic(
        np.hypot(found.normal_velocity, found.tangential_velocity), found.spin, contact.radius
    )
    assert after <= kinetic(speed, spin, contact.radius) * (1.0 + 1e-12)
    assert found.energy_loss >= -1e-12 * (1.0 + impact["spin_ratio"] ** 2)


@given(contact=contacts(), ratio=ratios)
def test_energy_and_momentum_are_accounted_for(contact, ratio):
    ledger = normal_impact(contact, speed_of(contact, ratio), ledger=True).ledger
    assert abs(ledger.energy_residual) < 1e-11
    assert abs(ledger.momentum_residual) < 1e-11
    assert ledger.hertz_work >= 0.0
    assert ledger.adhesion_work >= 0.0
    assert ledger.hertz_impulse > 0.0 > ledger.adhesion_impulse


@given(contact=by_other_laws(), ratio=ratios)
def test_what_other_laws_lose_goes_to_bulk_and_adhesion(contact, ratio):
    speed = speed_of(contact, ratio)
    impact = normal_impact(contact, speed)
    before = 0.5 * contact.mass * speed**2
    after = before * impact.coefficient_of_restitution**2
    # What a captured sphere keeps as surface energy counts as lost to adhesion.
    bulk, adhesion = impact.losses.bulk, impact.losses.adhesion
    assert after + bulk + adhesion == pytest.approx(before, abs=1e-12 * (before + abs(bulk)))
    assert bulk >= -1e-9 * before
    whole = contact.mass * speed * (1.0 + impact.coefficient_of_restitution)
    assert impact.compressive_impulse >= impact.peak_net_impulse * (1.0 - 1e-9)
    assert impact.peak_net_impulse >= whole * (1.0 - 1e-9)


@given(contact=any_law, ratio=ratios)
def test_capture_is_what_the_capture_velocity_says(contact, ratio):
    speed, limit = speed_of(contact, ratio), float(capture_velocity(contact))
    # Closer than this the speed and the limit cannot be told apart.
    assume(abs(speed - limit) > 1e-9 * speed)
    found = simulate(contact, speed)
    assert bool(found.captured) == (speed < limit)
    assert bool(found.captured) == (found.coefficient_of_restitution == 0.0)
    assert bool(found.captured) == np.isinf(found.contact_time)


@given(contact=contacts(), factor=decades(0.01, 0.5))
def test_more_adhesion_or_more_damping_captures_faster_spheres(contact, factor):
    limit = capture_velocity(contact)
    at_least = limit * (1.0 - 1e-10)
    assert capture_velocity(contact.replace(hertz_damping=contact.hertz_damping * factor)) >= (
        at_least
    )
    damped = contact.replace(adhesion_damping=contact.adhesion_damping * factor)
    assert capture_velocity(damped) >= at_least
    sticky = contact.replace(work_of_adhesion=contact.work_of_adhesion * factor)
    assert capture_velocity(sticky) >= at_least


@given(contact=any_law, ratio=ratios, factor=decades(0.001, 1.0))
def test_faster_spheres_press_deeper_and_leave_faster(contact, ratio, factor):
    slow = speed_of(contact, ratio)
    fast = speed_of(contact, ratio * factor)
    # At constant coefficients two paths of one equation of motion cannot cross.
    constant = contact.replace(adhesion_rate_exponent=0.0)
    one, two = simulate(constant, slow), simulate(constant, fast)
    assert two.maximum_compression >= one.maximum_compression * (1.0 - 1e-12)
    assert two.normal_velocity >= one.normal_velocity * (1.0 - 1e-12)


@given(contact=contacts(adhesive=False), speed=decades(-3.0, 2.0), factor=decades(0.001, 1.0))
def test_without_adhesion_restitution_falls_with_speed_and_nothing_is_captured(
    contact, speed, factor
):
    slow, fast = simulate(contact, speed), simulate(contact, speed * factor)
    assert capture_velocity(contact) == 0.0
    assert not slow.captured
    assert fast.coefficient_of_restitution <= slow.coefficient_of_restitution * (1.0 + 1e-12)
    if contact.hertz_damping == 0.0:
        assert slow.coefficient_of_restitution == pytest.approx(1.0, abs=1e-12)


@given(contact=contacts(), ratio=ratios, size=decades(-1.5, 1.5))
def test_similar_contacts_have_similar_impacts(contact, ratio, size):
    """e depends on v/V, C_H and C_A alone; w_A/r is kept, so V and the groups are."""
    other = contact.replace(
        diameter=contact.diameter * size, work_of_adhesion=contact.work_of_adhesion * size
    )
    assert other.velocity_scale == pytest.approx(contact.velocity_scale, rel=1e-12)
    speed = speed_of(contact, ratio)
    limit = float(capture_velocity(contact))
    # At the threshold e has an infinite slope, so rounding of V shows there.
    assume(abs(speed - limit) > 1e-3 * speed)
    one, two = simulate(contact, speed), simulate(other, speed)
    assert two.coefficient_of_restitution == pytest.approx(
        one.coefficient_of_restitution, rel=1e-9, abs=1e-12
    )
    assert two.maximum_compression == pytest.approx(one.maximum_compression * size, rel=1e-9, abs=0)
    if not one.captured:
        assert two.contact_time == pytest.approx(one.contact_time * size, rel=1e-9, abs=0)


@settings(max_examples=25)
@given(contact=contacts(), ratio=decades(-1.0, 2.0), impact=impacts)
def test_a_path_ends_where_the_impact_does(contact, ratio, impact):
    speed, spin, found = outcome(contact, ratio, impact)
    assume(not found.captured)
    limit = float(capture_velocity(contact))
    assume(abs(speed * np.sin(np.radians(impact["angle"])) - limit) > 1e-3 * limit)
    path = trajectory(
        contact, speed, impact["angle"], spin, friction_basis=impact["friction_basis"]
    )
    assert path.time[-1] == pytest.approx(found.contact_time, rel=1e-9, abs=0)
    assert path.velocity[-1] == pytest.approx(found.normal_velocity, rel=1e-8, abs=1e-10 * speed)
    assert path.spin[-1] == pytest.approx(found.spin, rel=1e-6, abs=1e-8 * speed / contact.radius)


def as_pair(contact, ratio):
    """The same damping groups between two spheres whose sizes have a ratio."""
    pair = contact.replace(partner_diameter=ratio * contact.diameter)
    change = contact.velocity_scale / pair.velocity_scale
    return pair.replace(
        hertz_damping=pair.hertz_damping * change,
        adhesion_damping=pair.adhesion_damping * change,
        reference_velocity=pair.reference_velocity / change,
    )


vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)


@given(
    contact=contacts(),
    size=decades(-1.5, 1.5),
    ratio=ratios,
    along=vectors,
    spin=vectors,
    partner_spin=vectors,
    tangential=st.sampled_from(["rigid", "mindlin"]),
)
def test_two_spheres_keep_momentum_and_angular_momentum(
    contact, size, ratio, along, spin, partner_spin, tangential
):
    pair = as_pair(contact, size)
    speed = speed_of(pair, ratio)
    radii = np.array([pair.diameter, pair.partner_diameter]) / 2.0
    densities = np.array([pair.particle.density, pair.surface.density])
    masses = densities * 4.0 / 3.0 * np.pi * radii**3
    velocity = speed * np.array([along[0], along[1], -1.0])
    spins = np.array([spin, partner_spin]) * speed / radii[:, None]
    after = spatial(pair, velocity, spins[0], tangential=tangential, partner_spin=spins[1])
    # Each sphere in the frame of the centre of mass, whose momentum is zero throughout.
    shares = np.array([masses[1], -masses[0]])[:, None] / masses.sum()
    arms = np.array([[0.0, 0.0, radii[0]], [0.0, 0.0, -radii[1]]])

    def angular(relative, turning):
        orbital = np.cross(arms, masses[:, None] * shares * relative)
        return np.sum(orbital + (0.4 * masses * radii**2)[:, None] * turning, axis=0)

    def energy(relative, turning):
        moving = np.sum(masses[:, None] * (shares * relative) ** 2)
        return moving + np.sum((0.4 * masses * radii**2)[:, None] * turning**2)

    turning = np.array([after.spin, after.partner_spin])
    before = angular(velocity, spins)
    scale = masses.min() * radii.max() * speed
    np.testing.assert_allclose(angular(after.velocity, turning), before, atol=1e-11 * scale * 10.0)
    lost = energy(velocity, spins) - energy(after.velocity, turning)
    assert lost == pytest.approx(
        after.energy_loss * pair.mass * np.sum(velocity**2), abs=1e-9 * energy(velocity, spins)
    )
    assert lost >= -1e-9 * energy(velocity, spins)


@given(contact=contacts(), size=decades(-1.5, 1.5), ratio=ratios, impact=impacts)
def test_an_impact_is_the_same_from_either_sphere(contact, size, ratio, impact):
    pair = as_pair(contact, size)
    swapped = pair.replace(
        particle=pair.surface,
        surface=pair.particle,
        diameter=pair.partner_diameter,
        partner_diameter=pair.diameter,
    )
    speed = speed_of(pair, ratio)
    limit = float(capture_velocity(pair))
    assume(abs(speed * np.sin(np.radians(impact["angle"])) - limit) > 1e-3 * limit)
    spins = impact["spin_ratio"] * speed / pair.radius, -0.3 * speed / swapped.radius
    basis = impact["friction_basis"]
    first = simulate(pair, speed, impact["angle"], spins[0], basis, partner_spin=spins[1])
    second = simulate(swapped, speed, impact["angle"], spins[1], basis, partner_spin=spins[0])
    for name in ("normal_velocity", "tangential_velocity", "energy_loss"):
        assert getattr(second, name) == pytest.approx(getattr(first, name), rel=1e-8, abs=1e-9)
    assert second.partner_spin == pytest.approx(
        first.spin, rel=1e-8, abs=1e-8 * speed / pair.radius
    )


@given(contact=contacts(), ratio=ratios, impact=impacts)
def test_a_large_second_sphere_is_a_plane(contact, ratio, impact):
    large = contact.replace(partner_diameter=1e12 * contact.diameter)
    speed, _, plane = outcome(contact, ratio, impact)
    limit = float(capture_velocity(contact))
    assume(abs(speed * np.sin(np.radians(impact["angle"])) - limit) > 1e-3 * limit)
    sphere = outcome(large, ratio, impact)[2]
    for name in ("coefficient_of_restitution", "impulse_ratio", "spin", "contact_time"):
        assert getattr(sphere, name) == pytest.approx(getattr(plane, name), rel=1e-8), name
    assert abs(sphere.partner_spin) * 1e12 * contact.radius < 1e-20 * speed * 1e12


def test_tables_and_planar_impacts_hold_for_two_spheres():
    steel = Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.28, density=8000.0)
    pair = Contact(
        particle=steel,
        surface=steel,
        diameter=[20e-6, 30e-6],
        partner_diameter=[60e-6, 30e-6],
        work_of_adhesion=0.5,
        hertz_damping=0.1,
        adhesion_damping=2.0,
    )
    speed, partner = 2.0, np.array([3e4, -2e4])
    table = tabulate(pair, 0.1, 5.0).simulate(speed, 40.0, 1e4, partner_spin=partner)
    impact = simulate(pair, speed, 40.0, 1e4, partner_spin=partner)
    for name in ("spin", "partner_spin", "tangential_velocity", "energy_loss"):
        np.testing.assert_allclose(getattr(table, name), getattr(impact, name), rtol=1e-8)
    angle = np.radians(40.0)
    v_n, v_t = -speed * np.sin(angle), speed * np.cos(angle)
    plane = planar(pair, v_n, v_t, 1e4, partner_spin=partner)
    np.testing.assert_allclose(plane.partner_spin, impact.partner_spin, rtol=1e-12)
    # Equal spheres share the change of spin.
    assert impact.spin[1] - 1e4 == pytest.approx(impact.partner_spin[1] + 2e4, rel=1e-12)


def test_a_spin_of_no_sphere_is_refused():
    glass = Material(name="glass", youngs_modulus=70e9, poissons_ratio=0.2, density=2500.0)
    wall = Contact(particle=glass, surface=glass, diameter=1e-5, work_of_adhesion=0.1)
    with pytest.raises(ValueError, match="partner_spin is of a second sphere"):
        simulate(wall, 1.0, partner_spin=1.0)
    pair = wall.replace(partner_diameter=1e-5)
    with pytest.raises(ValueError, match="got one with a partner_diameter"):
        trajectory(pair, 1.0)
    with pytest.raises(ValueError, match="give either surface_radius or partner_diameter"):
        pair.replace(surface_radius=1e-5)
