"""A run of the study: its configuration, inputs, jobs and stamp."""
