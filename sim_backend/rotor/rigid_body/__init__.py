"""The rotor as a rigid body with five degrees of freedom: main mode, side modes, manufacturing defects.

The package is loaded only when such a resonator is mounted, so that a world without one does not compile it.

dynamics.py      the rigid body as a `rotor.dynamics.Dynamics`
parameters.py    from the specimen's geometry, defects and friction to the parameters of the equations
acceleration.py  the equations of motion: dipoles, thread, jewel contact
integrator.py    one step of an explicit Runge-Kutta method, with dense output
motion.py        integrates the motion in pieces for the receive side
rest.py          the equilibrium
modes.py         main and side modes of small motions
"""
