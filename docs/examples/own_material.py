"""A material that is not declared; numbers with a slip of the unit are warned of."""

import warnings

from microimpact import Contact, Material, capture_velocity, materials

pollen = Material(name="pollen", youngs_modulus=1e9, poissons_ratio=0.3, density=1100.0)
leaf = Material(name="leaf", youngs_modulus=200e6, poissons_ratio=0.45, density=900.0)
contact = Contact(
    particle=pollen,
    surface=leaf,
    diameter=25e-6,
    work_of_adhesion=0.05,
    hertz_damping=0.05,
    adhesion_damping=0.5,
    friction=0.4,
)
print(contact)
print(f"on a leaf:  {capture_velocity(contact):.3f} m/s")
on_glass = contact.replace(surface=materials["glass"])
print(f"on glass:   {capture_velocity(on_glass):.3f} m/s")

with warnings.catch_warnings(record=True) as doubts:
    warnings.simplefilter("always")
    Material(name="glass", youngs_modulus=70, poissons_ratio=0.2, density=2500.0)  # GPa
print(doubts[0].message)
