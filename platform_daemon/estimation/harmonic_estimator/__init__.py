"""The second estimator: harmonics instead of a fit.

demodulation: Demodulation of a stretch of ring-down along the phase of a damped orbit: frequency, amplitude and
    their rates.
estimator: A ring-down read from its harmonics at constant cost: for live display, and as a cross-check of the fit.
"""
