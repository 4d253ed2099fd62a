"""Compile all there is to compile: ``python -m microimpact.model.warm``.

Jobs that start side by side on a new machine would each compile the same functions.
"""

from __future__ import annotations

import numpy as np

from microimpact.core.materials import Material
from microimpact.model.contact import Contact
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.empirical.search import data_sets, fit_batch
from microimpact.model.law.table import tabulate
from microimpact.model.rigid_body.facets import facet_rebound


def main() -> None:
    """Use every compiled function once; they stay in Numba's cache."""
    body = Material(name="any", youngs_modulus=1e11, poissons_ratio=0.3, density=2e3)
    contact = Contact(
        particle=body,
        surface=body,
        diameter=5e-5,
        work_of_adhesion=0.1,
        hertz_damping=0.01,
        adhesion_damping=1.0,
    )
    trajectory(contact, 1.0)
    speed = np.array([0.5, 1.0])
    law = tabulate(contact, *speed)
    law.normal_impact(contact, speed)
    law.restitution(speed, np.zeros(1))
    down = np.array([[0.5, 0.0, -1.0]])
    up = np.array([[0.0, 0.0, 1.0]])
    facet_rebound(down, np.zeros((1, 3)), up, np.full(1, 0.7), np.full(1, 0.15))
    speed = np.geomspace(1.0, 10.0, 8)
    fit_batch(data_sets(speed, 0.8 - 0.1 / speed, 100.0))


if __name__ == "__main__":
    main()
