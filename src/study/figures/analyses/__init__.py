"""Figures of Section 4 and beyond."""
