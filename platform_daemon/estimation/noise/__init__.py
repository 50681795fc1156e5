"""The noise of a record or a series: per channel, its spectrum, what stands steadily in it.

angle: Noise of an angle: from high differences of its samples, because an oscillation is smooth and noise is not.
coloured: The noise that counts: its level at the signal's harmonics, as far as the measured spectrum can tell it
    from white.
level_uncertainty: How well the level of a measured noise is known: by the number of independent values that it was
    taken from.
model: Noise of every channel, measured beside the signal: between and above its harmonics, not from a fit's
    residual.
series: One noise model for a series of shots: from blank ones where there are any, else from between the harmonics
    of all.
tones_and_drift: What stands in a residual and is no ring-down: steady tones such as mains hum, and slow drift.
welch: Averaged power densities of overlapping segments, with the number of independent values behind every average.
"""
