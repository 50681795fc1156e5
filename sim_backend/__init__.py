"""The simulated world: magnets, bearings, rotor dynamics, coils, receive chain, noise, faults; and its devices.

Read `world.py` for the whole and `shot.py` for one shot; then the resonator (`rotor`, `torque`, `collocation`,
`motion`, `trajectory`), the transmit side (`coils`, `drive`, `power`), the receive side (`contacts`, `chain`,
`receiver`, `noise`), and `variation`, `faults`, `truth`.  What nobody declares: `undeclared/` is the list,
`extra_torque`, `hidden` and `extra_signal` are the physics.  `study` plays shots without devices; `devices/` and
`backend.py` meet the contracts of `drivers`.  Nothing here knows the estimator.
"""
