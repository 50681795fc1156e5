"""Design equations of a resonator: what its magnets, masses and distances say it will do.  Pure; numpy and math only.

The equations are those of "Impact of Structural Design on Magneto-Mechanical Resonators", cited by the labels of its
LaTeX source.  Equilibrium, static defects and side modes will stand beside `expected.py`.  The simulated world has
implementations of its own, and a test holds the two against each other.

expected_inertia: Moment of inertia of the rotor, a homogeneous sphere, kg m^2.
expected_moment: Magnetic moment of the rotor, A m^2; measured, else by design.
expected_omega: Natural angular frequency at small angles, rad/s; measured, else by design.
"""

from .expected import expected_inertia, expected_moment, expected_omega

__all__ = ["expected_inertia", "expected_moment", "expected_omega"]
