"""The rebound law of a contact as a C header, for a flow or particle code."""

from microimpact import Contact, export, materials

contact = Contact(
    particle=materials["polystyrene-latex"],
    surface=materials["mica"],
    diameter=(1e-6, 5e-6),  # a law for all sizes between
    work_of_adhesion=0.15,
    hertz_damping=0.05,
    adhesion_damping=0.05,
)
for path in export(contact, "rebound", "c", fastest=50.0):
    print(path)
    print("".join(path.read_text().splitlines(keepends=True)[:12]))
