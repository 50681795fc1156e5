"""Effects that a diagnosis has names for, one module per kind.

additive: Additive effects stand in the data beside the signal: tones, decaying oscillations, decaying offsets.
clock: A gap in the clock is no physics: it is found by data_integrity.py, mended, and reported under its name.
effect: What the diagnosis knows of an effect: its id, its sign rule, how it shows, what would separate it, and who
    found it.
kick: A kick: somebody touches the table, and the swing goes on with another velocity.
receiver: Receiver effects act on the whole signal: gains, delays, poles, crosstalk, compression.
torque: Torque effects: the terms of estimation/physics/torques that the declared models lack, with their sign
    rules.
"""
