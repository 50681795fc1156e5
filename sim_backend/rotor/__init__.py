"""The resonator and its motion: one degree of freedom to rounding error, or a rigid body with side modes.

rotor.py         from a specimen's physical parameters to the coefficients of its equation of motion
torque.py        every torque per inertia: the right-hand side of that equation
extra_torque.py  undeclared torques without a state of their own
hidden.py        undeclared torques with one: memory, a gap that breathes, a second mode
collocation.py   one step of Gauss-Legendre collocation, and the polynomials that come with it
rest.py          where it hangs at rest, and when it breaks loose from dry friction
motion.py        marches it through time in pieces, cut at every turning point
trajectory.py    reads angle and speed at any instant out of those pieces
dynamics.py      which of the two models moves a rotor, and what both can do
rigid_body/      the model with five degrees of freedom
decay.py         what is left of the swing at the next shot
kernel.py        the decorator of all numba kernels of the simulated world, and their cache
"""
