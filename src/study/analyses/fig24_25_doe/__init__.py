"""Designed experiments on the capture velocity (Section 4.3, Figs. 24 and 25)."""
