"""Figures of Section 2."""
