"""Geometry and example states of the schematic figures (Figs. 1, 2, 3, 13, 19 and 22)."""
