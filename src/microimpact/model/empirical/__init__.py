"""Empirical coefficients of restitution, Section 3.3: equations, fits, intervals."""
