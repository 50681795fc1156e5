"""Calibrating the platform, arrays in and results out: phasors of tones, P, the transmit side, and what they hold for.

phasors     lock-in: complex amplitude of a known tone with its standard deviation, from the scatter of segments
receive     P per channel, axis and frequency -> sensitivity and frequency response
transmit    field per volt per coil -> field per ampere and inductance
propagation the standard uncertainty of a fitted m_r that comes from that of P
validity    typed warnings about a calibration that is used for something else than it was made for

The shots are made by engine/work, the files written by store/calibrations.py.
"""
