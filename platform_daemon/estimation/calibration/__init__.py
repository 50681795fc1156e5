"""Calibrating the platform, arrays in and results out: phasors of tones, P, and the transmit side."""
