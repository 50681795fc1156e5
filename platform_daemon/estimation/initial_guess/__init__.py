"""Start values from the data alone.

angle: Start values of an angle record: turning points give amplitude and phase, their decline the losses.
guess: Start values from the data alone: frequency, amplitude, phase, orientation and loss from one snapshot.
harmonic_fit: Harmonic amplitudes of a few periods: the local, model-free picture that start values are read from.
initial_state: What every search for start values returns.
"""
