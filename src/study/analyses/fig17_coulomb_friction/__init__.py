"""Impulse ratio against angle of incidence for Coulomb friction (Fig. 17, rigid body model)."""
