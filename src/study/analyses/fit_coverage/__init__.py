"""How well Eq. (34), and an average of models, find the capture velocity (Section 3.3)."""
