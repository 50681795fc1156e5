"""Devices that speak SCPI over USB (USBTMC), a serial line or TCP.  A new one needs only a table of its commands.

options.py     tables: how to reach the device, and its commands
wires.py       which wire, and TCP; serial lines come from drivers.serial_line
usb_wire.py    USBTMC
lines.py       what a device sent as one line of text
dialogue.py    asking with a table of commands and answers
amplifier.py, lna.py   the devices
backend.py     the back end `scpi`, with the thermometer
"""
