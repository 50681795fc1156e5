"""The equation of motion of a resonator and what follows from it; torques/ are its terms, trajectory/ its exact
solutions.

driven: A rotor that a field drives in phase with its velocity: where the zeros of that field must lie.
mirror: The exact twin of a motion: phi -> -phi together with a half turn about e_u gives the same dm/dt.
models: Ring-down models as data: torque terms, what is observed, and what is known of the parameters beforehand.
orbit: The undamped orbit of the magnetic pendulum (equ:ODE_norm) in closed form: frequency and harmonic amplitudes.
quality: How well a resonator keeps its signal: quality factors, envelopes, frequency trace
    (ssec:quantifying_mmrs_quality).
ring_down: A ring-down whose parameters are all known: from a fit, or from published numbers.
rotation: Rotations by Rodrigues vectors, with the Jacobian that turns local into global errors.
"""
