"""Physics of one impact: pure functions, arrays in and out, SI units."""
