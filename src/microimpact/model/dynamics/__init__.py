"""The dynamic simulation, Section 3.2: normal motion, friction and spin, capture, rolling."""
