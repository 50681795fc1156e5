"""The lab's devices as they look from their wires, all attached to one simulated world.

Read `emulator.py` for the whole.  I/O cards: `daq_server` and `conversation` (sockets), `daq_commands` (the command
table, `daq_*` its parts), `board` (state), `registers`, `sequence`, `playback` (what the registers make the outputs
do), `session` (what the boards play and record together), `sending`, `tape`.  Serial devices: `serial_port`, `switch`,
`lna`.  USB: `usb_server`, `usbtmc`, `amplifier`.  Things that go wrong on the wire: `wire_faults`.  A door for tests:
`control`.
"""
