"""Moments of rolling that the models neglect, against the moment of friction (Section 3.2.3)."""
