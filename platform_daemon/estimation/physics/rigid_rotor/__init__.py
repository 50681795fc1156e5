"""A rotor of five degrees of freedom, two of its bearing and three of its orientation, with manufacturing errors."""
