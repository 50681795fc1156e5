"""What a diagnosis says in the end.

accepted_effects: Accepted effects with their evidence: strength, chance, what they gain on held-out data, what they
    look like.
experiment_design: What a measurement that has not been made would tell: its information on the effects, from the
    model alone.
knot_responses: How one shot answers if a parameter changes along it: a column for every knot of a trace, in compressed
    form.
missing_torque: The torque that is missing, as a smooth function of angle and velocity, with its band of
    uncertainty.
moving_parameters: Where the declared model lacks something: which of its constants is none along the ring-down.
neglected: An effect that is surely there beside those that were named, and too small beside them to be believed by
    its name.
next_measurements: The next measurement: what separates effects that these data cannot tell apart, ranked by what it
    would bring.
notes: What the reader of a diagnosis should know besides.
random_walk: Random walks seen through linear equations: does anything walk at all, how fast, and where was it when.
residual_analysis: The anatomy of what a fit leaves over, as plain arrays: in time, by frequency, by harmonic, from
    shot to shot.
trace_equations: All parameters that may move, of all groups of shots that start alike, in one set of linear equations.
trace_shapes: What a moving parameter goes with: amplitude, peak speed or time; which simple law of it explains its
    motion best.
verdict: The verdict: from what is explained, what is left, and how sure both are.
"""
