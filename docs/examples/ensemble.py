"""Ten thousand spheres of random sizes and speeds, each integrated; a million from a table."""

import matplotlib.pyplot as plt
import numpy as np

from microimpact import Contact, materials, simulate, tabulate
from microimpact.statistics.distributions import Normal, TruncatedNormal, generator, sample

# A generator is made from a seed and a key: each part of an analysis has separate numbers.
rng = generator(20011, 1)
diameter = 1e-6 * sample(TruncatedNormal(mean=62.0, sd=4.5, low=45.0, high=76.0), rng, 10_000)
speed = sample(Normal(mean=0.2, sd=0.01), rng, 10_000)
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
impacts = simulate(contact.replace(diameter=diameter), speed)
print(impacts)
plt.scatter(1e6 * diameter, speed, s=2, c=impacts.coefficient_of_restitution)
plt.colorbar(label="restitution e; 0 where captured")
plt.xlabel("diameter (um)")
plt.ylabel("speed (m/s)")
plt.show()

law = tabulate(contact, slowest=0.01, fastest=3.0, tolerance=1e-9)
many = law.simulate(rng.uniform(0.2, 3.0, 1_000_000), angle=rng.uniform(10.0, 90.0, 1_000_000))
print(f"relative error of e: {np.max(many.interpolation_error):.0e} at most")
