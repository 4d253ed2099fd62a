"""Distributions and draws, designs and their effects, shares."""
