"""Serial devices on pseudo-terminals, as docs/reference/wiring.md describes them.

serial_port.py  lines in, one reply line each out, faults of the wire
switch.py       the Tx/Rx switch's controller
lna.py          the low-noise amplifier's controller
"""
