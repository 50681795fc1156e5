"""Pictures; matplotlib is loaded when the first one is drawn.

characterisation: Pictures of a characterisation: a shot with its fit, envelopes and frequency, every parameter shot by
    shot.
defects: Picture of a manufacturing defect like the paper's figures: its perpendicular force over its size.
diagnosis: Pictures of a diagnosis: what is left over before and after, in time, by frequency and by harmonic.
parameter_trace: Picture of a constant that moves along the ring-down: against time, amplitude and peak speed.
ramp: Picture of a ramp: z residual and deflection against the field, the threshold and the field to work at.
ring_down: Pictures of a ring-down for people who would rather look than read.
trend: Picture of a trend: each quantity over the months, and its control chart beside it.
sliding: The picture of sliding-window fits: what a complete model keeps constant, window by window, with errors.
"""
