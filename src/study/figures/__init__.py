"""Figures: each a function of tables, which computes no physics.

A figure function is called ``draw(tables, spec)`` with the tables of figure data by name and the
entry of the registry, and returns a `matplotlib.figure.Figure`; its docstring says what series mean
that are more than a curve or points. What is drawn where, and the words on it, are in
``config/figures.yaml``, read by `study.figures.registry`.
"""
