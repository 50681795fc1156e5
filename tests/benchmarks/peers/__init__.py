"""Tools that others would take for the same task, on the same recordings by the same score: `make peers`.

columns: the torques a library of terms holds, with the sign that physics gives them.
datasets: measured angles and simulated dm/dt, each with its split; simulated: shots with a hidden effect.
states: angle, velocity and acceleration, as the peers that need derivatives get them.
score: one uninterrupted simulation by scipy, its start fitted to the training part: the same code for every row.
viscous, sindy, weak_form, operon, narmax, neural, ours: the rows.
routes: all rows by name; page: docs/evidence/peers.md.
"""
