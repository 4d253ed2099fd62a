"""Schematic figures."""
