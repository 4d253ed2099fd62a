"""The dense trajectory against the impact it is of, and against its own forces."""

import math

import numpy as np
import pytest
from scipy.integrate import simpson

from microimpact.model.choices import FRICTION_BASES
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.trajectory import CAPTURED_PERIODS, trajectory

every_basis = pytest.mark.parametrize("basis", FRICTION_BASES)


@every_basis
@pytest.mark.parametrize("angle", [3.0, 12.0, 50.0, 90.0])
def test_it_begins_at_touch_and_ends_where_the_impact_ends(contact, basis, angle):
    impact = simulate(contact, 1.66, angle, -2e3, friction_basis=basis)
    path = trajectory(contact, 1.66, angle, -2e3, points=50, friction_basis=basis)
    assert not path.captured
    along, into = 1.66 * math.cos(math.radians(angle)), 1.66 * math.sin(math.radians(angle))
    ends = {
        "time": (0.0, impact.contact_time),
        "compression": (0.0, 0.0),
        "velocity": (-into, impact.normal_velocity),
        "tangential_velocity": (along, impact.tangential_velocity),
        "spin": (-2e3, impact.spin),
    }
    for name, (first, last) in ends.items():
        values = getattr(path, name)
        assert values.shape == (50,)
        error = 1e-13 * np.abs(values).max()
        assert [values[0], values[-1]] == pytest.approx([first, last], rel=1e-11, abs=error), name
    assert path.slip[0] == pytest.approx(along + contact.radius * 2e3)
    assert (path.slip[-1] == 0.0) == impact.rolling
    assert path.normal_force[0] == pytest.approx(0.0, abs=1e-9 * path.normal_force.max())
    assert np.diff(path.time) == pytest.approx(path.time[-1] / 49, rel=1e-12)


@every_basis
def test_slow_rebounds_end_there_too(scaled, basis):
    contact = scaled(0.0, 1e-8)
    for w in (1e-3, 0.03):
        impact = simulate(contact, w * contact.velocity_scale, 45.0, friction_basis=basis)
        path = trajectory(contact, w * contact.velocity_scale, 45.0, friction_basis=basis)
        assert path.velocity[-1] == pytest.approx(impact.normal_velocity, rel=1e-12)


def test_what_has_rolled_rolls_on_while_adhesion_pulls(scaled):
    """On the net force the impulse falls again: the first passage decides, along the path too."""
    contact = scaled(0.0, 0.3)
    v_n = 1.5 * contact.velocity_scale
    normal = normal_impact(contact, v_n)
    last = (1 + normal.coefficient_of_restitution) * v_n
    v_t = 3.5 * contact.friction * 0.5 * (normal.peak_net_impulse / contact.mass + last)
    where = math.hypot(v_n, v_t), math.degrees(math.atan2(v_n, v_t))
    path = trajectory(contact, *where, friction_basis="net")
    impact = simulate(contact, *where, friction_basis="net")
    assert impact.rolling
    assert path.slip[-1] == 0.0
    assert path.tangential_velocity[-1] == pytest.approx(impact.tangential_velocity, rel=1e-12)


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("speed", [0.004, 0.5])
def test_the_force_is_mass_times_acceleration(contact, damped, speed):
    one = contact.replace(damped_attachment=damped)
    path = trajectory(one, speed, 20.0, points=4001)
    step = path.time[1]
    assert np.array_equal(
        path.normal_force,
        path.hertz_force
        + path.hertz_damping_force
        + path.adhesion_force
        + path.adhesion_damping_force,
    )
    # away from the ends, where force begins as a root of time, and from kinks
    inside = slice(40, -40)
    rate = np.gradient(path.velocity, step)[inside] * one.mass
    scale = np.abs(path.normal_force).max()
    close = np.abs(rate - path.normal_force[inside]) <= 2e-4 * scale
    assert close.mean() > 0.99
    moved = -np.gradient(path.compression, step)[inside]
    assert moved == pytest.approx(path.velocity[inside], abs=2e-4 * np.abs(path.velocity).max())
    rate = np.gradient(path.tangential_velocity, step)[inside] * one.mass
    close = np.abs(rate - path.friction_force[inside]) <= 2e-4 * scale
    assert close.mean() > 0.99


def test_each_term_is_its_formula(contact):
    path = trajectory(contact, 1.0, points=101)
    radius = np.sqrt(contact.hertz_radius * path.compression)
    hertz = contact.stiffness * radius**3 / contact.hertz_radius
    ring = 2 * np.pi * radius * contact.ring_force
    scale = path.hertz_force.max()
    rate = -path.velocity
    assert path.hertz_force == pytest.approx(hertz, abs=1e-12 * scale)
    assert path.hertz_damping_force == pytest.approx(
        hertz * contact.hertz_damping * rate, abs=1e-12 * scale
    )
    assert path.adhesion_force == pytest.approx(-ring, abs=1e-12 * scale)
    leaving = ring * contact.adhesion_damping * np.minimum(rate, 0.0)
    assert path.adhesion_damping_force == pytest.approx(leaving, abs=1e-12 * scale)


@every_basis
def test_impulses_are_the_areas_under_the_forces(contact, basis):
    impact = normal_impact(contact, 0.5, ledger=True)
    path = trajectory(contact, 0.5, points=20001, friction_basis=basis)
    compressive = simpson(np.maximum(path.normal_force, 0.0), x=path.time)
    areas = compressive, simpson(path.hertz_force, x=path.time)
    assert areas == pytest.approx((impact.compressive_impulse, impact.hertz_impulse), 1e-6, 0.0)
    adhesion = simpson(path.adhesion_force, x=path.time)
    assert adhesion == pytest.approx(impact.ledger.adhesion_impulse, rel=1e-5, abs=0.0)


@every_basis
def test_slip_never_grows_and_stays_zero(contact, basis):
    """But on the net force friction drives the slip while adhesion pulls."""
    path = trajectory(contact, 1.66, 25.0, friction_basis=basis, points=300)
    assert path.slip == pytest.approx(
        path.tangential_velocity - contact.radius * path.spin, abs=1e-12
    )
    stopped = np.flatnonzero(path.slip == 0.0)
    assert (path.slip[stopped[0] :] == 0.0).all() if stopped.size else True
    if basis != "net":
        assert (np.diff(path.slip) <= 1e-15).all()
        assert (path.friction_force <= 0.0).all()


class TestCaptured:
    @pytest.mark.parametrize("w", [0.02, 0.5, 0.99])
    def test_the_sphere_settles_in_the_well(self, scaled, w):
        contact = scaled(0.1, 0.3)
        speed = w * capture_velocity(contact)
        path = trajectory(contact, speed, points=2001)
        impact = normal_impact(contact, speed)
        assert path.captured
        assert path.time[-1] == pytest.approx(CAPTURED_PERIODS * impact.compression_time)
        assert path.compression.max() == pytest.approx(impact.maximum_compression, rel=1e-4)
        assert (path.compression[1:] > 0).all()
        assert path.compression[-1] == pytest.approx(contact.equilibrium_compression, rel=0.3)
        x = path.compression / contact.equilibrium_compression
        u = path.velocity / contact.velocity_scale
        energy = u**2 / 2 + 0.4 * x**2.5 - 2 / 3 * x**1.5
        assert (np.diff(energy) <= 1e-13).all()

    @pytest.mark.parametrize(("c_h", "c_a"), [(1.0, 0.0), (2.5, 0.0), (0.0, 4.0), (0.0, 100.0)])
    def test_overdamped_it_creeps_back(self, scaled, c_h, c_a):
        contact = scaled(c_h, c_a)
        path = trajectory(contact, 2 * contact.velocity_scale, points=400)
        assert path.captured
        deepest = path.compression.argmax()
        assert (np.diff(path.compression[: deepest + 1]) > 0).all()
        assert (path.compression[deepest:] > 0.9 * contact.equilibrium_compression).all()

    @pytest.mark.parametrize(("w", "c_h", "c_a"), [(0.01, 0.0, 1.9), (0.01, 2.5, 0.0)])
    def test_a_sphere_that_comes_to_rest_stays_there(self, scaled, w, c_h, c_a):
        contact = scaled(c_h, c_a)
        path = trajectory(contact, w * contact.velocity_scale, points=100)
        assert path.captured
        assert path.compression[-1] == pytest.approx(contact.equilibrium_compression, rel=0.2)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"points": 1}, ValueError, "points must be at least 2, got 1"),
        ({"points": 10.0}, TypeError, "points must be a whole number, got 10.0"),
        ({"points": True}, TypeError, "points must be a whole number, got True"),
        ({"points": None}, TypeError, "points must be a whole number, got None"),
        *(
            ({name: [1.0, 2.0]}, ValueError, rf"{name} must be a single number.*\(2,\)")
            for name in ("speed", "angle", "spin")
        ),
        ({"friction": [0.1, 0.2]}, ValueError, r"contact must be a single one.*\(2,\)"),
        ({"speed": 0.0}, ValueError, "^speed must be"),
        ({"speed": 3e8}, ValueError, "^speed must be"),
        ({"speed": "1"}, TypeError, "^speed must be"),
        ({"angle": 91.0}, ValueError, "^angle must be"),
        ({"spin": math.inf}, ValueError, "^spin must be"),
        ({"friction_basis": "none"}, ValueError, "^friction_basis must be"),
    ],
)
def test_bad_input_is_named(contact, arguments, error, message):
    motion = {"speed": 1.0} | arguments
    friction = motion.pop("friction", 0.15)
    with pytest.raises(error, match=message):
        trajectory(contact.replace(friction=friction), **motion)
    assert trajectory(contact, 1.0, points=np.int64(2)).time.size == 2
