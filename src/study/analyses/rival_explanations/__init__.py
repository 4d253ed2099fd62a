"""Rivals of adhesion that lower restitution, and the capture velocity of steel (2.3.1)."""
