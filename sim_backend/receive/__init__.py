"""The receive side: from the motion of the rotor to the codes of the ADC.

shot_setup.py        everything that decides a shot before it is played
contacts.py          where the contacts of the Tx/Rx switch are: dead time, bounce, being stuck
chain.py             the frequency response of the receive chain, applied exactly
noise.py             white or coloured noise, and mains hum
receiver.py          all of it together, with LNA limit and ADC
extra_signal.py      undeclared errors and additions
reference_dipole.py  the dipole that can stand in the rotor's place
inserted.py          what is heard of it, and the field that a probe there measures
calibration.py       the calibration that the simulated platform ships with
"""
