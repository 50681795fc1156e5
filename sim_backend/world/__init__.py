"""The simulated world in time: one clamping unit, what happens to it, and what only the simulation knows.

world.py          the devices' common reality, thread-safe; read this first
clamping_unit.py  what sits in it: a rotor, which wears and swings on, or something in its place
player.py         the shot that runs, computed when somebody first needs it
shot.py           one shot as a pure function: set-up and commands in, what happened and was heard out
clock.py          real time, or as fast as the computer can
variation.py      what changes from shot to shot: temperature, friction, wear
faults.py         things that go wrong on purpose
incidents.py      when power could reach the coils, and every time the interlock failed
truth.py          the truth of a shot, in the words of the paper and of the fit's report
side_motion.py    the true motion out of the plane, and the modes of small motions
warm_up.py        compiles the numba kernels ahead of the first shot
"""
