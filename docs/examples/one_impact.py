"""One impact of a steel sphere on silicon, followed in time."""

import matplotlib.pyplot as plt

from microimpact import Contact, materials, simulate, trajectory

# e = 0.70 at 1.66 m/s and v_c = 0.18 m/s leave a family of contacts open; this has n = 1.
contact = Contact(
    particle=materials["stainless-steel-316"],
    surface=materials["silicon"],
    diameter=62e-6,
    work_of_adhesion=0.7,
    hertz_damping=0.2148,
    adhesion_damping=1.612,
    adhesion_rate_exponent=1.0,
    reference_velocity=1.66,
    friction=0.15,
)
impact = simulate(contact, speed=1.66, angle=50.0)
print(impact)
print(f"e = {impact.coefficient_of_restitution:.3f}")

trajectory(contact, speed=1.66, angle=50.0).plot()
plt.show()
