"""Measurements that a user brings: read, compared with models, drawn."""
