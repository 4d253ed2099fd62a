"""The rebound law of a contact, over speed and size, for other programs: tables, C, walls.

What a program of flow or of particles needs of a normal impact are two numbers: e, and the impulse
of the normal force in Coulomb's law. For spheres of one pair of materials they depend on the normal
speed and on the diameter. From them the rule of `model.dynamics.impact` (slip, rolling, capture) is
algebra.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev

from microimpact.core.arrays import FloatArray, Numbers, checked, choice
from microimpact.core.files import write_file
from microimpact.model.choices import FORMATS, WALL_FORMATS
from microimpact.model.contact import Contact, require_contact
from microimpact.model.dynamics.impact import SPEED, chosen_basis, supporting_impulses
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.law.codes import LAMMPS, lammps_files, speeds_of_fit, template
from microimpact.model.law.families import Sizes
from microimpact.model.law.pieces import (
    SPLITS,
    TOLERANCES,
    WIDTHS,
    Table,
    between,
    slowness,
    smallest,
)
from microimpact.model.passes import RESTITUTION, WIDTH
from microimpact.model.rigid_body.algebra import INERTIA, SLIP_PER_IMPULSE

# Binary exponent of the lowest octave of v/v_c - 1: there e ~ sqrt(v/v_c - 1) to some parts in a
# million of itself, and e is 1e-4. Without adhesion, of c_H v: there e is 1 to double precision.
LOWEST, LOWEST_BARE = -24, -52
# Points an octave, and sizes, off the nodes, at which the error is measured.
HELD_OUT, HELD_OUT_SIZES = 37, 61
UNIT_TOLERANCE = 1e-12  # of the capture velocity; its error over 2^LOWEST enters e = 1e-4
BANDS = (1, 2, 4, 8)  # of sizes, tried in turn
ROWS, SIZES = 200, 25  # of the tables for people: speeds, and diameters
# Spheres of other sizes than the law's, by this share, take the law of the nearest.
NEARLY = 0.01
IMPULSE = 1  # row of the impulse in the table, beside RESTITUTION


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rebounds:
    """e and the supporting impulse over normal speed and diameter, to a stated error."""

    sizes: Sizes
    basis: str  # Normal force in Coulomb's law
    # Chebyshev coefficients, over the position of the size, of 1/unit: the table's variable is
    # v/unit, less 1 where the unit is the capture velocity; s/m
    slowness: FloatArray
    captures: bool  # Whether slow spheres are captured
    # Polynomials of `RESTITUTION` and `IMPULSE`, the impulse per mass and normal speed. The error
    # that it states is a share of 1, or of the number if this is larger.
    table: Table
    fastest: float  # Normal speed up to which it holds, m/s

    @property
    def offset(self) -> float:
        """Offset of the table's variable, v/unit less this."""
        return 1.0 if self.captures else 0.0

    @property
    def coefficients(self) -> FloatArray:
        """Powers' coefficients of `RESTITUTION` and `IMPULSE`: (pieces, widths, powers, 2).

        Pieces are those of the first band of sizes, then of the next; widths are powers of the
        position in a band.
        """
        rows = self.table.coefficients[..., [RESTITUTION, IMPULSE], :]
        return np.moveaxis(rows, 3, 4).reshape(-1, rows.shape[2], rows.shape[4], 2)

    def unit(self, diameter: FloatArray | float) -> FloatArray:
        """Unit of speed, m/s: the capture velocity where there is one."""
        position = self.sizes.position(diameter)
        return np.asarray(1.0 / chebyshev.chebval(position, self.slowness))

    def __call__(
        self, speed: FloatArray, diameter: FloatArray | float
    ) -> tuple[FloatArray, FloatArray]:
        """Return e and the impulse per mass and normal speed at speeds in m/s, diameters in m."""
        x = speed / self.unit(diameter) - self.offset
        lowest = math.ldexp(0.5, self.table.lowest)
        position = np.broadcast_to(self.sizes.position(diameter), x.shape)
        values = self.table(np.maximum(x, lowest), position)
        e = values[RESTITUTION]
        if self.captures:
            e = e * np.sqrt(np.clip(x / lowest, 0.0, 1.0))
        return e, np.where((x > 0.0) | (not self.captures), values[IMPULSE], 0.0)


def rebounds(contact: Contact, fastest: float, basis: str, tolerance: float) -> Rebounds:
    """Return the rebound law of contacts that differ in their diameters alone.

    Parameters
    ----------
    contact
        The contact, or an array of two or more diameters, between the ends of which it holds.
    fastest
        Normal speed, m/s.
    basis
        Normal force in Coulomb's law.
    tolerance
        Largest error of e and of the impulse, see `Rebounds`.

    Raises
    ------
    ValueError
        If the contacts differ otherwise, none rebounds up to ``fastest``, or no table is so close.
    """
    sizes = Sizes.of(contact)
    captures = sizes.captures
    slow = slowness(sizes.units, UNIT_TOLERANCE, alike=not sizes.half_width)
    # Of all sizes: the largest spheres are captured last.
    steepest = float(np.max(chebyshev.chebval(between(60), slow)))
    offset = 1.0 if captures else 0.0
    top = fastest * steepest - offset
    lowest = LOWEST if sizes.middle.velocity_scale else LOWEST_BARE
    if top <= math.ldexp(1.0, lowest):
        raise ValueError(
            f"fastest must be above the capture velocity {1.0 / steepest:.6g} m/s, got {fastest:g}"
        )

    def sampled(x: FloatArray, position: FloatArray) -> FloatArray:
        speed = (x + offset) / chebyshev.chebval(position, slow)
        bodies = sizes.contact(position)
        impact = normal_impact(bodies, speed, ledger=basis == "hertz")
        out = np.zeros((WIDTH, x.size))
        out[RESTITUTION] = impact.coefficient_of_restitution
        out[IMPULSE] = supporting_impulses(bodies, impact, basis, speed)[1] / speed
        return out

    octaves = lowest, math.frexp(top)[1] - lowest + 1
    held = (math.ldexp(1.0, sum(octaves) - 1) + offset) / steepest

    def misfit(positions: FloatArray) -> Callable[[Table], float]:
        """Measure of a table's error between the nodes, up to the fastest speed."""
        x = np.exp2(lowest - 1 + np.arange(HELD_OUT * octaves[1]) / HELD_OUT)
        x, position = (a.ravel() for a in np.meshgrid(x, positions))
        within = x + offset <= held * chebyshev.chebval(position, slow)
        x, position = x[within], position[within]
        expected = sampled(x, position)
        return lambda table: float(
            np.max(np.abs(table(x, position) - expected) / np.maximum(expected, 1.0))
        )

    table = smallest(sampled, octaves, tolerance, error=misfit(np.zeros(1)))
    if sizes.half_width:
        finer = SPLITS[SPLITS.index(table.split) :][:2]
        between_ends = misfit(np.linspace(-1.0, 1.0, HELD_OUT_SIZES))
        table = smallest(sampled, octaves, tolerance, finer, BANDS, WIDTHS, between_ends)
    return Rebounds(
        sizes=sizes,
        basis=basis,
        slowness=slow,
        captures=captures,
        table=table,
        fastest=held,
    )


def export(
    contact: Contact,
    path: Path | str,
    format: str = "c",  # noqa: A002
    fastest: float = 100.0,
    friction_basis: str = "compressive",
    tolerance: float = 1e-6,
    speeds: Numbers | None = None,
) -> list[Path]:
    """Write the rebound law of a contact for another program, from rest up to a normal speed.

    Parameters
    ----------
    contact
        The contact, by any law of the normal force; or one with an array of diameters: the law then
        holds for all sizes between the smallest and the largest.
    path
        Folder of the files; it is made.
    format
        ``"c"``: a header in C99 without dependencies, and an example; ``"fluent"``, ``"openfoam"``:
        the same with a boundary condition; ``"csv"``: e and the impulses over diameter and speed;
        ``"lammps-jkr"``: coefficients of LAMMPS's own contact, fitted, for one size.
    fastest
        Fastest normal speed, m/s.
    friction_basis
        As of `model.dynamics.impact.simulate`.
    tolerance
        Largest error of e and of the supporting impulse.
    speeds
        Normal speeds at which coefficients are fitted, m/s; from 1.5 to 15 times the capture
        velocity if none are given.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    TypeError, ValueError
        If an argument is out of range, contacts differ in more than their diameters, or none
        rebounds.
    OSError
        If a file cannot be written.
    """
    require_contact(contact, any_law=True, pair=True)
    choice("format", format, FORMATS)
    if contact.is_pair and format in WALL_FORMATS:
        others = ", ".join(form for form in FORMATS if form not in WALL_FORMATS)
        raise ValueError(f"format {format!r} is of a wall: two spheres have {others}")
    basis = chosen_basis(contact, friction_basis)
    if format == LAMMPS:
        return _written(path, lammps_files(contact, speeds_of_fit(contact, speeds)))
    if speeds is not None:
        raise ValueError(f"speeds are of format {LAMMPS!r}, got {format!r}")
    speed = float(checked("fastest", fastest, SPEED))
    law = rebounds(contact, speed, basis, float(checked("tolerance", tolerance, TOLERANCES)))
    if format == "csv":
        return _written(path, {"microimpact_rebound.csv": _commented(law) + _text(_sampled(law))})
    return _written(path, {name: _filled(name, law) for name in (HEADER, *WORKED[format])})


def _written(path: Path | str, contents: Mapping[str, str]) -> list[Path]:
    """Files of a folder, once they are written."""
    files = [Path(path) / name for name in contents]
    for file, content in zip(files, contents.values(), strict=True):
        write_file(file, content)
    return files


HEADER = "microimpact_rebound.h"
# Worked boundary conditions that go with it.
WORKED = {
    "c": ("example.c",),
    "fluent": ("microimpact_fluent.c",),
    "openfoam": (
        *("MicroimpactRebound.H", "MicroimpactRebound.C", "makeMicroimpactRebound.C"),
        *("Make/files", "Make/options"),
    ),
}


def _filled(name: str, law: Rebounds) -> str:
    """Template with the numbers of the law."""
    rows = (str(piece).replace("[", "{").replace("]", "}") for piece in law.coefficients.tolist())
    contact = law.sizes.middle
    smallest, largest = law.sizes.ends
    return template(
        name,
        described="\n * ".join(_description(law)),
        version=version("microimpact"),
        basis=law.basis,
        net=int(law.basis == "net"),
        diameter=repr(float(contact.diameter)),
        smallest=repr(smallest * (1.0 - NEARLY)),
        largest=repr(largest * (1.0 + NEARLY)),
        narrowness=repr(1.0 / law.sizes.half_width if law.sizes.half_width else 0.0),
        density=repr(float(contact.particle.density)),
        friction=repr(float(contact.friction)),
        slowness=", ".join(map(repr, law.slowness.tolist())),
        slownesses=law.slowness.size,
        captures=int(law.captures),
        fastest=repr(law.fastest),
        lowest=law.table.lowest,
        split=law.table.split,
        bands=law.table.coefficients.shape[0],
        pieces=law.table.coefficients.shape[1],
        widths=law.coefficients.shape[1],
        terms=law.coefficients.shape[2],
        inertia=repr(INERTIA),
        slip_per_impulse=repr(SLIP_PER_IMPULSE),
        coefficients=",\n    ".join(rows),
    )


def _description(law: Rebounds) -> list[str]:
    """Contact, range and error, in lines of words."""
    contact, ends = law.sizes.middle, law.sizes.ends
    sizes = [f"{d * 1e6:g}" for d in (ends if law.sizes.half_width else ends[:1])]
    limits = [f"{float(law.unit(d)) * law.captures:.6g} m/s" for d in ends[: len(sizes)]]
    if len(sizes) > 1:
        limits = [f"{limit} at {d} um" for limit, d in zip(limits, sizes, strict=True)]
    adhesion = f"w_A = {contact.work_of_adhesion:.6g} J/m2"
    if len(sizes) > 1 and contact.adhesion_input == "ring_force":
        adhesion = f"f_0 = {contact.ring_force:.6g} N/m"
    return [
        f"{contact.particle.name} on {contact.surface.name}, {' to '.join(sizes)} um: {adhesion},",
        f"{_losses(contact)}, f = {contact.friction:g} on the {law.basis} force.",
        f"Capture velocity {', '.join(limits)}; holds up to {law.fastest:.6g} m/s.",
        f"Error of e and of the impulse ratio: {law.table.error:.1e}.",
        *(_of_two_spheres(contact) if contact.is_pair else ()),
    ]


def _losses(contact: Contact) -> str:
    """Damping of the ring force, or the other law with its parameters, in words."""
    if contact.law is not None:
        values = ", ".join(f"{name} = {v:g}" for name, v in contact.law.parameters.items())
        return f"law {contact.law.name}, {values}"
    rate = contact.reference_velocity
    return (
        f"c_H = {contact.hertz_damping:.6g} s/m, c_A = {contact.adhesion_damping:.6g} s/m, "
        f"n = {contact.adhesion_rate_exponent:g}"
        + (f" with v_N = {rate:g} m/s" if rate is not None else "")
    )


def _of_two_spheres(contact: Contact) -> list[str]:
    """Meaning of velocities and spin between two spheres, in lines of words."""
    second, share = contact.partner_diameter, float(contact.mass_share)
    size = float(second / contact.diameter)
    return [
        f"Two spheres, the second of {second * 1e6:g} um: velocities are relative to the second,",
        f"and the spin is that of the first plus {size:.9g} times that of the second.",
        f"Of its change the first sphere takes the share {share:.9g}, the second "
        f"{(1.0 - share) / size:.9g};",
        f"of a change of relative velocity the first takes {share:.9g}, the second the rest, back.",
    ]


def _sampled(law: Rebounds) -> dict[str, FloatArray]:
    """Columns of e and of the sliding impulse ratio over size and speed, dense near capture."""
    sizes = np.geomspace(*law.sizes.ends, SIZES if law.sizes.half_width else 1)
    diameter, unit = (np.repeat(a, ROWS) for a in (sizes, law.unit(sizes)))
    top = law.fastest / law.unit(sizes) - law.offset
    shares = np.linspace(0.0, 1.0, ROWS, endpoint=False)
    rising = top > 1e-4  # spheres of other sizes rebound at no speed of the table
    diameter, unit = (a[np.repeat(rising, ROWS)] for a in (diameter, unit))
    x = np.ravel(1e-4 * (top[rising, None] / 1e-4) ** shares)
    speed = unit * (x + law.offset)
    e, impulse = law(speed, diameter)
    ratio = 1.0 if law.basis == "net" else impulse / (1.0 + e)
    columns = {"diameter_m": diameter}
    if law.captures:
        columns["v_n_over_v_c"] = x + 1.0
    return columns | {
        "normal_speed_m_per_s": speed,
        "restitution": e,
        "impulse_ratio_of_sliding": np.broadcast_to(law.sizes.middle.friction * ratio, e.shape),
        "supporting_impulse_per_mass_and_speed": impulse,
        "error": np.full(e.size, law.table.error),
    }


def _text(columns: dict[str, FloatArray]) -> str:
    """Columns as CSV."""
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return "".join(",".join(map(str, row)) + "\n" for row in (columns, *rows))


RULE = """\
Captured where v_n <= v_c. Else V_n = e v_n, and with the slip s = v_t - r omega and the supporting
impulse I = supporting_impulse_per_mass_and_speed: the sphere leaves rolling if 7/2 f I v_n >= |s|,
and the slip's own velocity changes by 2/7 |s|; else it slides and changes by
impulse_ratio_of_sliding (1 + e) v_n. Friction acts against the slip; spin changes by 5/(2 r) of it.
A captured sphere ends rolling. v_n is the normal speed, not the total one."""


def _commented(law: Rebounds) -> str:
    """Description and rule, as comments of a table."""
    lines = [*_description(law), *RULE.splitlines()]
    return "".join(f"# {line}\n" for line in lines)
