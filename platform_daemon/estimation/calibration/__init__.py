"""Calibrating the platform, arrays in and results out: phasors of tones, P, the transmit side, and what they hold for.

apply: From volts to dm/dt: the inverse of u = -P dm/dt (eq:u(t,p,R)), corrected for the receive chain's response.
equaliser: A short filter that undoes the receive chain where the signal is, and leaves the rest alone.
phasors: Lock-in by least squares: the complex amplitude of a tone of known frequency, and how well it is known.
receive: P from the answers to a reference dipole: u = -P dm/dt (eq:u(t,p,R)), per channel, axis and frequency.
receiver_correction: Receiver effects of an adopted model, undone in the calibrated samples before a fit.
transmit: The transmit side from the answers of a field probe: field per volt at the DAC, per coil and frequency.
uncertainty: What the uncertainty of P does to a fitted m_r.
validity: Typed warnings about a calibration that is used outside what it was made for.
"""
