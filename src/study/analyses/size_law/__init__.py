"""How the capture velocity goes with the size, by law of contact, and impacts that decide on it."""
