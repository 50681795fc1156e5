"""Devices on a serial line: Tx/Rx switch and LNA, as docs/reference/wiring.md describes them.

wire.py        a serial port that carries lines of ASCII
controller.py  asking: every command has one answer, errors are `ERR number,"text"`
switch.py      the Tx/Rx switch
lna.py         the LNA
backend.py     the back end `serial` and its tables
"""
