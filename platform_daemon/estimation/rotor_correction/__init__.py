"""Fits of one angle, corrected for what a rotor with a manufacturing error does beside it: in milliseconds.

polynomial: Polynomials of several variables.
coordinates: One-angle fits and rotors as vectors.
descent: Least squares from a known start.
motion: What one angle does, and what a rotor does beside it.
table: The correction, and how it is applied.
corrected_fit: The fit of a shot.
held: Errors that come from what an adopted model holds.
creation: From rotors that are drawn about a reference to the table, and its error.
"""
