"""The receive side: from the motion of the rotor to the codes of the ADC.

shot_setup.py        everything that determines a shot before it is simulated
relay_contacts.py    position of the contacts of the Tx/Rx switch: dead time, bounce, stuck contacts
response.py          the frequency response of the receive chain, as a table
chain.py             the same response, applied exactly to the rotor's signal
noise.py             white or coloured noise, and mains hum
receiver.py          the whole receive side, with LNA limit and ADC
extra_signal.py      hidden errors and additions
reference_dipole.py  the dipole that can be inserted in place of the rotor
inserted.py          the signal of the inserted dipole, and the field at an inserted probe
calibration.py       the calibration that belongs to the simulated platform
"""
