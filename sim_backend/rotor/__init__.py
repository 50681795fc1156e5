"""The resonator and its motion: one degree of freedom to rounding error, or a rigid body with side modes.

rotor.py           from a specimen's physical parameters to the coefficients of its equation of motion
torque.py          every torque per inertia: the right-hand side of that equation
extra_torque.py    hidden torques without an internal state
internal_state.py  hidden torques with an internal state: memory, a breathing gap, a second mode
collocation.py     one step of Gauss-Legendre collocation, and the polynomials that it uses
rest.py            equilibrium of the rotor, and its release from dry friction
pieces.py          the layout of a motion's pieces and the state at its end, without the kernels
motion.py          integrates the motion in pieces that end at every turning point
trajectory.py      evaluates angle and speed at any instant from those pieces
dynamics.py        the interface of both models, and the choice between them
rigid_body/        the model with five degrees of freedom
decay.py           the free decay between two shots
kernel.py          the decorator of all numba kernels of the simulated world, and their cache
"""
