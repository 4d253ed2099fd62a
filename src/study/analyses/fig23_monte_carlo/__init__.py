"""Monte Carlo analysis of impacts on a rough surface (Section 4.2, Fig. 23)."""
