"""Coefficients measured on a slope: exact, expanded, as printed."""
