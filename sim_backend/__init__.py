"""The simulated world: magnets, bearings, rotor dynamics, coils, receive chain, noise, faults; and its devices.

The package implements the contracts of `drivers` and imports neither the estimator nor the sequences: two independent
implementations of the same physics that agree are a proof.  The list goes from the bottom up; each package imports only
what is listed above it.

section.py       what all tables of the configuration have in common
hidden_effects/  effects that neither the specimen nor the calibration declares, as tables
options/         the configuration: the table `[backends.simulated]`, and the tables of its devices
rotor/           the resonator: design, torques, motion in pieces that are exact to rounding
transmit/        amplifier, coils and the current in them
receive/         switch contacts, receive chain, noise, LNA and ADC: from the motion to codes
world/           all of these together, in time: shots, faults, wear, temperature, truth
devices/         the world as a card, a switch, an amplifier and an LNA in this process
backend.py       the back end `simulated`, which offers these devices
emulators/       the same world behind the wires of the real devices
study.py         many shots for a study, without card, engine and file
"""
