"""Does a pile on the target tell the capture velocity? Repeated bounces on it (2.3.1)."""
