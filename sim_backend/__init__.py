"""The simulated world: magnets, bearings, rotor dynamics, coils, receive chain, noise, faults; and its devices.

Read `world.py` for the whole, `shot.py` for one shot, then: `rotor`, `torque`, `collocation`, `motion`, `trajectory` (the
resonator), `coils`, `drive`, `power` (transmit), `contacts`, `chain`, `receiver`, `noise` (receive), `variation`, `faults`,
`truth`.  The contracts of `drivers` are met in `devices/` and `backend.py`.  Nothing here knows the estimator.
"""
