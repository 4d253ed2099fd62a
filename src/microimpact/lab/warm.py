"""Compile all there is to compile: ``microimpact warm-up``.

Jobs that start side by side on a new machine would each compile the same functions.
"""

from __future__ import annotations

import gc
from concurrent.futures import ProcessPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np

from microimpact.core.declared import materials
from microimpact.lab.events import Falling, Impacts
from microimpact.lab.experiment import Target, impacts_of
from microimpact.lab.pdpa import analyser as pdpa
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.system import ImagingSystem, Setup, Systematics
from microimpact.lab.surface import rough
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR, MaugisBarquins
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.empirical.comparison import compare_models
from microimpact.model.law.table import tabulate

GLASS: Any = dict.fromkeys(("particle", "surface"), materials["glass"]) | {"diameter": 5e-5}
CONTACT = Contact(**GLASS, work_of_adhesion=0.1, hertz_damping=0.01, adhesion_damping=1.0)


def main() -> None:
    """Use every compiled function of model and laboratory once; they stay in Numba's cache.

    In two processes, neither of which needs what the other compiles.
    """
    with ProcessPoolExecutor(initializer=gc.disable) as pool:  # a seventh is the collector's
        for part in [pool.submit(_use_tables), pool.submit(_use_others)]:
            part.result()


def _use_others() -> None:
    """Use fits, another law of contact and instruments."""
    speed, impacts, rng = np.geomspace(1.0, 10.0, 8), _impacts(), np.random.default_rng(1)
    for law in (JKR(viscous_time=1e-9), MaugisBarquins(edge_speed=1.0, edge_exponent=1.0)):
        simulate(CONTACT.by_law(law, 0.1), speed)
    compare_models(speed, 0.8 - 0.1 / speed, 0.01)
    probe: Any = SimpleNamespace(probe_across_um=100.0, probe_along_um=100.0)
    pdpa.passages(impacts, 1e-3, probe)
    pdpa.through_probe(impacts.position, impacts.velocity, 1e-3, probe)
    numbers = dict.fromkeys(ImagingSystem.__dataclass_fields__, 1.0) | {"frame_px": (64, 64)}
    camera: Any = SimpleNamespace(**numbers)
    setup = Setup(instrument=camera, angle=60.0, speed=1.66, diameter=6e-5)
    theory(impacts, setup, Systematics(), [rng] * 8)


def _use_tables() -> None:
    """Use impacts followed in time and along the surface, tables and rough surfaces."""
    speed = np.array([0.5, 1.0])
    trajectory(CONTACT, 1.0)
    simulate(CONTACT, speed, tangential="mindlin")
    law = tabulate(CONTACT, *speed)
    law.quantities(speed, np.zeros(1))
    law.restitution(speed, np.zeros(1))
    law.simulate(speed)
    _impacts()


def _impacts() -> Impacts:
    """Impacts of eight spheres that fall on a tilted rough target."""
    falling = Falling(
        time=np.zeros(8),
        diameter=np.full(8, 5e-5),
        position=np.zeros((8, 2)),
        velocity=np.tile([0.83, 0.0, -1.44], (8, 1)),
        spin=np.zeros((8, 3)),
    )
    target, rng = Target(contact=CONTACT, surface=rough(0.1)), np.random.default_rng(1)
    return impacts_of(falling, target.hit(falling.diameter, falling.velocity, falling.spin, rng))


if __name__ == "__main__":
    main()
