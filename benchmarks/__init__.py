"""Speed and error of the impact solver beside general ones; `make bench` runs `compare`."""

import os

# Before the libraries are loaded: each would start its own threads.
for _name in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ[f"{_name}_NUM_THREADS"] = "1"
