"""Mechanisms that the article supposes behind its measured means, each alone (2.4, 3.1.4)."""
