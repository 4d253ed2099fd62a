"""How often the 95 % intervals of some 40 events hold the true mean, and which (Section 2.1)."""
