"""Distributions and draws, designs and their effects, Sobol' indices, shares."""
