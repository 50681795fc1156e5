"""The rotor as a rigid body with five degrees of freedom: main mode, side modes, defects of manufacture.

Loaded only when such a resonator is mounted, so that a world without one compiles none of it.

dynamics.py      the rigid body behind the interface that every model of the rotor has
parameters.py    from the specimen's geometry, defects and friction to the parameters of the equations
acceleration.py  the equations of motion: dipoles, thread, jewel contact
integrator.py    one step of an explicit Runge-Kutta method, and what lies inside it
motion.py        marches through time and leaves pieces for the receive side
rest.py          where it hangs at rest
modes.py         main and side modes of small motions
"""
