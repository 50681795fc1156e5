"""The simulated world in time: one clamping unit, its history, and the truth that only a simulation has.

world.py           the state that all simulated devices share, thread-safe; read this first
clamping_unit.py   the content of the clamping unit: a rotor with its wear and its free decay, or an inserted device
shot_simulator.py  the running shot, computed when a result is first needed
shot.py            one shot as a pure function from its set-up to motion, currents and received signal
back_action.py     the closed transmit loops, which brake the rotor
clock.py           world time: real time, or as fast as the computer allows
variation.py       variations from shot to shot: temperature, friction, wear
faults.py          deliberate faults
truth.py           the truth of a shot, by the names of the paper and of the fit's report
side_motion.py     the true motion out of the plane, and the modes of small motions
warm_up.py         compiles the numba kernels before the first shot
"""
