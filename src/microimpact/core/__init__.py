"""Checked arrays, units, materials, compiled code, files and tables."""
