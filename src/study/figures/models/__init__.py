"""Figures of Section 3."""
