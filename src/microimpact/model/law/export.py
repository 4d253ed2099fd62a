"""The rebound law of one contact for other programs: tables, C, boundary conditions.

What a program of flow or of particles needs of a normal impact are two numbers that depend on the
normal speed alone: e, and the impulse of the normal force in Coulomb's law. From them the rule of
`model.dynamics.impact` (slip, rolling, capture) is algebra.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from microimpact.core.arrays import FloatArray, Numbers, checked, choice
from microimpact.core.files import write_file
from microimpact.model.choices import FORMATS, FRICTION_BASES, WALL_FORMATS
from microimpact.model.contact import Contact
from microimpact.model.dynamics.normal import integrate
from microimpact.model.law.families import Family, quantities
from microimpact.model.law.jkr import lammps_files
from microimpact.model.law.pieces import SPLITS, TOLERANCES, Table, piecewise
from microimpact.model.passes import RESTITUTION, SUPPORT, WIDTH
from microimpact.model.rigid_body.algebra import INERTIA, SLIP_PER_IMPULSE

# Binary exponent of the lowest octave of v/v_c - 1: there e ~ sqrt(v/v_c - 1) to some parts in a
# million of itself, and e is 1e-4. Without capture, of c_H v: there e is 1 to double precision.
LOWEST, LOWEST_BARE = -24, -52
# Points an octave, off the nodes, at which the error is measured; the error stated is twice that.
HELD_OUT, SAFETY = 37, 2.0
ROWS = 200  # of the tables for people
IMPULSE = 1  # row of the impulse in the table, beside RESTITUTION


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rebounds:
    """e and the supporting impulse of one contact over the normal speed, to a stated error."""

    # The contact, and the normal force in Coulomb's law.
    contact: Contact
    basis: str
    capture_velocity: float  # m/s; 0 where nothing is captured
    unit: float  # The table's variable is v/unit, less 1 where spheres are captured; m/s
    # Polynomials of `RESTITUTION` and `IMPULSE`, the impulse per mass and normal speed.
    table: Table
    fastest: float  # Normal speed up to which it holds, m/s
    error: float  # Bound of the error of both, as a share of 1 or of the number if this is larger

    @property
    def offset(self) -> float:
        """Offset of the table's variable, v/unit less this."""
        return 1.0 if self.capture_velocity else 0.0

    @property
    def coefficients(self) -> FloatArray:
        """Powers' coefficients of `RESTITUTION` and `IMPULSE`, (pieces, powers, 2)."""
        rows = self.table.coefficients[0, :, 0, [RESTITUTION, IMPULSE]]
        return np.moveaxis(rows, 0, -1)

    def __call__(self, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return e and the impulse per mass and normal speed at normal speeds (n,), m/s."""
        x = speed / self.unit - self.offset
        lowest = math.ldexp(0.5, self.table.lowest)
        values = self.table(np.maximum(x, lowest), np.zeros(1))
        e = values[RESTITUTION]
        if self.offset:
            e = e * np.sqrt(np.clip(x / lowest, 0.0, 1.0))
        return e, np.where((x > 0.0) | (self.offset == 0.0), values[IMPULSE], 0.0)


def rebounds(
    contact: Contact, family: Family, fastest: float, basis: str, tolerance: float
) -> Rebounds:
    """Return the rebound law of one contact up to a normal speed.

    Parameters
    ----------
    contact, family
        The contact, and its family.
    fastest
        m/s.
    basis
        Normal force in Coulomb's law.
    tolerance
        Largest error of e and of the impulse, see `Rebounds`.

    Raises
    ------
    ValueError
        If there are several contacts, none rebounds up to ``fastest``, or no table is that close.
    """
    if contact.shape:
        raise ValueError(f"contact must be a single one to be exported, got {contact.shape}")
    at = np.zeros(1)
    limit = float(family.capture_speed(at)[0])
    scale = float(contact.velocity_scale) or 1.0 / (float(contact.hertz_damping) or 1.0)
    unit, offset = limit * scale or scale, 1.0 if limit else 0.0
    top = fastest / unit - offset
    lowest = LOWEST if family.adhesive else LOWEST_BARE
    if top <= math.ldexp(1.0, lowest):
        raise ValueError(
            f"fastest must be above the capture velocity {limit * scale:.6g} m/s, got {fastest:g}"
        )

    def sampled(x: FloatArray, position: FloatArray) -> FloatArray:
        w = (1.0 + x) * limit if limit else x
        problems = family.problems(w, position)
        values = quantities(problems, integrate(problems, ledger=True))
        out = np.zeros((WIDTH, x.size))
        out[RESTITUTION] = values[RESTITUTION]
        out[IMPULSE] = values[SUPPORT[basis]] / (w if family.adhesive else 1.0)
        return out

    octaves = math.frexp(top)[1] - lowest + 1
    held_out = np.exp2(lowest - 1 + np.linspace(0.0, octaves, HELD_OUT * octaves, endpoint=False))
    expected = sampled(held_out, np.zeros_like(held_out))
    error = math.inf
    for split in SPLITS:
        table = piecewise(sampled, lowest=lowest, octaves=octaves, split=split)
        difference = np.abs(table(held_out, at) - expected) / np.maximum(expected, 1.0)
        error = SAFETY * float(np.max(difference))
        if error <= tolerance:
            return Rebounds(
                contact=contact,
                basis=basis,
                capture_velocity=limit * scale,
                unit=unit,
                table=table,
                fastest=unit * (math.ldexp(1.0, lowest + octaves - 1) + offset),
                error=error,
            )
    raise ValueError(f"tolerance {tolerance:g} is not reached; the closest comes to {error:.1g}")


def export(
    contact: Contact,
    family: Family,
    fastest: float,
    path: Path | str,
    form: str,
    friction_basis: str,
    tolerance: float,
    speeds: Numbers | None = None,
) -> list[Path]:
    """Write the rebound law of a contact for another program.

    Parameters
    ----------
    contact
        Single contact.
    family
        Normal impacts as functions of scaled speed, tabulated.
    fastest
        Greatest normal speed, m/s.
    path
        Folder of the files.
    form, friction_basis, tolerance, speeds
        As of `model.law.table.Law.export`.
    """
    choice("format", form, FORMATS)
    if contact.is_pair and form in WALL_FORMATS:
        raise ValueError(f"format {form!r} is of a wall: two spheres have c, csv and npz")
    basis = choice("friction_basis", friction_basis, FRICTION_BASES)
    limit = float(checked("tolerance", tolerance, TOLERANCES))
    if form == "lammps-jkr":
        return _written(path, lammps_files(contact, speeds))
    if speeds is not None:
        raise ValueError(f"speeds are of the format 'lammps-jkr', got format {form!r}")
    law = rebounds(contact, family, fastest, basis, limit)
    contents: dict[str, str | bytes] = {}
    if form in {"c", "fluent", "openfoam"}:
        contents["microimpact_rebound.h"] = _filled("rebound.h", law)
    if form == "csv":
        contents["microimpact_rebound.csv"] = _commented(law) + _text(_sampled(law))
    elif form == "npz":
        contents["microimpact_rebound.npz"] = _archive(law)
    elif form == "lammps":
        contents["microimpact_wall.table"] = _wall_table(law)
    contents |= {name: _filled(name, law) for name in WORKED.get(form, ())}
    return _written(path, contents)


def _written(path: Path | str, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Files of a folder, once they are written."""
    files = [Path(path) / name for name in contents]
    for file, content in zip(files, contents.values(), strict=True):
        write_file(file, content)
    return files


# Worked boundary conditions that go with a format.
WORKED = {
    "c": ("example.c",),
    "fluent": ("microimpact_fluent.c",),
    "openfoam": (
        *("MicroimpactRebound.H", "MicroimpactRebound.C", "makeMicroimpactRebound.C"),
        *("Make/files", "Make/options"),
    ),
    "lammps": ("in.microimpact",),
}


def _filled(name: str, law: Rebounds) -> str:
    """Template with the numbers of the law."""
    text = (files(__package__) / "templates" / name).read_text(encoding="utf-8")
    rows = (
        "{" + ", ".join("{" + f"{e!r}, {i!r}" + "}" for e, i in piece) + "}"
        for piece in law.coefficients.tolist()
    )
    contact = law.contact
    return Template(text).substitute(
        described="\n * ".join(_description(law)),
        version=version("microimpact"),
        basis=law.basis,
        net=int(law.basis == "net"),
        radius=repr(float(contact.radius)),
        diameter=repr(float(contact.diameter)),
        start=repr(1.01 * float(contact.radius)),
        points=20 * ROWS,
        density=repr(float(contact.particle.density)),
        friction=repr(float(contact.friction)),
        unit=repr(law.unit),
        offset=repr(law.offset),
        capture_velocity=repr(law.capture_velocity),
        fastest=repr(law.fastest),
        error=f"{law.error:.1e}",
        lowest=law.table.lowest,
        split=law.table.split,
        pieces=law.table.pieces,
        terms=law.coefficients.shape[1],
        inertia=repr(INERTIA),
        slip_per_impulse=repr(SLIP_PER_IMPULSE),
        coefficients=",\n    ".join(rows),
    )


def _description(law: Rebounds) -> list[str]:
    """Contact, range and error, in lines of words."""
    contact = law.contact
    rate = contact.reference_velocity
    return [
        f"{contact.particle.name} on {contact.surface.name}, {contact.diameter * 1e6:g} um: "
        f"w_A = {contact.work_of_adhesion:.6g} J/m2, c_H = {contact.hertz_damping:.6g} s/m,",
        f"c_A = {contact.adhesion_damping:.6g} s/m, n = {contact.adhesion_rate_exponent:g}"
        + (f" with v_N = {rate:g} m/s" if rate is not None else "")
        + f", f = {contact.friction:g} on the {law.basis} force.",
        f"Capture velocity {law.capture_velocity:.6g} m/s; holds up to {law.fastest:.6g} m/s.",
        f"Error of e and of the impulse ratio: {law.error:.1e}.",
        *(_of_two_spheres(contact) if contact.is_pair else ()),
    ]


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
    """Columns of e and of the sliding impulse ratio over the normal speed, dense near capture."""
    unit, offset = law.unit, law.offset
    x = np.geomspace(1e-4, law.fastest / unit - offset, ROWS, endpoint=False)
    e, impulse = law(unit * (x + offset))
    sliding = law.contact.friction * (np.ones(ROWS) if law.basis == "net" else impulse / (1.0 + e))
    columns: dict[str, FloatArray] = {"normal_speed_m_per_s": unit * (x + offset)}
    if law.capture_velocity:
        columns = {"v_n_over_v_c": x + 1.0} | columns
    return columns | {
        "restitution": e,
        "impulse_ratio_of_sliding": sliding,
        "supporting_impulse_per_mass_and_speed": impulse,
        "error": np.full(ROWS, law.error),
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


def _archive(law: Rebounds) -> bytes:
    """Columns and polynomials as an archive of NumPy."""
    target = io.BytesIO()
    np.savez(
        target,
        **_sampled(law),  # type: ignore[arg-type]
        described=np.array(_commented(law)),
        coefficients=law.coefficients,
        lowest=law.table.lowest,
        split=law.table.split,
        unit=law.unit,
        offset=law.offset,
        capture_velocity=law.capture_velocity,
        radius=law.contact.radius,
        friction=law.contact.friction,
    )
    return target.getvalue()


def _wall_table(law: Rebounds) -> str:
    """Table of the undamped force of Eq. (25) over the distance of centre and wall."""
    contact = law.contact
    radius, bent = float(contact.radius), float(contact.hertz_radius)
    deepest = 2.0 * float(
        (1.25 * contact.mass * law.fastest**2 / (np.sqrt(bent) * contact.stiffness)) ** 0.4
    )
    n = np.linspace(deepest, 0.0, 20 * ROWS)
    contact_radius = np.sqrt(bent * n)
    adhesion = 2.0 * np.pi * float(contact.ring_force or 0.0)
    force = float(contact.stiffness) * np.sqrt(bent) * n**1.5 - adhesion * contact_radius
    energy = 0.4 * float(contact.stiffness) * np.sqrt(bent) * n**2.5
    energy -= adhesion * np.sqrt(bent) * n**1.5 / 1.5
    rows = (
        f"{i} {r!r} {u!r} {f!r}"
        for i, (r, u, f) in enumerate(
            zip((radius - n).tolist(), energy.tolist(), force.tolist(), strict=True), 1
        )
    )
    head = "".join(f"# {line}\n" for line in _description(law))
    return (
        f"{head}# Units: si. Force without damping: no loss, so no capture.\n\n"
        f"CONTACT\nN {n.size}\n\n" + "\n".join(rows) + "\n"
    )
