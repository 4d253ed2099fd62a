"""The virtual laboratory: particles and surfaces, true impacts, instruments, data reduction."""
