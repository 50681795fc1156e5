"""Least squares of the rotor of five degrees of freedom over the dm/dt of one shot, or of several together."""
