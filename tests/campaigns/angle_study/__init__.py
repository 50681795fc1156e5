"""Synthetic angle records of pendulums with an effect that nobody declared, and what the diagnosis makes of them.

__main__: The study as a program: python -m tests.campaigns.angle_study
bad_inputs: Files that are no ring-down of one angle, each bad in one way.
cases: Which effect, how strong it may be, and how it is drawn for record number k of a seed.
command: `platform-daemon diagnose` in a process of its own, with a limit of time and memory.
journal: What is finished of a study, as JSON lines.
motion: The parameters of a motion, and its trajectory by fixed steps of order 8: quick, for the fits.
page: The study as a page of the documentation.
peer: Least squares by scipy on the trajectory: visibility of an effect, and the best that can be predicted.
record: One record: truth, noise, quantisation, lost samples, and its file.
score: What the diagnosis says against what was drawn.
truth: The motion by scipy.integrate.solve_ivp, from turning point to turning point where friction is dry.

What makes the records imports nothing of this project.
"""
