"""From a request in physical units to the sample-exact timeline, inside the safety envelope; pure functions only.

The modules, in the order in which a request passes through them:

request.py    the request: one sequence in physical units
windows.py    durations in whole samples, and the frequency that fits them
lobes.py      the field's half periods: constant frequency, chirp, or planned by a model
drive.py      amplitude and phase of each coil's voltage for a field at the rotor
bursts.py     output of the card: one sine, a sine per half period, or levels
figures.py    peaks, I2t and energy, from the exact samples
limits.py     the safety envelope that every timeline must keep
compiler.py   the compiled timeline that the I/O card plays, with the realised values
tones.py      timelines of calibrations and of the self-test: plain tones, under the same limits
"""
