"""The simulated devices: each is a thin face of the one `World`, speaking the contract of its kind.

io_card.py          the real-time I/O card
tx_rx_switch.py     the Tx/Rx switch
power_amplifier.py  the class-D power amplifier
lna.py              the low-noise amplifier
thermometer.py      the temperature sensor
reference.py        reference dipole and field probe, put in the rotor's place
"""
