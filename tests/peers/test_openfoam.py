"""The exported patch interaction in OpenFOAM: compiled by wmake, with parcels thrown at a wall."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from tests.shared import execute

from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.dynamics.capture import capture_velocity
from microimpact.model.dynamics.impact import planar
from microimpact.model.law.export import export

SOLVER = "icoUncoupledKinematicParcelFoam"
for program in ("wmake", "blockMesh", SOLVER):
    if shutil.which(program) is None:
        pytest.skip(f"no {program}: OpenFOAM's sources and etc/bashrc", allow_module_level=True)

GLASS = Material(name="glass", youngs_modulus=70e9, poissons_ratio=0.22, density=2500.0)
HEAD = "FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n"
FILES = {
    "system/controlDict": """application none; startFrom startTime; startTime 0; stopAt endTime;
        endTime 1e-3; deltaT 1e-5; writeControl timeStep; writeInterval 100; writePrecision 14;
        libs ("libmicroimpact.so");""",
    "system/fvSchemes": """ddtSchemes { default Euler; } gradSchemes { default Gauss linear; }
        divSchemes { default none; } laplacianSchemes { default none; }
        interpolationSchemes { default linear; } snGradSchemes { default none; }""",
    "system/fvSolution": "solvers {}",
    "system/blockMeshDict": """scale 0.01;
        vertices ((0 0 0) (2 0 0) (2 2 0) (0 2 0) (0 0 2) (2 0 2) (2 2 2) (0 2 2));
        blocks (hex (0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1)); edges ();
        boundary (floor { type wall; faces ((0 3 2 1)); } open { type patch;
        faces ((4 5 6 7) (0 1 5 4) (2 3 7 6) (1 2 6 5) (0 4 7 3)); });""",
    "constant/g": "dimensions [0 1 -2 0 0 0 0]; value (0 0 0);",
    "constant/transportProperties": "rhoInf 1.2; transportModel Newtonian; nu 1.5e-5;",
    "constant/turbulenceProperties": "simulationType laminar;",
    "0/U": """dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0);
        boundaryField { ".*" { type zeroGradient; } }""",
}
CLOUD = """solution { active true; coupled false; transient yes; cellValueSourceCorrection off;
    maxCo 1; sourceTerms { schemes {} } interpolationSchemes { rho cell; U cell; mu cell; }
    integrationSchemes { U Euler; } }
constantProperties { rho0 DENSITY; youngsModulus 1e9; poissonsRatio 0.3; }
subModels { particleForces {} injectionModels { INJECTED } dispersionModel none;
    patchInteractionModel MicroimpactRebound; MicroimpactReboundCoeffs {}
    surfaceFilmModel none; stochasticCollisionModel none; collisionModel none; }
cloudFunctions {}"""
INJECTED = """NAME { type manualInjection; massTotal 0; parcelBasisType fixed; nParticle 1; SOI 0;
    positionsFile "start"; U0 (ALONG 0 -SPEED); sizeDistribution { type fixedValue;
    fixedValueDistribution { value SIZE; } } }"""
# Normal speeds over the capture velocity, tangential speeds over the normal, diameters, um.
IMPACTS = [
    (ratio, tangential, size)
    for ratio in (0.9, 1.1, 2.0, 6.0)
    for tangential in (0.0, 0.1, 2.0)
    for size in (5.0, 13.0, 20.0)
]


def test_parcels_leave_as_the_model_says(tmp_path: Path) -> None:
    contact = Contact(
        particle=GLASS,
        surface=GLASS,
        diameter=np.array([5e-6, 20e-6]),
        work_of_adhesion=0.1,
        hertz_damping=0.05,
        adhesion_damping=0.5,
        friction=0.2,
    )
    ratio, tangential, size = np.array(IMPACTS).T
    each = contact.replace(diameter=1e-6 * size)
    speed = ratio * capture_velocity(each)
    along = tangential * speed
    export(contact, tmp_path / "library", "openfoam", 20.0)
    environment = os.environ | {"FOAM_USER_LIBBIN": str(tmp_path)}
    environment["LD_LIBRARY_PATH"] = f"{tmp_path}:{os.environ.get('LD_LIBRARY_PATH', '')}"

    execute("wmake", "libso", cwd=tmp_path / "library", env=environment)
    injected = "".join(
        INJECTED.replace("NAME", f"parcel{i}")
        .replace("ALONG", repr(float(u)))
        .replace("SPEED", repr(float(v)))
        .replace("SIZE", repr(1e-6 * float(d)))
        for i, (u, v, d) in enumerate(zip(along, speed, size, strict=True))
    )
    cloud = CLOUD.replace("DENSITY", repr(GLASS.density)).replace("INJECTED", injected)
    files = FILES | {
        "constant/kinematicCloudProperties": cloud,
        "constant/start": "((0.01 0.01 1e-5))",
    }
    for name, text in files.items():
        path = tmp_path / "case" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        kind = {"U": "volVectorField", "start": "vectorField", "g": "uniformDimensionedVectorField"}
        path.write_text(HEAD.format(kind.get(path.name, "dictionary"), path.name) + text)
    execute("blockMesh", cwd=tmp_path / "case", env=environment)
    log = execute(SOLVER, cwd=tmp_path / "case", env=environment).stdout
    result = tmp_path / "case/0.001/lagrangian/kinematicCloud"
    order = np.argsort(_numbers(result / "origId"))
    after = _numbers(result / "U").reshape(-1, 3)[order]
    expected = planar(each, -speed, along)
    moving = ~expected.captured
    assert np.count_nonzero(moving) == 27
    components = expected.tangential_velocity * moving, expected.normal_velocity * moving
    assert after[:, 0] == pytest.approx(components[0], rel=1e-6, abs=1e-9)
    assert after[:, 2] == pytest.approx(components[1], rel=1e-6, abs=1e-9)
    caught = re.findall(r"Captured in this run by patch floor: (\S+) particles, (\S+) kg", log)[-1]
    number, mass = np.count_nonzero(~moving), float(np.sum(each.mass[~moving]))
    assert [float(word) for word in caught] == pytest.approx([number, mass], rel=1e-5)


def _numbers(path: Path) -> np.ndarray:
    """Numbers of a field between the parentheses of its list."""
    body = path.read_text().partition("\n(\n")[2].rpartition(")")[0]
    return np.array(re.sub(r"[()]", " ", body).split(), dtype=float)
