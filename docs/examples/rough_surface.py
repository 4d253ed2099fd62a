"""Impacts on a rough surface: facets scatter the angle, and what is measured is not e."""

import matplotlib.pyplot as plt
import numpy as np

from microimpact import Contact, materials
from microimpact.lab.experiment import Target
from microimpact.lab.surface import rough
from microimpact.model.dynamics.impact import velocity_components
from microimpact.statistics.distributions import generator

contact = Contact(
    particle=materials["stainless-steel-316"],
    surface=materials["silicon"],
    diameter=62e-6,
    work_of_adhesion=0.7,
    hertz_damping=0.2148,
    adhesion_damping=1.612,
    adhesion_rate_exponent=1.0,
    reference_velocity=1.66,
)
rng, spheres = generator(20011, 2), 4000
v_n, v_t = velocity_components(1.66, 20.0)
before = np.tile([v_t, 0.0, v_n], (spheres, 1))
# Slopes of so many radians per axis; facets are hit by the area that they show to the motion.
for slope in (0.05, 0.16):
    target = Target(contact=contact, surface=rough(slope))
    after = target.hit(np.full(spheres, 62e-6), before, np.zeros_like(before), rng)
    seen = after.velocity[~after.captured, 2] / -v_n
    print(f"slope {slope:g}: mean {seen.mean():.2f}, {after.captured.mean():.1%} captured")
    plt.hist(seen, 60, histtype="step", label=f"slope {slope:g} rad")
plt.xlabel("normal velocity after over before")
plt.legend()
plt.show()
