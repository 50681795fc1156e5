"""Effects that the simulated world contains but does not declare: the tables `[[backends.simulated.undeclared]]`.

The specimen and the calibration do not contain these effects; only the truth of a shot names them.  So a diagnosis can
be tested blindly.  The physics is in `rotor/extra_torque.py`, `rotor/internal_state.py` and `receive/extra_signal.py`;
docs/reference/configuration.md lists all effects in a table.

base.py             what every effect has in common
torques.py          torques, per inertia
internal_states.py  torques with internal state variables, for which the diagnosis has no candidate
signals.py          errors and additions of the receive side
listing.py          the list of effects in the configuration
"""
