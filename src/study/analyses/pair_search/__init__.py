"""Pair search in the records of a phase Doppler particle analyser, and correction to the surface."""
