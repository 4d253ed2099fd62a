"""Results against references, and runs against each other."""
