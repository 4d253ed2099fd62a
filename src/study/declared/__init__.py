"""Declared inputs: provenance, admissible values, YAML files, rows of the declared tables."""
