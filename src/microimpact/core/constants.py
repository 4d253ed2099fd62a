"""Constants of nature, under SciPy's definitions; SciPy takes longer to load than some analyses."""

from __future__ import annotations

from typing import Final

# Standard acceleration of free fall, m/s2: by definition (3rd CGPM, 1901).
gravity: Final = 9.80665
# Permittivity of the vacuum, F/m (CODATA 2022).
epsilon_0: Final = 8.8541878188e-12
