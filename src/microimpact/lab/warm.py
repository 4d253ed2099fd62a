"""Compile all there is to compile: ``microimpact warm-up``.

Jobs that start side by side on a new machine would each compile the same functions.
"""

from __future__ import annotations

import gc
from concurrent.futures import ProcessPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np

from microimpact.core.materials import Material
from microimpact.lab.dispenser import Dispenser
from microimpact.lab.experiment import Drop, Target, impacts_of
from microimpact.lab.pdpa import analyser as pdpa
from microimpact.lab.ptis.errors import theory
from microimpact.lab.ptis.system import ImagingSystem, Setup, Systematics
from microimpact.lab.surface import Rebound, Spheres, rigid_sums, rough
from microimpact.model.contact import Contact
from microimpact.model.contact_laws import JKR
from microimpact.model.dynamics.impact import simulate
from microimpact.model.dynamics.normal import normal_impact
from microimpact.model.dynamics.trajectory import trajectory
from microimpact.model.empirical.comparison import compare_models
from microimpact.model.empirical.data import data_sets
from microimpact.model.empirical.search import fit_batch
from microimpact.model.law.codes import lethe
from microimpact.model.law.table import tabulate
from microimpact.statistics.distributions import Constant

BODY = Material(name="any", youngs_modulus=1e11, poissons_ratio=0.3, density=2e3)
PAIR: Any = {"particle": BODY, "surface": BODY, "diameter": 5e-5}
CONTACT = Contact(**PAIR, work_of_adhesion=0.1, hertz_damping=0.01, adhesion_damping=1.0)
# All that passages through the probe volume take of an analyser.
ANALYSER: Any = SimpleNamespace(probe_across_um=100.0, probe_along_um=100.0)
STILL: Any = dict.fromkeys(Dispenser.__dataclass_fields__, 0.0) | {"taps_per_s": 1.0}
DROP = Drop(
    target=Target(contact=CONTACT, surface=rough(0.1)),
    diameter_um=Constant(at=50.0),
    speed=1.66,
    dispenser=Dispenser(**STILL | {"particles_per_tap": 1.0}),
    angle=60.0,
)
IMAGING: Any = SimpleNamespace(
    **dict.fromkeys(ImagingSystem.__dataclass_fields__, 1.0) | {"frame_px": (64, 64)}
)


def main() -> None:
    """Use every compiled function of model and laboratory once; they stay in Numba's cache.

    In two processes, neither of which needs what the other compiles.
    """
    with ProcessPoolExecutor(initializer=gc.disable) as pool:  # a seventh is the collector's
        for part in [pool.submit(_use_impacts), pool.submit(_use_others)]:
            part.result()


def _use_others() -> None:
    """Use fits, the other laws of contact and instruments."""
    speed = np.geomspace(1.0, 10.0, 8)
    normal_impact(Contact(**PAIR, work_of_adhesion=0.1, law=JKR(viscous_time=1e-9)), speed)
    lethe(CONTACT)(0.1, 0.1, speed)
    fit_batch(data_sets(speed, 0.8 - 0.1 / speed, 100.0))
    compare_models(speed, 0.8 - 0.1 / speed, 0.01)
    falling, rng = DROP.release(8, np.random.default_rng(1)), np.random.default_rng(1)
    after = falling.velocity * [0.75, 1.0, -0.7]
    once = Rebound(
        velocity=after, spin=falling.spin, kept=after[:, 2] < 0, contacts=np.ones(8, int)
    )
    impacts = impacts_of(falling, once)
    pdpa.passages(impacts, 1e-3, ANALYSER)
    pdpa.through_probe(impacts.position, impacts.velocity, 1e-3, ANALYSER)
    setup = Setup(instrument=IMAGING, angle=DROP.angle, speed=DROP.speed, diameter=6e-5)
    theory(impacts, setup, Systematics(), [rng] * 8)


def _use_impacts() -> None:
    """Use the integration of impacts, its tables, and passes over ensembles."""
    trajectory(CONTACT, 1.0)
    speed = np.array([0.5, 1.0])
    law = tabulate(CONTACT, *speed)
    law.normal_impact(CONTACT, speed)
    law.restitution(speed, np.zeros(1))
    law.simulate(speed)
    simulate(CONTACT, speed)
    simulate(CONTACT, speed, tangential="mindlin")
    half = np.full(1, 0.5)
    rigid_sums(rough(0.1), law, [Spheres([half] * 8, [(half, half)] * 5, 1, 1)])
    DROP.impacts(8, np.random.default_rng(1))


if __name__ == "__main__":
    main()
