"""The law for other programs: C against the package, tables against integration."""

import ctypes
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.shared import execute, require

from microimpact.model.choices import FORMATS, FRICTION_BASES, WALL_FORMATS
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.export import export

STRICT = ("gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2")
FASTEST, COUNT = 20.0, 4000


@pytest.fixture
def compiler():
    require("gcc", "g++", package="g++")


compiled_here = pytest.mark.usefixtures("compiler")

# So that many impacts are one call: what a host program's loop would do.
LOOP = """
#include "microimpact_rebound.h"
void all(int n, const double *d, const double *v_n, const double *v_t, const double *omega,
         double *V_n, double *V_t, double *Omega, int *outcome)
{
    int i;
    for (i = 0; i < n; i++)
        outcome[i] = microimpact_rebound(d[i], v_n[i], v_t[i], omega[i],
                                         V_n + i, V_t + i, Omega + i);
}
"""

# What the worked boundary condition uses of Fluent's own header.
FLUENT = """
#include <math.h>
#include <stdio.h>
typedef double real;
typedef int face_t;
typedef struct { int moves; } Thread;
enum { SV_WALL_GRID_V, SV_WALL_V };
#define SV_ALLOCATED_P(t, v) ((t)->moves)
int rp_axi_swirl = 0;
typedef struct { real velocity[3], before[3], diameter; } Tracked_Particle;
static real memory[1];
static const struct { int unsteady_tracking; } dpm_par = {1};
enum { PATH_ACTIVE, PATH_END, PATH_ABORT };
#define TP_VEL(p) ((p)->velocity)
#define TP_VEL0(p) ((p)->before)
#define TP_DIAM(p) ((p)->diameter)
#define TP_CELL(p) 0
#define TP_CELL_THREAD(p) 0
#define TP_N(p) 10.0
#define TP_MASS(p) 0.5
#define TP_FLOW_RATE(p) 0.0
#define N_UDM 1
#define C_UDMI(c, t, i) memory[i]
#define Message printf
real captured_mass(void) { return memory[0]; }
#define DEFINE_DPM_BC(name, p, t, f, n, d) \\
    int name(Tracked_Particle *p, Thread *t, face_t f, real n[], int d)
"""

# And of OpenFOAM's.
FOAM = """
#include <iostream>
#include <memory>
#include <string>
#include <vector>
#define forAll(list, i) for (int i = 0; i < int((list).size()); i++)
#define TypeName(name) static constexpr const char* typeName = name
#define FatalErrorInFunction FatalError
namespace Foam {
using scalar = double;
struct Exit {};
struct Failure {
    template<class T> Failure& operator<<(const T&) { return *this; }
    void operator<<(Exit) { throw 1; }
};
static Failure FatalError;
inline Exit exit(const Failure&) { return {}; }
struct vector { double x, y, z; };
inline vector operator-(vector a, vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline double operator&(vector a, vector b) { return a.x*b.x + a.y*b.y + a.z*b.z; }
inline vector operator*(double s, vector a) { return {s*a.x, s*a.y, s*a.z}; }
inline vector& operator+=(vector& a, vector b) { a = {a.x + b.x, a.y + b.y, a.z + b.z}; return a; }
inline double mag(vector a) { return __builtin_sqrt(a & a); }
inline double mag(double a) { return __builtin_fabs(a); }
using Ostream = std::ostream;
using scalarList = std::vector<scalar>;
static std::ostream& Info = std::cout;
static const char nl = '\\n';
template<class T> struct sumOp {};
template<class T, class Op> T returnReduce(T value, Op) { return value; }
struct dictionary {};
struct polyPatch {
    virtual ~polyPatch() = default;
    int index() const { return 0; }
    std::string name() const { return "floor"; }
};
struct wallPolyPatch : polyPatch {};
template<class T> bool isA(const polyPatch& p) { return dynamic_cast<const T*>(&p); }
using polyBoundaryMesh = std::vector<wallPolyPatch>;
struct Mesh {
    polyBoundaryMesh patches = polyBoundaryMesh(1);
    const polyBoundaryMesh& boundaryMesh() const { return patches; }
};
template<class T> struct autoPtr : std::unique_ptr<T> { using std::unique_ptr<T>::unique_ptr; };
template<class C> struct PatchInteractionModel {
    C& cloud;
    PatchInteractionModel(const dictionary&, C& c, const char*) : cloud(c) {}
    PatchInteractionModel(const PatchInteractionModel& o) : cloud(o.cloud) {}
    virtual ~PatchInteractionModel() = default;
    C& owner() { return cloud; }
    virtual bool correct(typename C::parcelType&, const polyPatch&, bool&) = 0;
};
}
"""


@pytest.fixture(scope="module")
def pair(scaled):
    """Damping of both kinds that depends on the rate, friction so that some slide and some roll."""
    made = scaled(0.05, 0.4, adhesion_rate_exponent=1.0, reference_velocity=1.0)
    return made.replace(friction=0.15)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Return the compiled loop over impacts of a pair, by basis."""

    def make(pair, basis="compressive"):
        folder = tmp_path_factory.mktemp("header")
        export(pair, folder, "c", FASTEST, basis)
        (folder / "loop.c").write_text(LOOP, encoding="utf-8")
        execute(*STRICT, "-shared", "-fPIC", "loop.c", "-o", "loop.so", "-lm", cwd=folder)
        loop = ctypes.CDLL(str(folder / "loop.so")).all
        diameter = float(np.ravel(pair.diameter)[0])

        def run(v_n, v_t, omega, size=diameter):
            found = [np.full(v_n.size, np.nan) for _ in range(3)]
            outcome = np.zeros(v_n.size, np.int32)
            arrays = np.full(v_n.size, size), v_n, v_t, omega, *found, outcome
            loop(v_n.size, *(a.ctypes.data_as(ctypes.c_void_p) for a in arrays))
            return *found, outcome

        return run

    return make


BY_LAW = dict.fromkeys(("hertz_damping", "adhesion_damping", "adhesion_rate_exponent"), 0.0)
# Changes of the contact, the range of sizes over the least one, and the basis of friction.
KINDS = {
    **{basis: ({}, 1.0, basis) for basis in FRICTION_BASES},
    "sizes": ({}, 4.0, "compressive"),
    "sizes by JKR": (BY_LAW | {"law": JKR(viscous_time=1e-10)}, 4.0, "compressive"),
    "no adhesion": ({"work_of_adhesion": 0.0}, 1.0, "compressive"),
    "elastic": ({"work_of_adhesion": 0.0, "hertz_damping": 0.0}, 1.0, "compressive"),
}


@compiled_here
@pytest.mark.parametrize("kind", KINDS)
def test_the_header_is_the_package(pair, compiled, kind):
    changes, ratio, basis = KINDS[kind]
    random, contact = np.random.default_rng(3), pair.replace(**changes)
    ends = contact.diameter * np.array([1.0, ratio])
    each = contact
    if ratio > 1.0:
        each = contact.replace(diameter=np.exp(random.uniform(*np.log(ends), COUNT)))
    limit = np.asarray(capture_velocity(each))
    unit = np.where(limit > 0.0, limit, 2.0)
    v_n = -np.minimum(unit * np.exp(random.normal(0.5, 1.5, COUNT)), 0.99 * FASTEST)
    near = 10.0 ** -np.arange(3.0, 13.0)
    v_n[:20] = -(unit * np.ones(COUNT))[:20] * np.concatenate([1.0 + near, 1.0 - near])
    v_t, spin = random.normal(0.0, 5.0, (2, COUNT))
    omega = spin / each.radius
    loop = compiled(contact.replace(diameter=ends) if ratio > 1.0 else contact, basis)
    *found, outcome = loop(v_n, v_t, omega, size=each.diameter)
    expected = planar(each, v_n, v_t, omega, basis)
    assert np.array_equal(outcome == 1, expected.captured)
    assert 0.1 < np.mean(expected.captured) < 0.9 or not np.any(limit)
    assert 0.1 < np.mean(expected.rolling) < 0.9
    scale = np.abs(v_n) + np.abs(v_t) + np.abs(spin)
    for name, value in zip(("normal_velocity", "tangential_velocity"), found, strict=False):
        assert np.max(np.abs(value - getattr(expected, name)) / scale) < 2e-6, name
    assert np.max(np.abs(found[2] - expected.spin) * each.radius / scale) < 2e-6
    slow = np.abs(found[0] - expected.normal_velocity)[:20] / unit.max()
    assert np.max(slow) < 2e-6
    one = np.ones(1)
    for wrong in (0.9 * ends.min(), 1.1 * ends.max(), np.nan):
        assert loop(-one, one, one, size=wrong)[-1].tolist() == [-2]


@compiled_here
def test_the_header_holds_for_two_spheres_by_the_shares_that_it_states(pair, compiled, tmp_path):
    spheres = pair.replace(partner_diameter=2.0 * pair.diameter)
    spins = np.array([2e4, -3e4])
    joint = spins[:1] + 2.0 * spins[1]
    v_n, v_t = np.array([-5.0]), np.array([1.0])
    _, along, spin, _ = compiled(spheres)(v_n, v_t, joint)
    (path,) = export(spheres, tmp_path, "csv", FASTEST)
    text = path.read_text(encoding="utf-8")
    share, other = map(
        float, re.findall(r"the first sphere takes the share (\S+), the second (\S+);", text)[0]
    )
    expected = planar(spheres, v_n, v_t, spins[0], partner_spin=spins[1])
    assert along == pytest.approx(expected.tangential_velocity, rel=1e-6)
    assert spins[0] + share * (spin - joint) == pytest.approx(expected.spin, rel=1e-6)
    assert spins[1] + other * (spin - joint) == pytest.approx(expected.partner_spin, rel=1e-6)
    for form in WALL_FORMATS:
        with pytest.raises(ValueError, match="two spheres have c, csv"):
            export(spheres, tmp_path, form, FASTEST)


@compiled_here
def test_what_the_table_does_not_hold_is_refused_whatever_the_name(pair, compiled):
    named = pair.replace(particle=replace(pair.particle, name="α/β * (50 %), no. 7/"))
    v_n = np.array([1.0, 0.0, np.nan, -1e6, -np.inf])
    *found, outcome = compiled(named)(v_n, np.ones(5), np.zeros(5))
    assert outcome.tolist() == [-1] * 5
    assert np.all(np.isnan(found))


@pytest.mark.parametrize("form", FORMATS)
def test_files(pair, tmp_path, form):
    written = export(pair, tmp_path / "new", form, FASTEST)
    assert written
    assert sorted(path for path in (tmp_path / "new").rglob("*") if path.is_file()) == sorted(
        written
    )
    texts = [path.read_text(encoding="utf-8") for path in written]
    assert not [text for text in texts if re.search(r"\$[a-z]", text)]


SUPPORTING = {
    "compressive": "compressive_impulse",
    "hertz": "hertz_impulse",
    "net": "peak_net_impulse",
}


@pytest.mark.parametrize("basis", FRICTION_BASES)
@pytest.mark.parametrize("ratio", [1.0, 5.0])
def test_tables_are_integration(pair, tmp_path, basis, ratio):
    contact = pair.replace(diameter=pair.diameter * np.array([1.0, ratio])) if ratio > 1 else pair
    table = pd.read_csv(export(contact, tmp_path, "csv", FASTEST, basis)[0], comment="#")
    speed, each = table["normal_speed_m_per_s"].to_numpy(), pair
    if ratio > 1:
        each = pair.replace(diameter=table["diameter_m"].to_numpy())
        assert table["diameter_m"].nunique() > 10
    # So fast along the surface that the sphere slides throughout.
    slides = planar(each, -speed, np.full_like(speed, 1e3), friction_basis=basis)
    error = table["error"][0]
    assert np.allclose(table["restitution"], slides.coefficient_of_restitution, rtol=0, atol=error)
    assert np.allclose(
        table["impulse_ratio_of_sliding"], slides.impulse_ratio, rtol=0, atol=pair.friction * error
    )
    assert np.allclose(table["v_n_over_v_c"], speed / capture_velocity(each), rtol=1e-9)


@compiled_here
def test_the_law_is_right_to_the_error_that_it_states(pair, compiled, tmp_path):
    """Of e and, by spheres that slide throughout, of the impulse: between octaves too."""
    octaves = -25.0, np.log2(FASTEST / float(capture_velocity(pair)) - 1.0)
    excess = np.exp2(np.linspace(*octaves, 4 * COUNT))[1:-1]
    speed = float(capture_velocity(pair)) * (1.0 + excess)
    e, along, *_ = compiled(pair)(-speed, 100.0 * speed, np.zeros_like(speed)) / speed
    values = np.stack([e, (100.0 - along) / pair.friction])
    exact = normal_impact(pair, speed)
    impulse = exact.compressive_impulse / (pair.mass * speed)
    expected = np.stack([exact.coefficient_of_restitution, impulse])
    error = np.max(np.abs(values - expected) / np.maximum(expected, 1.0))
    for form in ("c", "csv"):
        text = export(pair, tmp_path, form, FASTEST)[0].read_text("utf-8")
        stated = float(re.search(r"Error of e and of the impulse ratio: (\S+)\.\n", text)[1])
        assert 0.25 * stated < error <= stated <= 1e-6


def test_the_comment_describes_the_contact(pair, tmp_path):
    pair = pair.replace(reference_velocity=2.5)
    text = export(pair, tmp_path, "c", FASTEST, "hertz")[0].read_text("utf-8")
    comment = text.partition("*/")[0]
    symbols = {
        "w_A": pair.work_of_adhesion,
        "c_H": pair.hertz_damping,
        "c_A": pair.adhesion_damping,
        "n": pair.adhesion_rate_exponent,
        "v_N": pair.reference_velocity,
        "f": pair.friction,
    }
    assert len({f"{value:.6g}" for value in symbols.values()}) == len(symbols)
    for symbol, value in symbols.items():
        (number,) = re.findall(rf"\b{symbol} = ([\d.e-]+)", comment)
        assert float(number) == pytest.approx(value, rel=1e-5), symbol
    assert f"{pair.particle.name} on {pair.surface.name}, {1e6 * pair.diameter:g} um" in comment
    assert "on the hertz force" in comment
    assert f"Capture velocity {capture_velocity(pair):.6g} m/s" in comment
    defined = dict(re.findall(r"#define MICROIMPACT_([A-Z]+) \(?([\d.e-]+)", text))
    expected = {"DENSITY": pair.particle.density, "FRICTION": pair.friction}
    expected |= {"SMALLEST": 0.99 * pair.diameter, "LARGEST": 1.01 * pair.diameter}
    assert {name: float(defined[name]) for name in expected} == pytest.approx(expected, rel=1e-9)


@compiled_here
def test_the_example_runs(pair, tmp_path):
    export(pair, tmp_path, "c", FASTEST)
    execute(*STRICT, "example.c", "-lm", cwd=tmp_path)

    command = tmp_path / "a.out"

    def example(*words):
        return execute(command, str(pair.diameter), *words, check=False)

    after = planar(pair, -8.0, 1.0)
    first = float(example("8", "1", "0").stdout.split()[1])
    assert first == pytest.approx(float(after.normal_velocity), rel=1e-6)
    assert example("1e-3", "1", "0").stdout.startswith("captured")
    assert example("1e9", "0", "0").returncode == execute(command, check=False).returncode == 2
    wrong = execute(command, str(2.0 * pair.diameter), "8", "1", "0", check=False)
    assert wrong.returncode == 2
    assert "the diameter must be from" in wrong.stderr


@compiled_here
def test_fluents_boundary_condition_against_a_stub(pair, tmp_path):
    export(pair, tmp_path, "fluent", FASTEST)
    (tmp_path / "udf.h").write_text(FLUENT, encoding="utf-8")
    library = ("-I.", "-shared", "-fPIC", "microimpact_fluent.c", "-o", "bc.so", "-lm")
    execute(*STRICT, *library, cwd=tmp_path)
    loaded = ctypes.CDLL(str(tmp_path / "bc.so"))
    wall, deposit = loaded.microimpact_wall, loaded.captured_mass
    deposit.restype = ctypes.c_double
    vector = ctypes.c_double * 3

    def impact(*velocity, size=1.0, moves=0):
        particle = (ctypes.c_double * 7)(*velocity, 0.0, 0.0, 0.0, size * pair.diameter)
        thread = ctypes.byref(ctypes.c_int(moves))
        return wall(particle, thread, 0, vector(0.0, 0.0, -1.0), 3), list(particle)[:6]

    outcome, particle = impact(3.0, 4.0, -8.0)
    after = planar(pair, -8.0, 5.0)
    along = float(after.tangential_velocity) / 5.0
    expected = [3.0 * along, 4.0 * along, float(after.normal_velocity)]
    assert outcome == 0
    assert particle == pytest.approx(2 * expected, rel=1e-6)
    assert deposit() == 0.0
    assert impact(0.0, 1.0, -1e-3)[0] == 1
    assert deposit() == 5.0  # ten spheres of half a kilogram
    assert impact(0.0, 1.0, -1e6)[0] == 2
    assert [impact(3.0, 4.0, -8.0, size=size)[0] for size in SIZES] == [2, 0, 0, 2]
    assert impact(3.0, 4.0, -8.0, moves=1)[0] == 2
    ctypes.c_int.in_dll(loaded, "rp_axi_swirl").value = 1
    assert impact(3.0, 4.0, -8.0)[0] == 2


# Diameters over the law's: 1 % is let pass.
SIZES = (0.98, 0.995, 1.005, 8.0)

OF_FOAM = """
#include <cstdio>
#include "MicroimpactRebound.H"
#include "MicroimpactRebound.C"
using namespace Foam;
struct Parcel {
    vector velocity;
    double diameter = DIAMETER;
    bool moving = true;
    double d() const { return diameter; }
    vector& U() { return velocity; }
    void active(bool still) { moving = still; }
    double nParticle() const { return 10.0; }
    double mass() const { return 0.5; }
};
struct Cloud {
    using parcelType = Parcel;
    Mesh space;
    const Mesh& mesh() const { return space; }
    void patchData(Parcel&, const polyPatch&, vector& normal, vector& velocity)
    {
        normal = {0, 0, -1};
        velocity = {1, 0, 0};
    }
};
int main()
{
    Cloud cloud;
    MicroimpactRebound<Cloud> model(dictionary{}, cloud);
    for (double speed : {8.0, 1e-3}) {
        Parcel parcel{{4.0, 4.0, -speed}};
        bool kept = false;
        std::printf("%d ", model.correct(parcel, wallPolyPatch{}, kept));
        std::printf("%d %.9g %.9g %.9g\\n", parcel.moving, parcel.velocity.x, parcel.velocity.y,
                    parcel.velocity.z);
    }
    Parcel parcel{{0, 0, -1e6}};
    bool kept = false;
    try { model.correct(parcel, wallPolyPatch{}, kept); } catch (int) { std::printf("2 "); }
    std::printf("%d\\n", model.correct(parcel, polyPatch{}, kept));
    for (double size : {SIZES}) {
        Parcel parcel{{4.0, 4.0, -8.0}, size*DIAMETER};
        try { std::printf("%d ", model.correct(parcel, wallPolyPatch{}, kept)); }
        catch (int) { std::printf("2 "); }
    }
    std::printf("\\n");
    std::fflush(stdout);
    model.info();
}
"""


@compiled_here
def test_openfoams_patch_interaction_against_a_stub(pair, tmp_path):
    export(pair, tmp_path, "openfoam", FASTEST)
    for name in ("PatchInteractionModel.H", "wallPolyPatch.H", "scalarList.H"):
        (tmp_path / name).write_text(f"#pragma once\n{FOAM if name[0] == 'P' else ''}")
    program = OF_FOAM.replace("SIZES", ", ".join(map(str, SIZES)))
    program = program.replace("DIAMETER", repr(float(pair.diameter)))
    (tmp_path / "main.cpp").write_text(program, encoding="utf-8")
    command = ("g++", "-std=c++14", "-Wall", "-Werror", "-I.", "main.cpp", "-o", "foam")
    execute(*command, cwd=tmp_path)
    text = execute(tmp_path / "foam").stdout
    *lines, captured = text.splitlines()
    fast, slow, other, sizes = ([float(word) for word in line.split()] for line in lines)
    after = planar(pair, -8.0, 5.0)  # relative to a patch that moves with 1 m/s along x
    along = float(after.tangential_velocity) / 5.0
    velocity = [1.0 + 3.0 * along, 4.0 * along, float(after.normal_velocity)]
    assert fast == pytest.approx([1.0, 1.0, *velocity], rel=1e-6)
    assert slow == [1.0, 0.0, 1.0, 0.0, 0.0]
    assert other == [2.0, 0.0]
    assert sizes == [2.0, 1.0, 1.0, 2.0]
    assert captured.strip() == "Captured in this run by patch floor: 10 particles, 5 kg"


@pytest.mark.parametrize(
    ("fields", "changes", "message"),
    [
        ({}, {"format": "fortran"}, "format"),
        ({}, {"friction_basis": "all"}, "friction_basis"),
        ({}, {"tolerance": 0.0}, "tolerance"),
        ({}, {"tolerance": 10.0}, r"tolerance must be finite and in \(0, 1\), got 10"),
        ({}, {"tolerance": 1e-15}, "no table reaches the tolerance 1e-15"),
        ({}, {"fastest": 0.1}, "fastest must be above the capture velocity"),
        ({"friction": [0.1, 0.2]}, {}, "must differ in diameter alone"),
    ],
)
def test_bad_input_is_refused(pair, tmp_path, fields, changes, message):
    with pytest.raises(ValueError, match=message):
        export(pair.replace(**fields), tmp_path / "none", **{"fastest": FASTEST} | changes)
    assert not (tmp_path / "none").exists()
