"""Restitution and impulse ratio measured on a slope: exact, expanded, and as printed (Section 4.1)."""
