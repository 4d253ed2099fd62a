"""Contacts consistent with measured restitutions, and what they predict at other sizes."""

import matplotlib.pyplot as plt
import numpy as np

from microimpact import Contact, calibrate_laws, capture_velocity, materials
from microimpact.model.contact import resized

bodies = Contact(
    particle=materials["stainless-steel-316"],
    surface=materials["silicon"],
    diameter=62e-6,  # the size that was measured
    work_of_adhesion=0.5,  # not used: it is drawn
)
v = [0.2, 0.25, 0.3, 0.5, 0.8, 1.2, 1.7]
e = [0.19, 0.36, 0.44, 0.61, 0.69, 0.72, 0.70]
drawn = calibrate_laws(bodies, v, e, sigma=0.05, draws=100)
print(drawn)

figure, axes = plt.subplots(layout="constrained")
diameter = np.geomspace(20e-6, 200e-6, 15)
for law, contact in drawn.contacts.items():
    limits = [capture_velocity(resized(contact, d)) for d in diameter]
    low, high = np.quantile(limits, [0.025, 0.975], axis=1, method="nearest")
    axes.fill_between(1e6 * diameter, low, high, alpha=0.5, label=law)
axes.set(xlabel="diameter (um)", ylabel="capture velocity, 95 % (m/s)", xscale="log", yscale="log")
axes.legend()
plt.show()
