"""From a request in physical units to the sample-exact timeline, inside the safety envelope; pure functions only.

In the order of a request's way:

request.py    what a user asks for: one sequence in physical units
windows.py    its durations as whole samples, and the frequency that fits them
drive.py      the field at the rotor as a sine on each DAC output
limits.py     the safety envelope that every timeline must keep
compiler.py   all of it together: the timeline that the I/O card plays, and what was realised
tones.py      timelines of calibrations and of the self-test: plain tones, under the same limits
"""
