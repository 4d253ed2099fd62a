"""Restitution and spin against the angle of incidence, by three laws of tangential compliance."""

import matplotlib.pyplot as plt
import numpy as np

from microimpact import Contact, materials, simulate

contact = Contact(
    particle=materials["glass"],
    surface=materials["fused-silica"],
    diameter=40e-6,
    work_of_adhesion=0.1,
    hertz_damping=0.05,
    adhesion_damping=1.0,
    friction=0.2,
)
angle = np.linspace(10.0, 90.0, 81)
figure, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
for law in ("rigid", "mindlin", "spring"):
    impact = simulate(contact, speed=3.0, angle=angle, tangential=law)
    below.plot(angle, impact.spin / 1e3, label=law)
above.plot(angle, impact.coefficient_of_restitution, color="black")
above.set(ylabel="restitution e", ylim=(0.0, 1.0))
below.set(xlabel="angle from the surface (degrees)", ylabel="spin after (1000 rad/s)")
below.legend()
plt.show()
