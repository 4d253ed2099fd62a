"""Capture velocity against the diameter, by the ring force and by a JKR contact."""

import matplotlib.pyplot as plt
import numpy as np

from microimpact import JKR, Contact, capture_velocity, materials

diameter = np.geomspace(1e-6, 100e-6, 60)
ring_force = Contact(
    particle=materials["soda-lime-glass"],
    surface=materials["silicon"],
    diameter=diameter,
    work_of_adhesion=0.2,
    hertz_damping=0.05,
    adhesion_damping=1.0,
)
viscous = ring_force.by_law(JKR(viscous_time=2e-10), work_of_adhesion=0.2)

figure, axes = plt.subplots(layout="constrained")
for name, contact in {"ring force": ring_force, "viscous JKR": viscous}.items():
    axes.loglog(1e6 * diameter, capture_velocity(contact), label=name)
axes.set(xlabel="diameter (um)", ylabel="capture velocity (m/s)")
axes.legend()
plt.show()
