"""What a diagnosis says in the end.

accepted_effects: Accepted effects with their evidence: strength, chance, what they gain on held-out data, what they
    look like.
experiment_design: What a measurement that has not been made would tell: its information on the effects, from the
    model alone.
missing_torque: The torque that is missing, as a smooth function of angle and velocity, with its band of
    uncertainty.
next_measurements: The next measurement: what separates effects that these data cannot tell apart, ranked by what it
    would bring.
notes: What the reader of a diagnosis should know besides.
residual_analysis: The anatomy of what a fit leaves over, as plain arrays: in time, by frequency, by harmonic, from
    shot to shot.
verdict: The verdict: from what is explained, what is left, and how sure both are.
"""
