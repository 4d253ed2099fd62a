"""The law of normal impacts as a table: similarity, pieces, interpolation to a stated error."""
