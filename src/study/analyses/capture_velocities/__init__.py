"""Capture velocity by competing laws, for declared and calibrated contacts and over diameter."""
