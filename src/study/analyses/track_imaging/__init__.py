"""Range and errors of the particle trajectory imaging system (Section 2.1)."""
