"""Which effects are looked for, and which are taken.

clock_gaps: Samples that clocks have lost are put back: first those that the samples themselves show, then what
    physics shows.
component_search: Places where something may stand beside the signal: frequencies and decay times, found in what
    fits leave over.
confounders: Effects that cannot be told apart on these data: what could stand in the place of an accepted one.
data_integrity: What is wrong with the data themselves, before any physics is asked: gaps in the clock, saturation,
    copies.
kick_search: Where a kick would explain most of what is left of a single recorded swing.
local_swing: A few periods of any swing as a sum of harmonics of slowly changing size, with samples lost in the
    middle or not.
omnibus_test: Everything that may be missing and has no name: any smooth torque, any slow change of any harmonic.
phase_steps: Samples that a clock has lost, seen in the samples themselves: the swing goes on, but later than it
    should.
refits: Refits while effects are sought: with another hypothesis, and with hidden scales and places at their best.
scales: Hidden scales of accepted effects by refits: where chi^2 is least, and how the strength moves with the scale.
sign_constraints: Sign rules: strengths that physics allows, and losses that must not feed energy into the motion.
significance: How surprising a gain is, after correction for everything that was tried, on a logarithmic scale.
stepwise: Which effects explain what is left: score tests of everything, refits of the leaders, alone and in
    combination.
subsets: Sets of candidates with what a linear step in them would gain, the best first.
tone_free_noise: Noise without the steady tones that stand in the residual: these are to be explained, not to be
    weighted with.
torque_sets: Torques first: every torque and every pair of torques fitted, under sign rules, the best kept if it is
    worth it.
"""
