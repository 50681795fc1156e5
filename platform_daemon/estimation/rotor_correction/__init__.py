"""A fit of one angle that is corrected for a manufacturing error: what a rotor of five degrees of freedom does, in milliseconds.

polynomial: Polynomials of several variables.
coordinates: One-angle fits and rotors as vectors.
motion: What one angle does, and what a rotor does beside it.
table: The correction, and how it is applied.
corrected_fit: The fit of a shot.
creation: From rotors that are drawn about a reference to the table, and its error.
"""
