"""The phase Doppler particle analyser and experiments at normal incidence (Section 2.1)."""
