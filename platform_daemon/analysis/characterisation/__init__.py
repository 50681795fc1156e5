"""Many shots of one resonator in two windows, N50 and D30: the paper's tables and what its figures show.

characterise: Fit both windows, make the tables, choose the shot of the figures.
dataset: The fits of one window as a row of the paper's tables.
comparison: N50 against D30, shot by shot: paired t tests with Holm's correction.
notes: What is missing in a characterisation and why, and what may spoil its numbers, in words.
statistics: Mean, scatter, median and extremes of a quantity over shots.
"""
