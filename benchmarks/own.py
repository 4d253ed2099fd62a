"""microimpact's own ways: the whole call, the compiled kernel alone, and interpolation."""

from __future__ import annotations

import numpy as np

from benchmarks.cases import GROUPS, Cases, as_contact, as_hertz_pair, as_jkr_contact
from microimpact.model import passes
from microimpact.model.closed_forms import hertz_contact_time
from microimpact.model.dynamics import kernel
from microimpact.model.dynamics.normal import integrate, normal_impact, scaled_problems
from microimpact.model.law.table import tabulate


class Package:
    """The whole call, from a contact in SI units to every result of an impact."""

    name = "microimpact"
    source = "microimpact"
    settings = (kernel.TOLERANCE,)
    share = 1

    def __init__(self, cases: Cases, setting: float) -> None:
        del setting  # the kernel's tolerance is compiled in
        self.contact, self.speed = as_contact(cases)

    def __call__(self) -> np.ndarray:
        return normal_impact(self.contact, self.speed).coefficient_of_restitution


class Kernel(Package):
    """The integration alone, on problems that are scaled already, as all the peers get them."""

    name = "microimpact, kernel"

    def __init__(self, cases: Cases, setting: float) -> None:
        del setting
        self.problems = scaled_problems(*as_contact(cases))[0]

    def __call__(self) -> np.ndarray:
        results = integrate(self.problems, ledger=False)
        captured = results[:, kernel.STATUS] == kernel.CAPTURED
        e = -results[:, kernel.END_U] / self.problems[:, kernel.START_U]
        return np.where(captured, 0.0, e)


class Hertz(Package):
    """The whole call; the result is the contact time over Hertz's."""

    def __init__(self, cases: Cases, setting: float) -> None:
        del setting
        self.contact, self.speed = as_hertz_pair(cases)
        self.expected = hertz_contact_time(self.contact, self.speed)

    def __call__(self) -> np.ndarray:
        return normal_impact(self.contact, self.speed).contact_time / self.expected


class Jkr(Package):
    """The whole call, of two JKR spheres."""

    def __init__(self, cases: Cases, setting: float) -> None:
        del setting
        self.contact, self.speed = as_jkr_contact(cases)


class Table:
    """Tables of a family of contacts each, here of the three pairs of damping groups.

    Making the tables counts as preparation: they serve any number of impacts of their contacts.
    """

    name = "microimpact, table"
    source = "microimpact"
    settings = (1e-9, 1e-11)
    share = 1

    def __init__(self, cases: Cases, setting: float) -> None:
        self.parts = []
        self.restitution = np.zeros(len(cases))
        for group in GROUPS:
            chosen = np.flatnonzero((cases.hertz == group[0]) & (cases.adhesion == group[1]))
            contact, speed = as_contact(Cases(cases.speed[chosen], *np.array(group)))
            tables = tabulate(contact, np.min(speed), np.max(speed), setting)
            self.parts.append((chosen, tables, contact, speed))

    def __call__(self) -> np.ndarray:
        for chosen, tables, contact, speed in self.parts:
            values, _ = tables.quantities(*tables.family.coordinates(contact, speed))
            self.restitution[chosen] = values[passes.RESTITUTION]
        return self.restitution
