"""Separation force of an irregular, charged particle against the weight of silica on it."""
