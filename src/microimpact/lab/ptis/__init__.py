"""The particle trajectory imaging system and experiments at oblique incidence (Section 2.1)."""
