"""The motion of the model: half cycles solved, tabulated and chained, or traced sample by sample.

basis_functions: The traced ring-down at sample times: basis functions of the observation, and their moments with
    the data.
collocation: One half cycle as a whole: the acceleration at Chebyshev nodes by Newton's method, with exact
    derivatives.
direct: A ring-down trajectory: the model with values for its dynamics, traced once, then sampled as often as
    needed.
direct_chain: A ring-down as a chain of half cycles, each integrated: the direct path, for any torque, with its
    derivatives.
dormand_prince: Coefficients of the 12-stage Runge-Kutta method of order 8 by Dormand and Prince (Hairer, Norsett,
    Wanner I, II.5).
half_cycle_chain: A ring-down as a chain of tabulated half cycles (half_cycle_table.py): where each begins, its
    duration, its size.
half_cycle_table: Half cycles tabulated over their amplitude: between two turning points one number, the size, tells
    everything.
half_cycle_walk: Half cycle after half cycle through a ring-down, by tables that are made on the way.
initial_conditions: The paper's label (phi_max, psi_start) of a start state, and its exact derivatives.
runge_kutta: One half cycle: from a turning point to the next, with exact derivatives.
state_at_zero: The state of a ring-down at t = 0, from the one or two half cycles that lead there.
table_range: Which half cycles the next table of a ring-down holds: those that are left, no further apart than makes
    sense.
turning_points: The turning points of a long ring-down, walked from half cycle to half cycle without looking inside.
"""
