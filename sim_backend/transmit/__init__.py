"""The transmit side: from the DAC to the field at the rotor.

power.py  state of the power amplifier: enable, mute, faults, heat
drive.py  amplifier with its limit and R-L loop, solved exactly: the current in every coil
coils.py  the Helmholtz pairs: field by Biot-Savart, and by reciprocity their sensitivity to the rotor's moment
"""
