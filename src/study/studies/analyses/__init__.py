"""Studies of Section 4 and beyond: rough surfaces, Monte Carlo, designed experiments."""
