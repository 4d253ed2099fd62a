"""Trends of R, rho and e with the normal impact speed (Fig. 14, a schematic)."""
