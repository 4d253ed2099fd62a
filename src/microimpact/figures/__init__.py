"""Figures: each a function of tables, which computes no physics.

A figure module defines ``draw(tables, spec)``; what is drawn where, and the words on it,
are in ``config/figures.yaml``, read by `microimpact.figures.registry`.
"""
