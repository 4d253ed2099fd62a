"""Phase Doppler particle analyser: pair search and correction to the surface."""
