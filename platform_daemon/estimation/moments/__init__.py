"""What the samples say about a motion: one pass over them, half cycle by half cycle.

basis: The model's basis at chosen places, from the tables of half cycles that a pass over the samples has left
    behind.
direct: Moments of a window by the direct path: the basis itself, sample by sample.
kernels: Sums over the samples of a half cycle, and over its nodes: the inner loops of tabulated.py.
model_signal: The fitted signal at chosen places, from the tables of half cycles that a pass over the samples has
    left behind.
tabulated: Moments of the data with the model's basis (basis_functions.py), half cycle by half cycle, without
    visiting the basis at the samples.
workspace: Moments of a window with a trajectory: picks the grids, and keeps tables between the passes of a fit.
"""
