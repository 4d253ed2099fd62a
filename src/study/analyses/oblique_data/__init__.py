"""Oblique impacts measured by others, against a rigid and a compliant contact."""
