"""A rotor of five degrees of freedom: two of its bearing, three of its orientation; manufacturing errors and gravity."""
