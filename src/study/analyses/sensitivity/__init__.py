"""Global sensitivity of the capture velocity: Sobol' indices beside the designed experiments."""
