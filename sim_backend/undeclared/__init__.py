"""What the simulated world can contain without telling anybody: the tables `[[backends.simulated.undeclared]]`.

Neither the specimen nor the calibration knows these effects; only the truth of a shot names them.  `torques`,
`hidden_states` and `signals` say what each one is, `listing` is the list; the physics is in `extra_torque`, `hidden`
and `extra_signal` of this room.  docs/configuration.md has all of them in a table.
"""
