"""Studies of Section 3: rigid body, dynamic simulation, calibration, empirical equations."""
