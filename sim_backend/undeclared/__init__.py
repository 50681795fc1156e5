"""What the simulated world can contain without telling anybody: the tables `[[backends.simulated.undeclared]]`.

Neither the specimen nor the calibration knows these effects; only the truth of a shot names them.  The physics is in
`rotor/extra_torque.py`, `rotor/hidden.py` and `receive/extra_signal.py`; docs/configuration.md has all of them in a
table.

base.py           what every effect has in common
torques.py        torques, per inertia
hidden_states.py  torques with a state of their own, for which no list of candidates has a name
signals.py        errors and additions of the receive side
listing.py        the list of effects as it stands in the configuration
"""
