"""The simulated world: magnets, bearings, rotor dynamics, coils, receive chain, noise, faults; and its devices.

It meets the contracts of `drivers` and knows neither the estimator nor the sequences: two implementations of the same
physics that agree are a proof.  From the bottom up; each room imports only what stands above it in this list:

section.py   what all tables of its configuration have in common
undeclared/  what the world can contain without telling anybody, as tables
options/     what it can be told: the table `[backends.simulated]`, and the tables of its devices
rotor/       the resonator: design, torques, motion in pieces that are exact to rounding
transmit/    amplifier, coils and the current in them
receive/     switch contacts, receive chain, noise, LNA and ADC: from the motion to codes
world/       all of it in one place and in time: shots, faults, wear, temperature, truth
devices/     the world as a card, a switch, an amplifier, an LNA in this process
backend.py   the back end `simulated`, which offers them
emulators/   the same world behind the wires of the real devices
study.py     many shots for a study, without card, engine and file
"""
