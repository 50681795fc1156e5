"""The simulated devices: each implements the contract of its kind on the shared `World`.

io_card.py          the real-time I/O card
tx_rx_switch.py     the Tx/Rx switch
power_amplifier.py  the class-D power amplifier
lna.py              the low-noise amplifier
reference.py        reference dipole and field probe, inserted in place of the rotor
"""
