"""A collision of two spheres: momentum and angular momentum are kept."""

import numpy as np

from microimpact import Contact, capture_velocity, materials, simulate

steel = materials["stainless-steel-316"]
contact = Contact(
    particle=steel,
    surface=steel,
    diameter=62e-6,
    partner_diameter=31e-6,
    work_of_adhesion=0.7,
    hertz_damping=0.2,
    adhesion_damping=1.6,
)
# Speeds are those of the sphere relative to the second; both may spin.
impact = simulate(contact, speed=2.0, angle=50.0, partner_spin=2e4)
print(impact)
print(f"v_c = {capture_velocity(contact):.3f} m/s")

# Velocities of both in the frame of the centre of mass.
share = contact.mass_share
relative = np.array([impact.tangential_velocity, impact.normal_velocity])
print("sphere", share * relative, "second", (share - 1.0) * relative)
plane = contact.replace(partner_diameter=np.inf)
print(f"v_c on a plane of the same steel: {capture_velocity(plane):.3f} m/s")
