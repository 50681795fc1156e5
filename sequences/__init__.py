"""From a request in physical units to the sample-exact timeline, inside the safety envelope; pure functions only.

In the order of a request's way:

request.py    what a user asks for: one sequence in physical units
windows.py    its durations as whole samples, and the frequency that fits them
lobes.py      the field's half periods: constant frequency, chirp, or planned by a model
drive.py      amplitude and phase of each coil's voltage for a field at the rotor
bursts.py     what the card plays: one sine, a sine per half period, or levels
figures.py    peaks, I2t and energy, from the exact samples
limits.py     the safety envelope that every timeline must keep
compiler.py   all of it together: the timeline that the I/O card plays, and what was realised
tones.py      timelines of calibrations and of the self-test: plain tones, under the same limits
"""
