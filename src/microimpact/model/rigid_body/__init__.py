"""The rigid body model, Sections 3.1 and 4.1: algebra of impulses, slopes, rough bodies."""
