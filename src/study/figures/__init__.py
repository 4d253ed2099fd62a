"""Common to all figures: how they are declared, one look, and their content as a table.

A figure is drawn in the ``draw`` module of its analysis.
"""
