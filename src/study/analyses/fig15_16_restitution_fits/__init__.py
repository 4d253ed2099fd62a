"""Simulated restitution curves and their fits by Eq. (34) (Figs. 15 and 16)."""
