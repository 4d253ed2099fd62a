"""Capture velocity from a file of measured rebounds, averaged over several models."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from microimpact import compare_models, read_rebounds

Path("rebounds.csv").write_text("""v (cm/s),e,sigma
15,0,0.02
20,0.19,0.02
23,0.30,0.02
30,0.45,0.02
40,0.56,0.02
55,0.64,0.02
80,0.68,0.02
120,0.72,0.02
170,0.71,0.02
250,0.66,0.02
""")
data = read_rebounds("rebounds.csv", sigma_v="1%")
comparison = compare_models(**data)
print(comparison)

figure, axes = plt.subplots(layout="constrained")
v = np.geomspace(0.1, 3.0, 300)
for model in comparison.models[:3]:
    axes.semilogx(v, model.law(v), label=f"{model.name}, weight {model.weight:.2f}")
axes.errorbar(data.v, data.e, data.sigma, fmt="o", color="black", mfc="white")
axes.axvspan(*comparison.v_c_interval, color="0.9")
axes.set(xlabel="normal speed (m/s)", ylabel="restitution e")
axes.legend()
plt.show()
